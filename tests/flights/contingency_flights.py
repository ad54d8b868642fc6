"""The contingencies of surveillance, flown: the world makes each of them happen at its position.

An event comes by the detector, an upload fails by the payload, a place is lost under a crate, and a
flight fails for its time: the operator slows the vehicle down until it is over. What the world
cannot do is left out, and why is said.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

from lockstep import COMPANION, VEHICLE, Lockstep

from companion.acting.contingencies.answers import GoesOn, LandsAt, Replans
from companion.acting.contingencies.changes import BeliefLost, EventTurns, SiteLost
from companion.acting.contingencies.table import Contingency, ContingencyTable
from companion.api.contingency_answers import contingencies
from companion.flight_events.plans import LapCompleted, PlannedLasso, PlanReplaced
from companion.flight_events.skills import PlaceReached, SkillCompleted, SkillFailed
from companion.flight_events.sortie import Phase, PhaseEntered, ReturnBegun, TaskSatisfied
from companion.flights.simulated_world import world_of
from companion.mavlink.framing import dialect
from companion.mission.facts import HERE
from companion.mission.loader import load_mission
from companion.mission.model import Mission

SURVEILLANCE = Path(__file__).parents[2] / "missions" / "surveillance.yaml"
SEES, DROPS = dialect.MAV_CMD_USER_3, dialect.MAV_CMD_USER_4
CRATE_M = 0.7
NEAR_M = 2.5
"""From a crate that appears: so near nothing could stop."""
SLOW_MPS, FAST_MPS = 0.1, 50.0
LIMIT_S = 400.0


@cache
def mission(is_timed: bool = False) -> Mission:
    """Surveillance; or the same with flights that fail when they take too long."""
    text = SURVEILLANCE.read_text(encoding="utf-8")
    text = text.replace("map: maps/", f"map: {SURVEILLANCE.parent}/maps/")
    return load_mission(
        text.replace("tries: 3", "tries: 1\n    timeout_s: 12") if is_timed else text
    )


@cache
def table() -> ContingencyTable:
    """All of its contingencies."""
    return contingencies(mission(), jobs=1)


def why_not_flown(row: Contingency) -> str | None:
    """Why the world cannot make a contingency happen; None if it can."""
    change = row.change
    if isinstance(change, BeliefLost) and row.after is None:
        action = table().positions[row.position].ahead
        if str(change.belief) != action.replace("move", "trans_ok"):
            return "a way fails while it is flown; the map closes it only with its place"
    return None


def name_of(row: Contingency) -> str:
    """For the names of tests."""
    return f"{row.position} {row.label}"


class ContingencyFlight(Lockstep):
    """One contingency, flown."""

    def __init__(self, row: Contingency, seed: int = 0) -> None:
        self.row = row
        change, answers, obstacles = row.change, [], []
        happens: list[dict[str, Any]] = [{"command": "MAV_CMD_USER_3", "target": "seen"}]
        is_timed = False
        if isinstance(change, BeliefLost):
            predicate, where = change.belief.predicate, change.belief.arguments[-1]
            is_timed = predicate == "trans_ok"
            if predicate == "canUpload":
                answers = [_circle(where, 1.0) | {"result": "DENIED", "after_s": 2.0}]
        if isinstance(change, SiteLost):
            crate = {"name": "crate", "present": False, "circle": _circle(change.place, CRATE_M)}
            obstacles = [crate]
            drop = {"name": "crate", "present": True}
            happens.append({"command": "MAV_CMD_USER_4", "obstacle": drop})
        scenario = {
            "version": 1,
            "lidar": {},
            "target": {"component": 26},
            "payload": {
                "component": 25,
                "command": "MAV_CMD_USER_1",
                "answers": answers,
                "otherwise": "ACCEPTED",
            },
            "obstacles": obstacles,
            "happens": happens,
        }
        asked = mission(is_timed)
        super().__init__(asked, world_of(asked, scenario), seed=seed, has_station=True)

    def fly(self) -> ContingencyFlight:
        """To the position, through the change, and to what comes of it."""
        row = self.row
        self.until_reported(PhaseEntered, phase=Phase.TASK)
        self.until(lambda: len(self.of(PlaceReached)) == row.position)
        if isinstance(row.change, BeliefLost) and row.change.belief.arguments[0] == HERE:
            self._allow(SLOW_MPS)  # so that the flight fails near where it has begun
        for change in (row.after, row.change):
            match change:
                case EventTurns():
                    self.station_commands(SEES)
                case SiteLost(place):
                    self.until(lambda: self.away_m(place) > NEAR_M + CRATE_M)
                    self.station_commands(DROPS)
                case BeliefLost(belief) if belief.predicate == "trans_ok":
                    self._fail_the_flight_from(belief.arguments[0])
        self.laps_before = len(self.of(LapCompleted))
        return self.until(self._is_over, LIMIT_S)

    def _fail_the_flight_from(self, origin: str) -> None:
        if self.row.after is not None:
            kind = PlanReplaced if origin == HERE else SkillCompleted
            self.until_reported(kind)
        self._allow(SLOW_MPS)
        self.until_reported(SkillFailed)
        self._allow(FAST_MPS)

    def _allow(self, speed_mps: float) -> None:
        asked = dialect.MAVLink_param_set_message(
            VEHICLE,
            COMPANION,
            param_id=b"CMP_SPEED_MAX",
            param_value=speed_mps,
            param_type=dialect.MAV_PARAM_TYPE_REAL32,
        )
        self.station_says(asked)

    def _is_over(self) -> bool:
        laps = len(self.of(LapCompleted)) - self.laps_before
        return self.companion.has_ended or laps >= 2

    def away_m(self, place: str) -> float:
        """Between the vehicle and a place, over the ground."""
        north, east, _ = mission().places[place].position
        now = self.simulation.flight.position
        return math.hypot(now[0] - north, now[1] - east)

    @property
    def plans(self) -> list[str]:
        """The plans that replaced others."""
        return [str(replaced.plan) for replaced in self.of(PlanReplaced)]

    def differs(self) -> str | None:
        """What is not as the table has it; None if nothing is."""
        check = _CHECKS[type(self.row.answer)]
        if self.simulation.collisions:
            return "it has hit something"
        return check(self, self.row.answer)


def _planned(flight: ContingencyFlight, answer: Replans) -> str | None:
    plans = [replaced.plan for replaced in flight.of(PlanReplaced)]
    if len(plans) != (1 if flight.row.after is None else 2):
        return f"plans {flight.plans}"
    change, last = flight.row.change, plans[-1]
    is_flight = isinstance(change, BeliefLost) and change.belief.predicate == "trans_ok"
    # it fails a metre from where it has begun, from where another way may be the shorter one
    is_same = _loop(last) == _loop(answer.plan) if is_flight else str(last) == str(answer.plan)
    if not is_same:
        return f"the last plan is {last}, and not {answer.plan}"
    if answer.plan.loop[0].skill == "wait" and not flight.of(TaskSatisfied):
        return "the task is not satisfied"
    return None


def _as_planned(flight: ContingencyFlight, answer: GoesOn) -> str | None:
    return f"plans {flight.plans}" if flight.plans else None


def _lands(flight: ContingencyFlight, answer: LandsAt) -> str | None:
    if not flight.companion.has_ended or flight.exit_code != 3:
        return "it has not ended without a plan"
    begun = [each.place for each in flight.of(ReturnBegun)]
    if begun[-1:] != [answer.place] or flight.away_m(answer.place) > 0.8:
        return f"it has returned to {begun}, and stands {flight.away_m(answer.place):.1f} m off"
    return None


_CHECKS: dict[type[Any], Callable[[ContingencyFlight, Any], str | None]] = {
    Replans: _planned,
    GoesOn: _as_planned,
    LandsAt: _lands,
}


def _loop(plan: PlannedLasso) -> list[str]:
    """The loop of a plan, the same wherever it is entered."""
    actions = [step.action for step in plan.loop]
    first = actions.index(min(actions))
    return actions[first:] + actions[:first]


def _circle(place: str, radius_m: float) -> dict[str, float]:
    north, east, _ = mission().places[place].position
    return {"east_m": east, "north_m": north, "radius_m": radius_m}
