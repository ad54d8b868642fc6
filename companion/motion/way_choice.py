"""At which clearance a place is flown to: more of it may make the way longer, but not by much.

Any way at the highest level would be flown whatever it costs, four times as long for a tenth of a
metre more beside one gap. So where all of what is added makes the way more than a tenth longer, two
thirds of it are enough: two deviations of the position in place of three. Where no way keeps as
much, it is the highest level that leads there.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

from companion.geometry import NorthEast
from companion.motion.clearance_level import ClearanceLevel, WayEntry, is_enough

DETOUR = 1.1
"""A way so many times as long is flown for the sake of what is added to the clearance."""


@dataclass
class WayAt:
    """A way at one clearance; what is asked for is searched then, and once.

    Args:
        level: of the way.
        start: of the way.
        place: where it leads.
    """

    level: ClearanceLevel
    start: NorthEast
    place: str

    @cached_property
    def entry(self) -> WayEntry | None:
        """Where it enters free cells; None if no way leads there."""
        return self.level.entry(self.start, self.place)

    @property
    def length_m(self) -> float:
        """Its length in the plane; inf if no way leads there."""
        return math.inf if self.entry is None else self.entry.length_m


def decisive_ways(
    levels: Sequence[ClearanceLevel], start: NorthEast, place: str, straight_m: float
) -> Iterator[WayAt]:
    """The ways that decide on which one is flown; each may be searched before it is looked at.

    The last one is flown: that at the highest level at which it is not DETOUR times as long as
    where ENOUGH_SHARE of what is added is kept. A way is no shorter at a higher level, nor than a
    straight line.

    Args:
        levels: the highest first.
        start: of the way.
        place: where it leads.
        straight_m: the straight line there.
    """
    ways = [WayAt(level, start, place) for level in levels]
    yield ways[0]
    is_direct = ways[0].length_m <= DETOUR * straight_m
    if is_direct or not levels[-1].is_connected(start, place):
        return
    least_m = levels[-1].clearance_m
    added_m = levels[0].clearance_m - least_m
    *_, enough = (way for way in ways if is_enough(way.level.clearance_m - least_m, added_m))
    yield enough
    most_m = DETOUR * enough.length_m
    for way in ways:
        yield way
        if math.isfinite(way.length_m) and way.length_m <= most_m:
            return
