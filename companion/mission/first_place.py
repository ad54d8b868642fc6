"""Where a mission in metres begins, and what to write where that is not [0, 0].

Its metres count from the autopilot's home position, at which the vehicle stands when its first
flight since the autopilot's start begins. So a mission that begins elsewhere is refused there:
walls would be where none stand. The same mission with other figures begins at [0, 0].
"""

from __future__ import annotations

import math

from companion.mission.model import Place


def begins_at_zero(home: Place) -> bool:
    """Whether [0, 0] is where a mission begins, as near as that place is wide."""
    return math.hypot(*home.position[:2]) <= home.inner_m


def as_begun_at_zero(home: Place) -> str:
    """What to write so that a mission begins at [0, 0], in words.

    >>> from companion.motion.region import Disc
    >>> as_begun_at_zero(Place("Home", (-3.0, 8.25, -2.0), Disc(0.5)))
    'write 8.25 m less for all that is east, and 3 m more for all that is north, its map included'

    Args:
        home: where it begins.
    """
    north, east, _ = home.position
    shifts = [
        f"{abs(metres):g} m {'less' if metres > 0 else 'more'} for all that is {axis}"
        for metres, axis in ((round(east, 2), "east"), (round(north, 2), "north"))
        if metres
    ]
    return f"write {', and '.join(shifts)}, its map included"
