"""Headings in the simulator: how the vehicle truly stands when a skill begins and when it ends."""

from __future__ import annotations

import math
from typing import Any

from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from lockstep import COMPANION, Lockstep
from moves import MOVE

from companion.flight_events.skills import PlaceReached, SkillCompleted
from companion.flight_events.sortie import Phase, PhaseEntered
from companion.geometry import Ned
from companion.mavlink.framing import dialect
from companion.mission.loader import load_mission
from companion.motion.heading import HEADING_TOLERANCE_RAD, error_rad
from sitl.world.scenario import read_scenario

SCENARIO = {
    "version": 1,
    "start": {"north_m": 0, "east_m": 0, "heading_deg": 200},
    "payload": {"component": 25, "command": "MAV_CMD_USER_1", "otherwise": "ACCEPTED"},
    "wind": {"east_mps": 2, "north_mps": 1, "turbulence_mps": 0.3},
}
ESTIMATE_RAD = math.radians(2.0)
"""How much the autopilot's own heading may be off the true one."""
FEW = settings(max_examples=3, deadline=None, suppress_health_check=[*HealthCheck])


def mission(**changes: Any) -> dict[str, Any]:
    """From Home to A and back; a picture is taken at A."""
    photo = {
        "precondition": "at(A)",
        "effect": "taken",
        "execute": "command(payload, MAV_CMD_USER_1)",
    }
    return {
        "version": 1,
        "name": "photo",
        "map": {"east_m": [-10, 10], "north_m": [-10, 10], "cell_m": 0.25},
        "limits": {
            "speed_mps": 3,
            "up_m": [0.5, 4],
            "fence": [[-8, -8], [8, -8], [8, 8], [-8, 8]],
        },
        "places": {
            "Home": {"east_m": 0, "north_m": 0, "up_m": 2},
            "A": {"east_m": 3, "north_m": 2, "up_m": 2, **changes.pop("A", {})},
        },
        "sets": {"Place": ["Home", "A"]},
        "components": {"payload": 25},
        "skills": {
            "move": {**MOVE, **changes.pop("move", {})},
            "photo": {**photo, **changes.pop("photo", {})},
        },
        "initially": ["at(Home)"],
        "task": {"photo": "F taken"},
        **changes,
    }


class HeadingFlight(Lockstep):
    """Keeps where the vehicle truly was, and looked, at each tick."""

    def __init__(self, mission: dict[str, Any], seed: int = 0, **options: Any) -> None:
        self.truth: list[tuple[float, Ned, float]] = []
        world = read_scenario({**SCENARIO})
        super().__init__(load_mission(mission), world, seed=seed, **options)

    def tick(self) -> None:
        super().tick()
        state = self.simulation.flight
        self.truth.append((self.now_s, state.position, state.euler[2]))

    @property
    def heading_rad(self) -> float:
        return self.truth[-1][2]

    def between(self, begin_s: float, end_s: float) -> list[tuple[Ned, float]]:
        return [(place, yaw) for time_s, place, yaw in self.truth if begin_s <= time_s <= end_s]


def off(position: Ned, yaw_rad: float, point: tuple[float, float]) -> float:
    """How far the vehicle looks past a point, north and east."""
    return error_rad(yaw_rad, math.atan2(point[1] - position[1], point[0] - position[0]))


@FEW
@given(st.floats(-360, 360), st.integers(0, 99))
def test_the_vehicle_arrives_with_the_heading_of_the_place(deg: float, seed: int) -> None:
    flight = HeadingFlight(mission(A={"heading_deg": deg}), seed)
    flight.until_reported(PlaceReached, place="A")
    wanted_rad = math.radians(deg)
    assert error_rad(flight.heading_rad, wanted_rad) <= HEADING_TOLERANCE_RAD + ESTIMATE_RAD
    flight.until_reported(SkillCompleted, action="photo")
    assert error_rad(flight.heading_rad, wanted_rad) <= HEADING_TOLERANCE_RAD
    assert flight.until_the_end().exit_code == 0


@FEW
@given(st.floats(0, 2 * math.pi), st.floats(1.0, 9.0), st.integers(0, 99))
def test_a_picture_is_taken_of_what_is_looked_at(
    direction: float, away_m: float, seed: int
) -> None:
    """From the moment at which the command is sent to its answer."""
    point = (2.0 + away_m * math.cos(direction), 3.0 + away_m * math.sin(direction))
    look_at = {"north_m": point[0], "east_m": point[1]}
    plan = mission(photo={"look_at": look_at}, A={"heading_deg": 90})
    flight = HeadingFlight(plan, seed).until_reported(SkillCompleted, action="photo")
    (sent,) = [said for said in flight.commands if said.message.target_component == 25]
    taken = flight.between(sent.time_s, flight.now_s)
    assert len(taken) > 2
    most_rad = HEADING_TOLERANCE_RAD + ESTIMATE_RAD + math.atan2(0.3, away_m)
    assert max(off(place, yaw, point) for place, yaw in taken) <= most_rad


def test_a_flight_looks_at_its_point_all_the_way() -> None:
    """Also where it arrives, whatever heading the place has."""
    plan = mission(move={"look_at": {"north_m": 8, "east_m": -6}}, A={"heading_deg": 90})
    flight = HeadingFlight(plan)
    flight.until(lambda: math.hypot(*flight.simulation.flight.velocity[:2]) > 0.5)
    begin_s = flight.now_s
    flight.until_reported(PlaceReached, place="A")
    flown = flight.between(begin_s, flight.now_s)
    assert max(off(place, yaw, (8, -6)) for place, yaw in flown) <= math.radians(15)
    assert off(*flown[-1], (8, -6)) <= HEADING_TOLERANCE_RAD + ESTIMATE_RAD


def test_a_pause_keeps_the_heading_and_the_skill_begins_anew() -> None:
    behind = {"north_m": -8, "east_m": -8}
    plan = mission(photo={"look_at": behind, "execute": "wait(3)"})
    flight = HeadingFlight(plan, has_station=True).until_reported(PlaceReached, place="A")
    flight.run(0.8)  # amid the turn
    flight.station_commands(dialect.MAV_CMD_DO_PAUSE_CONTINUE, 0.0, component=COMPANION)
    flight.until_reported(PhaseEntered, phase=Phase.PAUSED).run(1.0)
    paused_rad = flight.heading_rad
    flight.run(2.0)
    assert error_rad(flight.heading_rad, paused_rad) <= HEADING_TOLERANCE_RAD
    assert off(*flight.truth[-1][1:], (-8, -8)) > HEADING_TOLERANCE_RAD
    flight.station_commands(dialect.MAV_CMD_DO_PAUSE_CONTINUE, 1.0, component=COMPANION)
    flight.until_reported(SkillCompleted, action="photo")
    looked = flight.between(flight.now_s - 3.0, flight.now_s)
    assert max(off(place, yaw, (-8, -8)) for place, yaw in looked) <= (
        HEADING_TOLERANCE_RAD + ESTIMATE_RAD
    )
    assert flight.until_the_end().exit_code == 0
