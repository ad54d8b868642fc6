"""The charge during a flight, for `flight.png`; its size is limited even in a flight of days.

Measured is what the gauge reports. A plan's charge at a position is drawn at the time when the
position was reached. The vehicle charges while a leaf that charges runs.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field
from itertools import groupby
from typing import NamedTuple

from companion.flight_events.charge import ChargeMeasured, ChargePlanned, PlannedCharge
from companion.flight_events.event import Stamped
from companion.flight_events.plans import PlanReplaced
from companion.flight_events.skills import PlaceReached, SkillCompleted
from companion.flight_events.sortie import RunEnded
from companion.flight_events.tree import (
    Changes,
    LeafTreeNode,
    LeafType,
    NodesChanged,
    NodeStatus,
    TreeBuilt,
    TreeStopped,
)

POINTS_MAX = 2048
"""Most points of a line; of a longer one, every second point is kept."""
MARKS_MAX = 512
"""Most charges and replans; the newest are kept."""


class ChargeAt(NamedTuple):
    """The charge that a plan expected at a position.

    Attributes:
        plan: its number in the record; a plan that is repeated for its next lap counts as another.
        time_s: when the position was reached.
    """

    plan: int
    time_s: float
    percent: float
    required_percent: float


@dataclass
class ChargeTrail:
    """The charge so far.

    Attributes:
        measured: pairs of time and percent, None while unknown.
        planned: the positions that were reached.
        reserve_percent: kept for the unforeseen; None if plans do not consider the charge.
        charging: pairs of times, start and end of each charge.
        replans: pairs of time and number.
        end_s: the newest time.
    """

    measured: list[tuple[float, int | None]] = field(default_factory=list)
    planned: list[ChargeAt] = field(default_factory=list)
    reserve_percent: float | None = None
    charging: deque[tuple[float, float]] = field(default_factory=lambda: deque(maxlen=MARKS_MAX))
    replans: deque[tuple[float, int]] = field(default_factory=lambda: deque(maxlen=MARKS_MAX))
    end_s: float = 0.0
    _plans: int = 0
    _ahead: deque[PlannedCharge] = field(default_factory=deque)
    _leaves: frozenset[int] = frozenset()
    _charging_since_s: float | None = None

    @property
    def says_something(self) -> bool:
        """Whether the charge is of interest: plans consider it, or the vehicle charges."""
        return bool(self.measured) and (self.reserve_percent is not None or bool(self.charging))

    @property
    def plans(self) -> list[list[ChargeAt]]:
        """The expected charge, a list for each plan."""
        return [list(each) for _, each in groupby(self.planned, key=lambda at: at.plan)]

    def take(self, stamped: Stamped) -> None:
        """Takes an event."""
        time_s = self.end_s = max(self.end_s, stamped.time_s)
        match stamped.event:
            case ChargeMeasured(percent=percent):
                self.measured.append((time_s, percent))
                _thin(self.measured)
            case ChargePlanned() as plan:
                self.reserve_percent = plan.reserve_percent
                self._plans += 1
                self._ahead = deque(plan.ahead)
                self._reach(time_s, plan.percent, plan.required_percent)
            case SkillCompleted(action=action) | PlaceReached(action=action):
                self._complete(time_s, action)
            case PlanReplaced(number=number):
                self.replans.append((time_s, number))
            case TreeBuilt(nodes=nodes):
                self._charge_no_more(time_s)
                self._leaves = frozenset(
                    number
                    for number, node in enumerate(nodes)
                    if isinstance(node, LeafTreeNode) and node.does is LeafType.CHARGE
                )
            case NodesChanged(changed=changed) | TreeStopped(changed=changed):
                self._look_for_charging(time_s, changed)
            case RunEnded():
                self._charge_no_more(time_s)

    def _complete(self, time_s: float, action: str) -> None:
        """Notes a completed action; earlier ones without events were completed before."""
        names = [each.action for each in self._ahead]
        if action in names:
            for _ in range(names.index(action)):
                self._ahead.popleft()
            here = self._ahead.popleft()
            self._reach(time_s, here.percent, here.required_percent)

    def _reach(self, time_s: float, percent: float, required_percent: float) -> None:
        self.planned.append(ChargeAt(self._plans, time_s, percent, required_percent))
        _thin(self.planned)

    def _look_for_charging(self, time_s: float, changed: Changes) -> None:
        for node, status, _ in changed:
            if node in self._leaves and status is not NodeStatus.RUNNING:
                self._charge_no_more(time_s)
        if any(
            node in self._leaves and status is NodeStatus.RUNNING for node, status, _ in changed
        ):
            since_s = self._charging_since_s
            self._charging_since_s = time_s if since_s is None else since_s

    def _charge_no_more(self, time_s: float) -> None:
        if self._charging_since_s is not None and time_s > self._charging_since_s:
            self.charging.append((self._charging_since_s, time_s))
        self._charging_since_s = None


def _thin(points: list[tuple[float, int | None]] | list[ChargeAt]) -> None:
    if len(points) > POINTS_MAX:
        del points[1::2]
