"""What happened, as a value: the lines that people read and `events.jsonl` keeps.

Kinds: `plan` and `replan` (a lasso was made), `at` and `done` (a skill was completed), `failed`
(a skill was not), `withdrawn` and `restored` (a belief was given up, is held again), `event` (a
fact that the vehicle cannot choose has changed), `violation` (a conjunct of the task cannot hold
any more), `route` (a flight was rerouted or stopped by what was seen), `symbol` (a place is flown
to at another waypoint), `map` (beliefs were given up, or are held again, by the map as seen),
`gate` (a setpoint was held back), `lap`, `phase` (a step of the sortie), `upload` (what became of a
mission that a ground station sent), `signal` (the terminal has hung up), `record` (the run folder
cannot be written; told, and not in it) and `end`; and for programs alone `position` (a position of
the word was left), `tree` (another tree is ticked) and `status` (nodes of it have another status).
docs/run-folder.md describes the data of each.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

FOR_PROGRAMS = frozenset({"position", "tree", "status"})
"""Kinds that are no news for people."""


@dataclass(frozen=True, slots=True)
class Report:
    """One thing that happened.

    Attributes:
        time_s: seconds since the run began.
        kind: see the module's docstring.
        text: one line for people.
        data: the same for programs; values that JSON can hold.
    """

    time_s: float
    kind: str
    text: str
    data: Mapping[str, object] = field(default_factory=dict)

    @property
    def is_told(self) -> bool:
        """Whether it is news for people."""
        return self.kind not in FOR_PROGRAMS
