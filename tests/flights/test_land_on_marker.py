"""Landings on a marker, in lockstep: what is landed on, and what is not, and where it ends then."""

from __future__ import annotations

from dataclasses import replace
from statistics import median
from typing import Any

import pytest
from lockstep import COMPANION, Lockstep
from moves import MOVE

from companion.flight_events.landing import LandedOnMarker, MarkerLost, SightingsRefused
from companion.flight_events.skills import SkillCompleted, SkillFailed
from companion.flight_events.sortie import (
    ControlTakenBack,
    RunFailed,
    SetpointRefused,
    TaskSatisfied,
    VehicleAirborne,
)
from companion.geometry import horizontal_distance
from companion.mavlink.framing import MavlinkCodec, dialect
from companion.mission.loader import load_mission
from companion.mission.model import Mission
from sitl.flight.estimate import Wander
from sitl.world.markers import Marker, MarkerCameraSpec, MarkerChange, MarkerReport
from sitl.world.scenario import Scenario, read_scenario

ROOF_M = 2.0
ROOF: dict[str, Any] = {"east_m": [2, 10], "north_m": [-4, 4], "up_m": ROOF_M}
PAD = (0.3, 6.4, -ROOF_M)
AWAY = (0.0, 6.0)
FORMS = [MarkerReport.LOCAL_NED, *(pytest.param(f, marks=pytest.mark.long) for f in MarkerReport)]


def mission(is_roof: bool = True, home_up_m: float = 3, **limits: Any) -> Mission:
    skill = {
        "parameters": {"p": "Pad"},
        "precondition": "at(p)",
        "assumes": "usable(p)",
        "effect": "stood",
        "execute": ["land_on(p)", "take_off()"],
    }
    return load_mission(
        {
            "version": 1,
            "name": "pad",
            "limits": {
                "speed_mps": 3,
                "up_m": [1, 8],
                "fence": [[-5, -8], [14, -8], [14, 8], [-5, 8]],
                **limits,
            },
            "map": {"walls": [ROOF]} if is_roof else {},
            "components": {"camera": 40},
            "places": {
                "Home": {"east_m": 0, "north_m": 0, "up_m": home_up_m},
                "P": {
                    **{"east_m": 6, "north_m": 0, "up_m": 5, "radius_m": 1.5},
                    "marker": {"component": "camera", "number": 3},
                },
            },
            "sets": {"Place": ["Home", "P"], "Pad": ["P"]},
            "skills": {"move": MOVE, "stand": skill},
            "initially": ["at(Home)"],
            "task": {"stand": "F stood", "home": "F G at(Home)"},
        }
    )


class Landing(Lockstep):
    """A flight to the marker and home; `at_touch_down` is where it truly stood."""

    home_up_m = 3.0

    def __init__(self, is_roof: bool = True, seed: int = 1, pad: Any = PAD, **about: Any) -> None:
        camera = MarkerCameraSpec(markers=(Marker("pad", 3, pad),))
        camera = replace(camera, **about.pop("camera", {}))
        walls = {"map": {"cell_m": 0.2, "walls": [ROOF]}} if is_roof else {}
        scenario, grid = read_scenario({"version": 1, **walls, **about.pop("keys", {})})
        self.scenario: Scenario = replace(scenario, marker_camera=camera, lidar=None, **about)
        world = (self.scenario, grid)
        asked = mission(is_roof, self.home_up_m)
        super().__init__(asked, world, seed=seed, has_station=True, resumes=True)

    def changes(self, **change: Any) -> None:
        camera = self.simulation._world.marker_camera
        assert camera is not None
        camera.change(MarkerChange("pad", **change), self.now_s)

    @property
    def up_m(self) -> float:
        return -self.simulation.flight.position[2]

    def until_landed(self) -> float:
        """How far from the marker it truly stands."""
        self.until(lambda: bool(self.of(LandedOnMarker)), 120.0)
        return horizontal_distance(self.simulation.flight.position, PAD)

    def until_failed(self) -> str:
        """Why it did not land; it is in the air, above its place, and goes home."""
        self.until(lambda: bool(self.of(SkillFailed)), 240.0)
        assert self.simulation.is_armed and self.simulation.mode == "OFFBOARD"
        north, east, down = self.simulation.flight.position
        assert (north, east, -down) == pytest.approx((*AWAY, 5.0), abs=0.7)
        failed = self.one(SkillFailed)
        self.until_the_end()
        assert self.exit_code == 3 and not self.simulation.is_damaged
        assert horizontal_distance(self.simulation.flight.position, (0.0, 0.0)) < 0.5
        return failed.reason


@pytest.mark.parametrize("form", FORMS)
def test_it_lands_on_a_roof_takes_off_and_goes_home(form: MarkerReport) -> None:
    flight = Landing(camera={"reports": form, "misses": 0.2, "strays": 0.02})
    assert flight.until_landed() < 0.15
    assert flight.up_m == pytest.approx(ROOF_M, abs=0.02)
    flight.until(lambda: bool(flight.of(VehicleAirborne)), 30.0)
    assert flight.up_m == pytest.approx(5.0, abs=0.4)
    flight.until_the_end()
    assert flight.ending == TaskSatisfied()
    assert flight.one(SkillCompleted).action == "stand(P)"
    assert not flight.simulation.is_damaged and not flight.of(SetpointRefused)


def test_no_take_off_from_a_roof_leads_above_the_ceiling(monkeypatch: pytest.MonkeyPatch) -> None:
    """As high above it as home is above the ground would be 9 m, and the mission stays below 8."""
    monkeypatch.setattr(Landing, "home_up_m", 7.0)
    flight = Landing()
    flight.until_landed()
    highest_m = 0.0
    while not flight.companion.has_ended:
        flight.tick()
        highest_m = max(highest_m, flight.up_m)
    assert flight.ending == TaskSatisfied() and 7.5 < highest_m < 8.2
    assert flight.of(SetpointRefused) == []


@pytest.mark.long
def test_it_lands_below_the_altitude_band_on_the_ground_too() -> None:
    flight = Landing(is_roof=False, pad=(*PAD[:2], 0.0))
    assert flight.until_landed() < 0.15
    assert flight.until_the_end().ending == TaskSatisfied()
    assert not flight.of(SetpointRefused)


def test_a_marker_that_is_never_seen_is_searched_for_and_given_up() -> None:
    flight = Landing(camera={"misses": 1.0})
    assert "its marker is not seen" in flight.until_failed()


def test_a_marker_that_is_lost_is_waited_for_and_found_again() -> None:
    flight = Landing()
    flight.until(lambda: flight.up_m < 4.0 and flight.now_s > 12.0, 60.0)
    flight.changes(is_present=False)
    flight.until(lambda: bool(flight.of(MarkerLost)), 5.0)
    lowest_m = flight.up_m
    flight.run(6.0)
    assert flight.up_m > lowest_m + 0.3
    flight.changes(is_present=True)
    assert flight.until_landed() < 0.15


@pytest.mark.long
def test_a_marker_that_is_gone_for_good_leaves_the_vehicle_in_the_air() -> None:
    flight = Landing()
    flight.until(lambda: flight.up_m < 4.0 and flight.now_s > 12.0, 60.0)
    flight.changes(is_present=False)
    assert "its marker is lost" in flight.until_failed()


def test_a_marker_that_moves_is_not_landed_on() -> None:
    flight = Landing()
    flight.until(lambda: flight.up_m < 4.3 and flight.now_s > 12.0, 60.0)
    flight.changes(velocity=(0.3, 0.0))
    assert "the marker has moved by 1." in flight.until_failed()


@pytest.mark.long
@pytest.mark.parametrize("pad", [(2.4, 6.0, -ROOF_M), (0.0, 6.0, -ROOF_M - 1.5)])
def test_a_marker_that_is_not_where_it_should_be_is_not_landed_on(pad: Any) -> None:
    flight = Landing(pad=pad)
    assert "what was refused last: it is " in flight.until_failed()


@pytest.mark.long
def test_another_number_is_not_the_marker() -> None:
    two = (Marker("other", 4, (0.3, 6.0, -ROOF_M)), Marker("pad", 3, PAD))
    flight = Landing(camera={"markers": two})
    assert flight.until_landed() < 0.15


def test_a_marker_that_another_component_makes_up_is_not_believed() -> None:
    """It says so twenty times a second, from the same system, beside the right one."""
    flight = Landing()
    liar = MavlinkCodec(1, 41)
    forged: list[bytes] = []

    def with_lies(now_s: float, datagrams: list[bytes]) -> list[bytes]:
        lie = dialect.MAVLink_landing_target_message(
            *(0, 3, 1, 0.0, 0.0, 0.0, 0.0, 0.0, -0.8, 5.2, -ROOF_M, (1.0, 0.0, 0.0, 0.0), 2, 1)
        )
        forged.append(liar.pack(lie))
        return [*datagrams, forged[-1]]

    flight._up = with_lies
    assert flight.until_landed() < 0.15
    assert any("component 41 is not one" in each.reason for each in flight.of(SightingsRefused))


def descending(up_m: float, **about: Any) -> Landing:
    flight = Landing(**about)

    def is_low_over_p() -> bool:
        away_m = horizontal_distance(flight.simulation.flight.position, AWAY)
        return away_m < 1.5 and flight.up_m < up_m

    flight.until(is_low_over_p, 60.0)
    return flight


PX4: dict[str, Any] = {"airframe": "px4_sih", "wander": Wander(0.25, 0.3), "wind": (1.0, 1.0, 0.0)}
"""The errors of a PX4's estimate: its velocity says that a vehicle moves which stands still."""


@pytest.mark.long
def test_what_wanders_is_followed() -> None:
    """The marker is seen as it is."""
    assert Landing(**PX4).until_landed() < 0.5


@pytest.mark.long
def test_a_velocity_that_is_off_keeps_nobody_waiting_above_the_marker() -> None:
    """A PX4 sank onto a roof meanwhile: the height of its estimate drifts as well."""
    flight = descending(ROOF_M + 0.6, seed=11, **PX4)
    low_s = flight.now_s
    flight.until(lambda: flight.simulation.mode == "AUTO.LAND", 20.0)
    assert flight.now_s - low_s < 5.0


@pytest.mark.long
def test_a_marker_that_is_too_near_to_be_seen_is_landed_on() -> None:
    flight = descending(ROOF_M + 0.6, seed=2, **PX4)
    flight.changes(is_present=False)
    assert flight.until_landed() < 0.5
    assert not flight.of(MarkerLost)


GUSTS = {
    "wind": {"east_mps": 3, "north_mps": 2, "turbulence_mps": 0.5},
    "happens": [{"at_s": 0.5, "gps": {"noise_m": 0.5}}],
}


@pytest.mark.long
def test_with_gusts_and_a_noisy_gps_twenty_landings_end_near_the_middle() -> None:
    """The figures of docs/landing.md: median and worst."""
    off_m = []
    for seed in range(1, 21):
        camera = {"misses": 0.2, "strays": 0.02, "noise_rad": 0.0175}
        flight = Landing(seed=seed, keys=GUSTS, camera=camera)
        off_m.append(flight.until_landed())
        assert not flight.simulation.is_damaged
    print(sorted(round(each, 3) for each in off_m))
    assert median(off_m) < 0.15 and max(off_m) < 0.35


# -- something interrupts the descent --------------------------------------------------------------

CONTINUE = dialect.MAV_CMD_DO_PAUSE_CONTINUE
HIGH_M, LOW_M = ROOF_M + 1.6, ROOF_M + 0.3
"""Still flown by setpoints, and near the end; below, the autopilot's own landing has begun."""


def lands_on_the_marker_once(flight: Landing) -> None:
    """And the task goes on to its end."""
    assert flight.until_landed() < 0.15
    flight.until_the_end()
    assert flight.ending == TaskSatisfied() and not flight.simulation.is_damaged
    assert len(flight.of(LandedOnMarker)) == len(flight.of(SkillCompleted)) == 1
    assert flight.armings == 2


def test_killed_in_the_descent_it_goes_on_with_it() -> None:
    flight = descending(HIGH_M)
    flight.kill()
    flight.run(3.0)
    assert flight.simulation.mode == "AUTO.LOITER"
    flight.restart()
    lands_on_the_marker_once(flight)
    assert len(flight.of(ControlTakenBack)) == 1


def test_killed_at_the_end_of_the_descent_it_stands_and_is_not_armed_again() -> None:
    flight = descending(LOW_M)
    flight.kill()
    flight.run(5.0)
    flight.restart()
    flight.until_the_end()
    away = "the companion was away, and the vehicle has landed; it is not armed again"
    assert flight.ending == RunFailed(away, 5) and flight.armings == 1
    assert horizontal_distance(flight.simulation.flight.position, PAD) < 0.15


@pytest.mark.long
def test_paused_in_the_descent_it_holds_and_goes_on() -> None:
    flight = descending(HIGH_M)
    flight.station_commands(CONTINUE, 0.0, component=COMPANION)
    flight.run(8.0)
    assert flight.events[-1].text == "paused" and flight.up_m == pytest.approx(HIGH_M, abs=0.4)
    flight.station_commands(CONTINUE, 1.0, component=COMPANION)
    lands_on_the_marker_once(flight)


@pytest.mark.parametrize("up_m", [pytest.param(HIGH_M, marks=pytest.mark.long), LOW_M])
def test_a_pilot_who_holds_in_the_descent_is_left_alone_until_he_gives_it_back(up_m: float) -> None:
    flight = descending(up_m)
    flight.station_chooses("AUTO.LOITER")
    flight.run(0.5)
    before = len(flight.setpoints), len(flight.commands)
    flight.run(6.0)
    assert (len(flight.setpoints), len(flight.commands)) == before
    assert flight.up_m == pytest.approx(up_m, abs=0.4)
    flight.station_commands(CONTINUE, 1.0, component=COMPANION)
    lands_on_the_marker_once(flight)


@pytest.mark.parametrize("up_m", [pytest.param(HIGH_M, marks=pytest.mark.long), LOW_M])
def test_stopped_in_the_descent_it_lands_where_it_is(up_m: float) -> None:
    flight = descending(up_m)
    flight.companion.stop()
    flight.until_the_end()
    assert flight.exit_code == 0 and not flight.simulation.is_damaged
    assert max(-flight.simulation.flight.position[2], 0.0) == pytest.approx(ROOF_M, abs=0.05)
    assert horizontal_distance(flight.simulation.flight.position, PAD) < 0.7
