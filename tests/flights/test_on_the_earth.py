"""Missions in latitude and longitude, flown by an autopilot whose origin is not at home.

The figures of PROJ are Proj("+proj=aeqd +lat_0=.. +lon_0=.. +R=6371000") by pyproj 3.7.2.
"""

from __future__ import annotations

import copy
import math
from collections.abc import Callable
from typing import Any, NamedTuple

import pytest
from lockstep import Air, Deaf, Lockstep, clear
from moves import MOVE

from companion.acting.sortie.frame_watch import LOST_S
from companion.flight_events.frames import FrameDoubted, FrameLocated, FrameTrusted, OriginMoved
from companion.flight_events.skills import PlaceReached, SkillCompleted
from companion.flight_events.sortie import (
    Phase,
    PhaseEntered,
    SetpointRefused,
)
from companion.flights.simulated_world import world_of
from companion.geometry import GlobalOrigin, Ned, horizontal_distance, is_in_polygon
from companion.mavlink.framing import MavlinkCodec, dialect
from companion.mission.loader import load_mission
from companion.monitor.watching import Watcher

ORIGIN_ID = dialect.MAVLINK_MSG_ID_GPS_GLOBAL_ORIGIN
REQUEST = dialect.MAV_CMD_REQUEST_MESSAGE
OFFBOARD_JUMP_M = 1.0
"""As far as a vehicle in OFFBOARD may be led by a setpoint of the frame before."""


class Field(NamedTuple):
    """Two places and an origin, and where PROJ has the places about it: north and east."""

    home: tuple[float, float]
    place: tuple[float, float]
    origin: tuple[float, float]
    home_about_origin: tuple[float, float]
    place_about_origin: tuple[float, float]


ZURICH = Field(
    (47.397742, 8.545594),
    (47.3982, 8.5462),
    (47.4112, 8.5283),
    (-1496.3167, 1301.6917),
    (-1445.3791, 1347.2926),
)
TROMSO = Field(
    (69.65, 18.96),
    (69.6506, 18.9615),
    (69.7, 18.8),
    (-5551.6451, 6186.9503),
    (-5484.7758, 6244.7765),
)
"""So far north and away that a shift of metres would be wrong by 0.2 m."""
OTHER_ORIGIN = {"latitude_deg": 47.3923, "longitude_deg": 8.5482, "altitude_m": 533.0}


def mission_of(field: Field) -> dict[str, Any]:
    home = GlobalOrigin(*field.home, 0.0)
    square = ((-90.0, -90.0), (-90.0, 90.0), (90.0, 90.0), (90.0, -90.0))
    return {
        "version": 1,
        "name": "field",
        "frame": "wgs84",
        "map": {"east_m": [-95, 95], "north_m": [-95, 95], "cell_m": 1},
        "limits": {
            "speed_mps": 5,
            "up_m": [2, 30],
            "fence": [list(home.to_global((*corner, 0.0))[:2]) for corner in square],
        },
        "places": {
            "Home": {"lat_deg": field.home[0], "lon_deg": field.home[1], "up_m": 5},
            "A": {"lat_deg": field.place[0], "lon_deg": field.place[1], "up_m": 12},
        },
        "sets": {"Place": ["Home", "A"]},
        "skills": {
            "move": MOVE,
            "look": {"precondition": "at(A)", "effect": "seen", "execute": "wait(5)"},
        },
        "initially": ["at(Home)"],
        "task": {"look": "F seen & F G at(Home)"},
    }


def world(field: Field, *happens: dict[str, Any]) -> dict[str, Any]:
    names = ("latitude_deg", "longitude_deg")
    return {
        "version": 1,
        "home": dict(zip(names, field.home, strict=True)) | {"altitude_m": 488.0},
        "origin": dict(zip(names, field.origin, strict=True)) | {"altitude_m": 455.0},
        "happens": list(happens),
    }


def in_metres(field: Field) -> dict[str, Any]:
    """The same mission, in metres from wherever home is."""
    data, metres = mission_of(field) | {"frame": "enu"}, load_mission(mission_of(field))
    data["limits"]["fence"] = [[east, north] for north, east in metres.limits.fence]
    for name, place in metres.places.items():
        north, east, down = place.position
        data["places"][name] = {"north_m": north, "east_m": east, "up_m": -down}
    return data


class EarthFlight(Lockstep):
    """A flight over a field.

    Args:
        field: where.
        happens: in the scenario.
        up: the way from the vehicle to the companion.
        data: the mission, if it is another one.

    Attributes:
        truth: where the vehicle truly was in each tick, about home.
    """

    def __init__(
        self,
        field: Field,
        *happens: dict[str, Any],
        up: Air = clear,
        data: dict[str, Any] | None = None,
    ) -> None:
        self.mission = load_mission(data or mission_of(field))
        self.truth: list[Ned] = []
        super().__init__(self.mission, world_of(self.mission, world(field, *happens)), up=up)

    def tick(self) -> None:
        super().tick()
        self.truth.append(self.simulation.flight.position)

    @property
    def was_inside(self) -> bool:
        return all(is_in_polygon(each, self.mission.limits.fence) for each in self.truth)

    @property
    def asked(self) -> int:
        """How often the origin was asked for."""
        commands = [s.message for s in self.said if s.message.get_type() == "COMMAND_LONG"]
        return [m.param1 for m in commands if m.command == REQUEST].count(ORIGIN_ID)

    def setpoint(self) -> tuple[float, float]:
        message = self.setpoints[-1].message
        return (message.x, message.y)


@pytest.mark.parametrize(
    "field", [pytest.param(ZURICH, marks=pytest.mark.long), TROMSO], ids=["Zurich", "Tromso"]
)
def test_it_flies_to_where_the_places_are_on_the_earth(field: Field) -> None:
    flight = EarthFlight(field)
    (located,) = flight.until_reported(FrameLocated).of(FrameLocated)
    assert located.away_m == pytest.approx(math.hypot(*field.home_about_origin), abs=0.05)
    assert (located.amsl_m, located.residual_m) == pytest.approx((488.0, 0.0), abs=0.03)

    flight.until_reported(PlaceReached, place="A").run(2.0)
    assert flight.setpoint() == pytest.approx(field.place_about_origin, abs=0.02)
    begin = len(flight.truth)
    flight.until_reported(SkillCompleted, action="look")
    there = GlobalOrigin(*field.home, 488.0).to_local(*field.place, 500.0)
    hovered = flight.truth[begin:]
    mean = [sum(axis) / len(hovered) for axis in zip(*hovered, strict=True)]
    assert len(hovered) > 40 and math.dist(mean, there) < 0.1

    assert flight.until_the_end().exit_code == 0
    assert math.hypot(*flight.truth[-1][:2]) < 0.3 and flight.was_inside
    for unwanted in (FrameDoubted, OriginMoved, SetpointRefused):
        assert flight.of(unwanted) == []


@pytest.mark.parametrize(
    "written",
    [mission_of, pytest.param(in_metres, marks=pytest.mark.long)],
    ids=["degrees", "metres"],
)
def test_an_origin_that_moves_in_flight_changes_nothing_on_the_earth(
    written: Callable[[Field], dict[str, Any]],
) -> None:
    moves = {"at_s": 14.3, "origin": OTHER_ORIGIN}
    usual = EarthFlight(ZURICH, data=written(ZURICH)).until_the_end()
    flight = EarthFlight(ZURICH, moves, data=written(ZURICH)).until_the_end()
    (moved,) = flight.of(OriginMoved)
    assert moved.moved_m > 2000.0
    assert flight.exit_code == usual.exit_code == 0 and flight.was_inside
    assert len(flight.truth) == pytest.approx(len(usual.truth), abs=20)
    apart_m = max(map(math.dist, flight.truth[:500], usual.truth[:500]))
    assert apart_m < OFFBOARD_JUMP_M


@pytest.mark.long
def test_while_a_new_origin_is_not_told_the_vehicle_holds_and_then_goes_on() -> None:
    deaf = Deaf(ORIGIN_ID)
    flight = EarthFlight(ZURICH, {"at_s": 14.3, "origin": OTHER_ORIGIN}, up=deaf)
    flight.until_reported(PhaseEntered, phase=Phase.TASK)
    deaf.is_deaf = True
    flight.until_reported(FrameDoubted)
    flight.run(2.0)
    stopped = flight.truth[-1]
    flight.run(3.0)
    assert math.dist(stopped, flight.truth[-1]) < 0.5
    assert flight.asked >= 4
    deaf.is_deaf = False
    flight.until_reported(FrameTrusted, limit_s=3.0)
    assert flight.until_the_end().exit_code == 0 and flight.was_inside
    assert len(flight.of(SkillCompleted, action="look")) == 1
    assert math.hypot(*flight.truth[-1][:2]) < 0.3


def test_a_vehicle_that_is_never_told_lands_where_it_holds() -> None:
    deaf = Deaf(ORIGIN_ID)
    flight = EarthFlight(ZURICH, {"at_s": 14.3, "origin": OTHER_ORIGIN}, up=deaf)
    flight.until_reported(PhaseEntered, phase=Phase.TASK)
    deaf.is_deaf = True
    flight.until_reported(FrameDoubted)
    held = flight.truth[-1]
    flight.until_the_end()
    assert flight.exit_code == 5 and f"apart, by its GPS_GLOBAL_ORIGIN, for {LOST_S:.0f} s" in str(
        flight.companion.failure
    )
    assert flight.was_inside and horizontal_distance(held, flight.truth[-1]) < 3.0
    assert not flight.simulation.is_armed and not flight.simulation.is_damaged


# -- what is refused at the start ------------------------------------------------------------------


def refusal(flight: Lockstep) -> str:
    """Why it did not begin; nothing was armed."""
    flight.until_the_end()
    assert flight.exit_code == 5 and flight.armings == 0
    return str(flight.companion.failure)


def elsewhere(latitude: float, longitude: float) -> Lockstep:
    """The mission's vehicle stands somewhere else on the earth."""
    mission = load_mission(mission_of(ZURICH))
    there = {"latitude_deg": latitude, "longitude_deg": longitude, "altitude_m": 488.0}
    return Lockstep(mission, world_of(mission, {"version": 1, "home": there}))


def test_a_vehicle_far_from_home_does_not_begin() -> None:
    told = refusal(elsewhere(48.5, 8.6))
    assert "the vehicle is 123 km from Home, where the mission begins" in told
    assert "it is at 48.5, 8.6, and Home is at 47.3977, 8.54559" in told
    assert "exchanged" not in told
    assert "are exchanged in one of them" in refusal(elsewhere(8.545594, 47.397742))


def test_a_vehicle_beside_home_does_not_begin() -> None:
    assert "the vehicle stands 11.1 m from Home" in refusal(elsewhere(47.397842, 8.545594))


class FalseOrigin:
    """GPS_GLOBAL_ORIGIN says that the origin lies further north than it does."""

    def __init__(self, by_m: float) -> None:
        self.by = round(by_m / 0.011132)
        self._ear, self._voice = MavlinkCodec(0, 0), MavlinkCodec(1, 1)

    def __call__(self, now_s: float, datagrams: list[bytes]) -> list[bytes]:
        return [self._changed(d) for d in datagrams]

    def _changed(self, datagram: bytes) -> bytes:
        if datagram[7:10] != ORIGIN_ID.to_bytes(3, "little"):
            return datagram
        (message,) = self._ear.parse(datagram)
        message.latitude += self.by
        return self._voice.pack(copy.copy(message))


def test_positions_that_disagree_by_more_than_a_metre_are_not_flown_by() -> None:
    told = refusal(EarthFlight(ZURICH, up=FalseOrigin(3.0)))
    assert "LOCAL_POSITION_NED and GLOBAL_POSITION_INT are 3.0 m apart" in told
    flight = EarthFlight(ZURICH, up=FalseOrigin(0.4))
    (located,) = flight.until_reported(FrameLocated).of(FrameLocated)
    assert located.residual_m == pytest.approx(0.4, abs=0.03)


def test_without_an_origin_it_is_asked_for_and_then_not_begun() -> None:
    deaf = Deaf(ORIGIN_ID)
    deaf.is_deaf = True
    flight = EarthFlight(ZURICH, up=deaf)
    assert "does not say where its local frame lies on the earth" in refusal(flight)
    assert flight.asked >= 8


def test_an_origin_that_was_told_before_is_asked_for() -> None:
    deaf = Deaf(ORIGIN_ID)
    deaf.is_deaf = True
    flight = EarthFlight(ZURICH, up=deaf)
    flight.run(0.5)
    deaf.is_deaf = False
    flight.until_reported(FrameLocated, limit_s=3.0)
    assert flight.asked >= 1


# -- places above the sea --------------------------------------------------------------------------


def above_sea(amsl_m: float, home_amsl_m: float = 488.0) -> Lockstep:
    """A is given above the sea; nothing in the mission says how high home lies."""
    data = mission_of(ZURICH)
    del data["places"]["A"]["up_m"]
    data["places"]["A"]["amsl_m"] = amsl_m
    mission = load_mission(data)
    there = world(ZURICH)
    there["home"]["altitude_m"] = home_amsl_m
    return Lockstep(mission, world_of(mission, there))


@pytest.mark.parametrize("home_amsl_m", [pytest.param(488.0, marks=pytest.mark.long), 481.5])
def test_a_place_above_the_sea_is_flown_at_its_height(home_amsl_m: float) -> None:
    flight = above_sea(500.0, home_amsl_m)
    flight.until_reported(PlaceReached, place="A").run(2.0)
    up_m = -flight.simulation.flight.position[2]
    assert up_m == pytest.approx(500.0 - home_amsl_m, abs=0.15)
    assert flight.until_the_end().exit_code == 0


def test_a_place_that_is_too_high_above_the_ground_is_refused_before_arming() -> None:
    told = refusal(above_sea(536.0))
    assert "place A is 48.0 m above home, outside 2 to 30 m" in told
    assert "home is 488.0 m above the sea" in told


@pytest.mark.long
def test_a_flight_that_was_cut_off_goes_on_where_it_was_on_the_earth() -> None:
    """Also where the autopilot counts from another origin by then."""
    data = mission_of(ZURICH)
    del data["places"]["A"]["up_m"]
    data["places"]["A"]["amsl_m"] = 500.0
    mission = load_mission(data)
    there = world_of(mission, world(ZURICH, {"at_s": 11.0, "origin": OTHER_ORIGIN}))
    flight = Lockstep(mission, there, resumes=True)
    flight.until_reported(PhaseEntered, phase=Phase.TASK).run(4.0)
    flight.kill()
    flight.run(5.0)
    flight.restart()
    flight.until_reported(PlaceReached, place="A").run(1.0)
    place = GlobalOrigin(*ZURICH.home, 488.0).to_local(*ZURICH.place, 500.0)
    assert math.dist(flight.simulation.flight.position, place) < 0.3
    assert flight.until_the_end().exit_code == 0


@pytest.mark.long
def test_an_origin_that_moves_before_the_take_off_changes_nothing() -> None:
    flight = EarthFlight(ZURICH, {"at_s": 1.0, "origin": OTHER_ORIGIN})
    flight.until_reported(PlaceReached, place="A").run(1.0)
    place = GlobalOrigin(*ZURICH.home, 488.0).to_local(*ZURICH.place, 500.0)
    assert math.dist(flight.simulation.flight.position, place) < 0.3
    assert flight.until_the_end().exit_code == 0 and flight.was_inside


@pytest.mark.parametrize("at_s", [3.5, 5.0], ids=["taking off", "climbing"])
def test_an_origin_that_moves_in_the_climb_ends_it_in_a_hold(at_s: float) -> None:
    """The autopilot ends the climb too low, and nobody can tell that from a pilot who holds."""
    flight = EarthFlight(ZURICH, {"at_s": at_s, "origin": OTHER_ORIGIN})
    assert flight.until_the_end().exit_code == 5
    assert flight.simulation.mode == "AUTO.LOITER"
    assert math.hypot(*flight.simulation.flight.position[:2]) < 0.3 and flight.was_inside


def test_polygons_in_degrees_are_kept_to() -> None:
    """A keep-out zone across the straight way, and a region that is a polygon."""
    data, home = mission_of(ZURICH), GlobalOrigin(*ZURICH.home, 0.0)

    def corners(*points: tuple[float, float]) -> list[list[float]]:
        return [list(home.to_global((*point, 0.0))[:2]) for point in points]

    zone = ((15.0, 25.0), (15.0, 15.0), (35.0, 15.0), (35.0, 25.0))
    data["limits"]["keep_out"] = {"pylon": corners(*zone)}
    flight = EarthFlight(ZURICH, data=data).until_the_end()
    assert flight.exit_code == 0
    assert not any(is_in_polygon(each, zone) for each in flight.truth)
    straight = [(share * 50.9, share * 45.6) for share in (0.4, 0.45, 0.5)]
    assert any(is_in_polygon(point, zone) for point in straight)


@pytest.mark.long
def test_the_page_of_a_run_shows_the_vehicle_where_it_is() -> None:
    """It hears what the companion hears, also of an origin that moves."""
    mission = load_mission(mission_of(ZURICH))
    watcher = Watcher(mission.grid, mission.anchor)

    def overheard(now_s: float, datagrams: list[bytes]) -> list[bytes]:
        watcher.hear(now_s, datagrams)
        return datagrams

    flight = EarthFlight(ZURICH, {"at_s": 14.3, "origin": OTHER_ORIGIN}, up=overheard)
    flight.until_reported(PlaceReached, place="A")
    shown = watcher.snapshot(flight.now_s)
    assert shown is not None
    assert math.dist(shown.position, flight.simulation.flight.position) < 0.2
