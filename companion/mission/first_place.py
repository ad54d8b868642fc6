"""Checks that a mission in metres begins at [0, 0], and says how to change one that does not.

A mission's metres count from where the vehicle stands when its first flight since the autopilot's
start begins. So a mission that begins elsewhere is refused at its start, because its walls would be
in the wrong place. The author can shift its figures so that it begins at [0, 0].
"""

from __future__ import annotations

import math

from companion.mission.places import Place


def begins_at_zero(home: Place) -> bool:
    """Whether [0, 0] lies in the region of the place where a mission begins."""
    return math.hypot(*home.position[:2]) <= home.inner_m


def as_begun_at_zero(home: Place) -> str:
    """Says in words how to shift a mission so that it begins at [0, 0].

    >>> from companion.motion.region import Disc
    >>> as_begun_at_zero(Place("Home", (-3.0, 8.25, -2.0), Disc(0.5)))
    'write 8.25 m less for all that is east, and 3 m more for all that is north, its map included'

    Args:
        home: the place where it begins.
    """
    north, east, _ = home.position
    shifts = [
        f"{abs(metres):g} m {'less' if metres > 0 else 'more'} for all that is {axis}"
        for metres, axis in ((round(east, 2), "east"), (round(north, 2), "north"))
        if metres
    ]
    return f"write {', and '.join(shifts)}, its map included"
