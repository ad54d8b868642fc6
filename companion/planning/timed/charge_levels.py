"""The charge as one more label of the search: the energy missing from a full battery.

It behaves like a clock: smaller is better, flights make it larger, a charge sets it. Each position
keeps the reserve and the energy to reach a safe place. Only a few levels to charge to are tried. A
step that charges is given the time from the lowest level for which it is meant. So all plans that
are found are correct, but some plans are not found.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from companion.mission.facts import at
from companion.planning.builtin.product import Product
from companion.planning.charger import Charger
from companion.planning.domain import WAIT, Action
from companion.planning.lasso import Energy
from companion.planning.timed.timed_step import TimedStep

LEVELS = 5
"""The number of steps into which the levels above the floor of a dock are divided."""
_NEVER = -1


class ChargeLevels:
    """How steps change the charge.

    Attributes:
        full: the highest level.
        missing: what is missing from it now.

    Args:
        energy: the energy of the problem.
        product: the product of the problem.
        in_loop: whether this is for loops, not for the path into one.
        more: additional levels to charge to.
    """

    def __init__(
        self,
        energy: Energy,
        product: Product,
        in_loop: bool = True,
        more: frozenset[int] = frozenset(),
    ) -> None:
        self._energy, self._product, self._in_loop = energy, product, in_loop
        self._more = more
        self.full = len(energy.percents) - 1
        self.missing = self.full - energy.level
        self._bits = {place: product.bit(at(place)) for place in energy.floors}
        self._most: dict[int, int] = {}

    def after(self, missing: int, step: TimedStep) -> int | None:
        """What is missing after a step; None if the step takes too much."""
        if step.charge is not None:
            needs, leaves = step.charge
            if self.full - missing < needs:
                return None
            missing = self.full - leaves
        else:
            missing += step.drain
        return missing if missing <= self.most_missing(step.end) else None

    def most_missing(self, state: int) -> int:
        """The most that may be missing at a state; negative if no safe place can be reached."""
        found = self._most.get(state)
        if found is None:
            place = self.place(state)
            floor = self._energy.floor(place, self._in_loop)
            found = self._most[state] = _NEVER if floor is None else self.full - floor
        return found

    def most_missing_at_rest(self, state: int) -> int:
        """The most that may be missing where the vehicle rests for ever, which means to land."""
        needed = self._energy.rests.get(self.place(state))
        return _NEVER if needed is None else self.full - needed

    def place(self, state: int) -> str:
        """Where the vehicle is; "" for nowhere."""
        held = self._product.facts(state)
        return next((place for place, bit in self._bits.items() if held & bit), "")

    def most_before(self, missing: int, step: TimedStep) -> int:
        """The most that may be missing before a step, given the most after it."""
        if step.charge is not None:
            return self.full - step.charge[0]
        return min(missing, self.most_missing(step.end)) - step.drain

    def needed(self, missing: int, step: TimedStep) -> int:
        """The level that a beginning needs for a step.

        Args:
            missing: the energy taken since the beginning.
            step: the step after that.
        """
        if step.charge is not None:
            return missing + step.charge[0]
        return missing + step.drain + self.full - self.most_missing(step.end)

    def steps(self, step: TimedStep, action: Action) -> Iterator[TimedStep]:
        """The forms of a step on a battery: with its energy, or one for each way to charge."""
        charger = action.charger
        if charger is None:
            yield step._replace(drain=self._energy.rest if action is WAIT else action.drain)
            return
        charger = self._charger(charger)
        for needs, leaves in _choices(charger, self._more):
            took_ms = charger.service_ms(needs, leaves)
            yield step._replace(cost_ms=took_ms, duration_ms=took_ms, charge=(needs, leaves))

    def _charger(self, charger: Charger) -> Charger:
        """A dock, with the level that it keeps here."""
        is_bare = self._energy.is_short and not self._in_loop
        return charger.bare or charger if is_bare else charger

    def from_least(self, step: TimedStep, action: Action) -> TimedStep:
        """The step; if it charges, it may begin with the lowest level that its dock allows."""
        if step.charge is None or action.charger is None:
            return step
        return step._replace(charge=(action.charger.floor, step.charge[1]))

    def trimmed(
        self, steps: Sequence[TimedStep], latest: Sequence[int], actions: Sequence[Action]
    ) -> list[TimedStep]:
        """The lap, with no charge higher than necessary.

        Args:
            steps: the steps of the lap.
            latest: by step, the most that may be missing before it, if each charge may begin with
                the lowest level that its dock allows.
            actions: the actions of the problem.
        """
        leaves = {
            place: self.full - min(latest[(place + 1) % len(steps)], self.most_missing(step.end))
            for place, step in enumerate(steps)
            if step.charge is not None
        }
        level, found = 0, list(steps)
        for place, step in [*enumerate(steps), *enumerate(steps)]:  # the first for the level
            if place not in leaves:
                level -= step.drain
                continue
            charger = actions[step.action].charger
            assert charger is not None
            needs = max(level, charger.floor)
            found[place] = charging(step, charger, needs, leaves[place])
            level = leaves[place]
        return found

    def trimmed_path(
        self, steps: Sequence[TimedStep], latest: int, actions: Sequence[Action]
    ) -> list[TimedStep]:
        """The path into a lap, with no charge higher than necessary.

        Args:
            steps: the steps of the path.
            latest: the most that may be missing where it ends.
            actions: the actions of the problem.
        """
        leaves: dict[int, int] = {}
        for place, step in reversed([*enumerate(steps)]):
            if (charger := actions[step.action].charger) is not None and step.charge is not None:
                leaves[place] = self.full - min(latest, self.most_missing(step.end))
                step = step._replace(charge=(self._charger(charger).floor, leaves[place]))
            latest = self.most_before(latest, step)
        level, found = self.full - self.missing, list(steps)
        for place, step in enumerate(steps):
            if place not in leaves:
                level -= step.drain
                continue
            charger = actions[step.action].charger
            assert charger is not None
            needs = max(level, self._charger(charger).floor)
            least = needs - charger.landing - charger.take_off
            level = max(least, leaves[place])
            found[place] = charging(step, charger, needs, level)
        return found


def charging(step: TimedStep, charger: Charger, needs: int, leaves: int) -> TimedStep:
    """The step, if it charges from one level or more to another level."""
    took_ms = charger.service_ms(needs, leaves)
    return step._replace(cost_ms=took_ms, duration_ms=took_ms, charge=(needs, leaves))


def levels_of(actions: Sequence[Action]) -> frozenset[int]:
    """The levels to which some actions of a plan charge."""
    return frozenset(action.charge_to for action in actions if action.charge_to is not None)


def _choices(charger: Charger, more: frozenset[int]) -> Iterator[tuple[int, int]]:
    room = charger.highest - charger.floor
    if room <= 0:
        return
    levels = sorted({charger.floor + room * part // LEVELS for part in range(LEVELS + 1)})
    for needs in levels:
        for leaves in sorted(more.union(levels)):
            if needs < leaves <= charger.highest:
                yield needs, leaves
