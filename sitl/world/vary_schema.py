"""The pydantic models of the key `vary` of a scenario: which keys a campaign varies, and how.

vary:
  wind.east_mps: [-3, 3]                                   # any number of the range
  battery.charge: {normal: [0.9, 0.05], within: [0.7, 1]}
  payload.answers.0.result: {choice: [ACCEPTED, FAILED], weights: [3, 1]}
  happens.2: {chance: 0.3}                                 # the entry is there in 30 % of rows
"""

from __future__ import annotations

from typing import Annotated

from companion.documents import Document
from companion.errors import KeyPath, Location, MissionError
from sitl.world.distributions import TAILS, Chance, Choice, Distribution, Normal, Uniform, Value
from sitl.world.schema_fields import Strict, described

Range = Annotated[tuple[float, float], described("[least, greatest]")]


class DistributionModel(Strict):
    """A distribution: one of `normal`, `choice` and `chance`."""

    normal: Annotated[
        tuple[float, float] | None, described("a number: [mean, standard deviation]")
    ] = None
    within: Annotated[
        Range | None,
        described("where a normal distribution is cut off; by default at 4 deviations"),
    ] = None
    choice: Annotated[
        tuple[bool | int | float | str, ...] | None,
        described("one of these values", min_length=1),
    ] = None
    weights: Annotated[
        tuple[float, ...] | None,
        described("how often each value is taken; by default all equally often"),
    ] = None
    chance: Annotated[
        float | None,
        described(
            "the share of the rows in which the key is true, or the entry exists", ge=0, le=1
        ),
    ] = None


VaryEntry = Range | DistributionModel


def distribution(entry: VaryEntry, path: str, document: Document) -> Distribution:
    """The distribution that an entry describes.

    Args:
        entry: an entry of the key `vary`.
        path: the entry's own key.
        document: to locate a mistake.

    Raises:
        MissionError: its numbers contradict each other.
    """
    where = document.where("vary", path)
    if not isinstance(entry, DistributionModel):
        low, high = entry
        if not low < high:
            raise MissionError(f"{path} has an empty range", where, "[least, greatest]")
        return Uniform(low, high)
    given = [entry.normal, entry.choice, entry.chance]
    is_cut_alone = entry.within is not None and entry.normal is None
    is_weighed_alone = entry.weights is not None and entry.choice is None
    if sum(each is not None for each in given) != 1 or is_cut_alone or is_weighed_alone:
        raise MissionError(
            f"{path} is not one distribution",
            where,
            "[least, greatest], {normal: [mean, deviation], within: [least, greatest]}, "
            "{choice: [...], weights: [...]} or {chance: share}",
        )
    if entry.chance is not None:
        return Chance(entry.chance)
    if entry.choice is not None:
        return _choice(entry.choice, entry.weights, path, where)
    assert entry.normal is not None
    return _normal(*entry.normal, entry.within, path, where)


def _choice(
    values: tuple[Value, ...],
    weights: tuple[float, ...] | None,
    path: str,
    where: Location | KeyPath,
) -> Choice:
    weights = weights or (1.0,) * len(values)
    if len(weights) != len(values) or min(weights) < 0 or sum(weights) <= 0:
        raise MissionError(
            f"the weights of {path} do not fit its {len(values)} values",
            where,
            "one for each value, none below 0, and not all 0",
        )
    return Choice(values, weights)


def _normal(
    mean: float,
    deviation: float,
    within: tuple[float, float] | None,
    path: str,
    where: Location | KeyPath,
) -> Normal:
    reach = TAILS * deviation
    low, high = within or (mean - reach, mean + reach)
    if deviation <= 0 or not low < high or low > mean + reach or high < mean - reach:
        raise MissionError(
            f"{path} has no values",
            where,
            "normal: [mean, deviation] with a deviation above 0; within: [least, greatest], "
            "not beyond 4 deviations",
        )
    return Normal(mean, deviation, low, high)
