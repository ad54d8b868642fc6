"""The keys of a scenario that a campaign varies, and the scenario with other values for them.

1. A path names a key, such as `wind.east_mps` or `obstacles.crate.circle.east_m`.
2. An entry of a list is named by its `name`, or by its number from 0 if it has none.
3. A key that the file leaves out may be varied too; an entry of a list must exist.
4. The path of a whole entry takes only `chance`: the entry is present in some rows and absent in
   others.
"""

from __future__ import annotations

import copy
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from companion.documents import Document, did_you_mean, schema_at
from companion.errors import MissionError
from sitl.world.distributions import Chance, Distribution, Normal, Uniform, Value
from sitl.world.schema import ScenarioModel
from sitl.world.vary_schema import VaryEntry, distribution

Data = Mapping[str, Any]
Values = Mapping[str, Value]
"""Path of a key -> its value in a row."""
_LISTED = 9
"""Up to this many whole numbers are listed; of a longer range, about as many, evenly spaced."""
_FILES: Mapping[tuple[str | int, ...], str] = {
    ("map",): "fly a campaign for each map",
    ("vehicle",): "write vehicle: {profile: NAME}, and vary its keys, e.g. vehicle.radius_m",
    ("vehicle", "profile"): "vary other keys of the vehicle, e.g. vehicle.radius_m",
}
"""Keys that name a file, which is not stored with a campaign's rows -> what to do instead."""
_LEFT_OUT = "what needs it may be left out instead, such as an event of it by {chance: ...}"


@dataclass(frozen=True, slots=True)
class Factor:
    """A key that is varied.

    Attributes:
        path: the path of the key.
        keys: the path as keys and indices of entries.
        distribution: the distribution of its values.
        usual: the value in the file itself; None if absent, or for an entry.
        is_entry: whether it is a whole list entry, present or absent.
    """

    path: str
    keys: tuple[str | int, ...]
    distribution: Distribution
    usual: Value | None
    is_entry: bool = False

    @property
    def is_range(self) -> bool:
        """Whether any number between two of its values is also possible."""
        return isinstance(self.distribution, Uniform | Normal)


def read_factors(
    entries: Mapping[str, VaryEntry], document: Document, read: Callable[[Data], object]
) -> tuple[Factor, ...]:
    """The factors of a scenario, in the order of the file.

    Args:
        entries: the content of its key `vary`.
        document: the whole file.
        read: parses the data of a scenario; each factor is tried at its extremes.

    Raises:
        MissionError: a path leads nowhere, or its key cannot take all these values.
    """
    data = document.data()
    assert isinstance(data, dict)
    factors = tuple(_factor(path, entry, data, document) for path, entry in entries.items())
    first: dict[tuple[str | int, ...], str] = {}
    for factor in factors:
        if (other := first.setdefault(factor.keys, factor.path)) != factor.path:
            raise MissionError(
                f"{factor.path} and {other} are one key",
                document.key_at("vary", factor.path),
                "keep one of them",
            )
    for factor in factors:
        for value in factor.distribution.extremes:
            try:
                read(with_values(data, factors, {factor.path: value}))
            except MissionError as error:
                whole = _as_whole_numbers(factor, data, factors, read)
                raise MissionError(
                    f"{factor.path} cannot be {_shown(factor, value)}: {error.what}",
                    document.where("vary", factor.path),
                    _LEFT_OUT if factor.is_entry else whole or error.hint,
                ) from error
    return factors


def _as_whole_numbers(
    factor: Factor, data: Data, factors: Sequence[Factor], read: Callable[[Data], object]
) -> str:
    """The hint for a range whose key takes only whole numbers; "" for other keys."""
    if not isinstance(factor.distribution, Uniform | Normal):
        return ""
    numbers = range(math.ceil(factor.distribution.low), math.floor(factor.distribution.high) + 1)

    def takes(number: float) -> bool:
        try:
            read(with_values(data, factors, {factor.path: number}))
        except MissionError:
            return False
        return True

    if not numbers or takes(float(numbers[0])) or not takes(numbers[0]):
        return ""
    some = [*numbers[:: len(numbers) // _LISTED], numbers[-1]] if numbers[_LISTED:] else numbers
    listed = ", ".join(map(str, dict.fromkeys(some)))
    return f"a range has any numbers: write {{choice: [{listed}]}}"


def with_values(data: Data, factors: Sequence[Factor], values: Values) -> dict[str, Any]:
    """The data of a scenario with other values, and without the key `vary`.

    Args:
        data: the data of the file.
        factors: the factors of the same file.
        values: the values of some factors; the others keep the file's values.
    """
    varied = copy.deepcopy({key: value for key, value in data.items() if key != "vary"})
    chosen = [factor for factor in factors if factor.path in values]
    for factor in chosen:
        if not factor.is_entry:
            _put(varied, factor.keys, values[factor.path])
    missing = [factor.keys for factor in chosen if factor.is_entry and not values[factor.path]]
    for keys in sorted(missing, key=_is_left_out_late):
        parent: Any = varied
        for key in keys[:-1]:
            parent = parent[key]
        del parent[keys[-1]]
    return varied


def _is_left_out_late(keys: Sequence[str | int]) -> tuple[int, int]:
    """Sort key for removals: contents before their entry, later entries before earlier ones."""
    return -len(keys), -int(keys[-1])


def _put(data: Any, keys: Sequence[str | int], value: Value) -> None:
    for key in keys[:-1]:
        if isinstance(data, dict) and data.get(str(key)) is None:
            data[str(key)] = {}
        data = data[key]
    data[keys[-1]] = value


def _shown(factor: Factor, value: Value) -> str:
    return "left out" if factor.is_entry and not value else str(value)


def _factor(path: str, entry: VaryEntry, data: Data, document: Document) -> Factor:
    here: Any = data
    keys: list[str | int] = []
    for step in path.split("."):
        if isinstance(here, list):
            keys.append(_entry_of(here, step, path, document))
            here = here[int(keys[-1])]
        elif isinstance(here, dict) or here is None:
            if here is None and _is_list(keys):
                raise MissionError(
                    f"{path}: the file has no {'.'.join(map(str, keys))}",
                    document.key_at("vary", path),
                    "an entry of a list has to be there to be varied",
                )
            keys.append(step)
            here = here.get(step) if here else None
        else:
            raise MissionError(
                f"{path} leads into a value, not to a key",
                document.key_at("vary", path),
                _FILES.get(tuple(keys)) or f"write {'.'.join(str(key) for key in keys)}",
            )
    if tuple(keys) in _FILES:
        raise MissionError(
            f"{path} names a file, and cannot be varied",
            document.key_at("vary", path),
            _FILES[tuple(keys)],
        )
    chosen = distribution(entry, path, document)
    is_entry = isinstance(keys[-1], int) and isinstance(here, dict)
    if isinstance(here, dict | list) and not (is_entry and isinstance(chosen, Chance)):
        raise MissionError(
            f"{path} is not a single value",
            document.key_at("vary", path),
            "name one of its keys; an entry of a list may be varied by {chance: 0.5} alone",
        )
    usual = here if isinstance(here, bool | int | float | str) else None
    return Factor(path, tuple(keys), chosen, usual, is_entry)


def _is_list(keys: Sequence[str | int]) -> bool:
    """Whether the scenario has a list at these keys."""
    return schema_at(ScenarioModel.model_json_schema(), tuple(keys)).get("type") == "array"


def _entry_of(entries: list[Any], step: str, path: str, document: Document) -> int:
    names = [each.get("name", "") if isinstance(each, dict) else "" for each in entries]
    if step in names:
        return names.index(step)
    if step.isdecimal() and int(step) < len(entries):
        return int(step)
    known = [name for name in names if name]
    numbered = (
        f"entries are named, or numbered from 0 to {len(entries) - 1}"
        if entries
        else "the list is empty"
    )
    raise MissionError(
        f"{path}: there is no entry {step}",
        document.key_at("vary", path),
        f"{numbered}. {did_you_mean(step, known)}".strip(),
    )
