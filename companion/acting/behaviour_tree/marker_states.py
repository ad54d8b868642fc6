"""The states of a landing on a marker, what ends each, and the next state."""

from __future__ import annotations

from enum import Enum

from companion.transitions import StateTransition, TransitionTable


class MarkerState(Enum):
    """The states of a landing on a marker."""

    LOOKING = "looking"
    DESCENDING = "descending"
    WAITING = "waiting"
    CLIMBING = "climbing"
    SEARCHING = "searching"
    LEAVING = "leaving"
    LANDING = "landing"


class MarkerCue(Enum):
    """The events that end a state."""

    SEEN = "the marker is seen"
    LOST = "the marker is lost"
    LOW = "low, still and over the marker"
    TIME_UP = "the marker is not seen in time"
    ARRIVED = "arrived above where it was seen last"
    REFUSED = "the landing is given up"


def _row(state: MarkerState, cue: MarkerCue, then: MarkerState, effect: str) -> _Row:
    return StateTransition(state, cue, then, effect)


_Row = StateTransition[MarkerState, MarkerCue]
_LOOKING, _DESCENDING, _WAITING, _CLIMBING, _SEARCHING, _LEAVING, _LANDING = MarkerState
_OVER = "sinks, while it is over the marker"
_BACK = "climbs back to its place, where the skill fails"
TRANSITIONS = TransitionTable(
    _row(_LOOKING, MarkerCue.SEEN, _DESCENDING, _OVER),
    _row(_LOOKING, MarkerCue.TIME_UP, _SEARCHING, "flies to the corners of a square"),
    _row(_LOOKING, MarkerCue.REFUSED, _LEAVING, _BACK),
    _row(_DESCENDING, MarkerCue.LOST, _WAITING, "holds"),
    _row(_DESCENDING, MarkerCue.LOW, _LANDING, "the autopilot lands; nothing interrupts that"),
    _row(_DESCENDING, MarkerCue.REFUSED, _LEAVING, _BACK),
    _row(_WAITING, MarkerCue.SEEN, _DESCENDING, _OVER),
    _row(_WAITING, MarkerCue.TIME_UP, _CLIMBING, "climbs above where the marker was seen last"),
    _row(_WAITING, MarkerCue.REFUSED, _LEAVING, _BACK),
    _row(_CLIMBING, MarkerCue.SEEN, _DESCENDING, _OVER),
    _row(_CLIMBING, MarkerCue.ARRIVED, _SEARCHING, "flies to the corners of a square"),
    _row(_CLIMBING, MarkerCue.REFUSED, _LEAVING, _BACK),
    _row(_SEARCHING, MarkerCue.SEEN, _DESCENDING, _OVER),
    _row(_SEARCHING, MarkerCue.TIME_UP, _LEAVING, _BACK),
    _row(_SEARCHING, MarkerCue.REFUSED, _LEAVING, _BACK),
)
"""The transitions; LEAVING and LANDING end with the skill."""
