"""The mission's fence is the autopilot's too: in force before arming, and held by both.

The simulator's autopilot has PX4's rules: it takes every fence and reads it back whole, leaves out
areas without its home, loads equal items once, and holds in OFFBOARD when a fence is left.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import pytest
from lockstep import COMPANION, VEHICLE, Cut, Deaf, Lockstep, Lossy
from meadow import (
    CIRCLE,
    DATA,
    POLYGON,
    POND,
    SQUARE,
    areas,
    armed,
    mission,
    push_out,
    refused,
    start,
    station_uploads,
    upload,
)

from companion.acting.sortie.preflight.arming_terms import ArmingTerms, UploadPolicy
from companion.flight_events.fence import (
    FenceChange,
    FenceChanged,
    FenceKept,
    FenceReplaced,
    FenceWritten,
)
from companion.flight_events.sortie import (
    AutopilotSaid,
    ControlTakenBack,
    ControlYielded,
    Phase,
    PhaseEntered,
    SetpointRefused,
)
from companion.flights.simulated_world import world_of
from companion.geofence import FencePolygon
from companion.geometry import GlobalOrigin, is_in_polygon
from companion.mavlink.framing import dialect
from companion.mission.loader import load_mission
from companion.mission.model import Mission
from companion.vehicle.flight_memory import FlightMemory
from companion.vehicle.ports.setpoints import Setpoint
from companion.vehicle.setpoint_stream import SetpointStream
from sitl.world.scenario_events import ScenarioEvent, TimeTrigger
from sitl.world.schema import WindEventModel


def at(origin: GlobalOrigin) -> dict[str, float]:
    degrees = {"latitude_deg": origin.latitude_deg, "longitude_deg": origin.longitude_deg}
    return degrees | {"altitude_m": origin.altitude_m}


def mission_on_earth(home: GlobalOrigin, fence: Sequence[Sequence[float]]) -> Mission:
    """The same mission in latitude and longitude."""
    places = {
        name: dict(zip(("lat_deg", "lon_deg"), home.to_global((0.0, east, 0.0)), strict=False))
        | {"up_m": 3, "radius_m": 2}
        for name, east in (("Home", 0.0), ("A", 20.0))
    }
    limits = {"speed_mps": 4, "up_m": [1, 10], "fence": [list(corner) for corner in fence]}
    return load_mission(DATA | {"frame": "wgs84", "places": places, "limits": limits})


def test_it_is_in_force_before_arming_and_costs_three_seconds() -> None:
    flight = armed(start())
    assert flight.one(FenceWritten).fence == "8 points, 2 areas"
    inclusion, pond = areas(flight)
    assert inclusion.is_inclusion and not pond.is_inclusion
    for area, corners in ((inclusion, SQUARE), (pond, POND)):
        assert FencePolygon(corners).is_like(area.shape, within_m=0.05)
    times_s = [s.time_s for s in flight.reports if isinstance(s.event, PhaseEntered)]
    assert times_s[1] - times_s[0] < 3.5


@pytest.mark.parametrize("seed", [0, *(pytest.param(n, marks=pytest.mark.long) for n in (1, 2))])
def test_a_link_that_loses_a_third_delays_it_alone(seed: int) -> None:
    flight = start(up=Lossy(0.3, seed), down=Lossy(0.3, 100 + seed))
    assert armed(flight).of(FenceWritten) != []
    assert len(areas(flight)) == 2


@pytest.mark.parametrize("frame", ["enu", "wgs84"])
def test_it_lies_where_it_was_drawn_wherever_the_origin_is(frame: str) -> None:
    """The autopilot counts from a point 2 km away, and by its own projection about that."""
    home = GlobalOrigin(47.397742, 8.545594, 488.0)
    origin = GlobalOrigin(47.4112, 8.5283, 455.0)
    degrees = [home.to_global((*corner, 0.0))[:2] for corner in SQUARE]
    asked = mission() if frame == "enu" else mission_on_earth(home, degrees)
    flight = Lockstep(
        asked, world_of(asked, {"version": 1, "home": at(home), "origin": at(origin)})
    )
    (area,) = areas(armed(flight))
    if frame == "enu":
        north, east, _ = origin.to_local(home.latitude_deg, home.longitude_deg, 0.0)
        drawn = [(n + north, e + east) for n, e in SQUARE]
    else:
        drawn = [origin.to_local(*each, 0.0)[:2] for each in degrees]
    assert FencePolygon(tuple(drawn)).is_like(area.shape, within_m=0.1)


def test_a_fence_that_somebody_changes_in_flight_is_reported_once() -> None:
    flight = armed(start(has_station=True))
    assert not flight.of(FenceChanged)
    flight.until_reported(PhaseEntered, 60.0, phase=Phase.TASK)
    corners = [(POLYGON, 4.0, (north, east, 0.0)) for north, east in SQUARE]
    station_uploads(flight, *corners)
    changed = flight.until_reported(FenceChanged, 3.0)
    assert changed.one(FenceChanged).change is FenceChange.REPLACED
    flight.station_says(
        dialect.MAVLink_mission_clear_all_message(VEHICLE, 1, dialect.MAV_MISSION_TYPE_FENCE)
    )
    flight.until_the_end()
    changes = [event.change for event in flight.of(FenceChanged)]
    assert changes == [FenceChange.REPLACED, FenceChange.REMOVED]
    assert flight.exit_code == 0


@pytest.mark.parametrize("loss", [0.0, 0.5])
def test_one_that_the_companion_itself_writes_is_not(loss: float) -> None:
    flight = start(down=Lossy(loss, 7), policy=UploadPolicy.REPLACE)
    station_uploads(flight, (CIRCLE, 60.0, (0.0, 0.0, 0.0)))
    flight.until_reported(PhaseEntered, 90.0, phase=Phase.TASK)
    flight.run(3.0)
    assert flight.of(FenceReplaced) and not flight.of(FenceChanged)


def test_a_fence_across_the_180th_meridian_is_not_written_because_px4_misreads_it() -> None:
    home = GlobalOrigin(-16.8, 179.9999, 5.0)
    degrees = [home.to_global((*corner, 0.0))[:2] for corner in SQUARE]
    asked = mission_on_earth(home, degrees)
    world = world_of(asked, {"version": 1, "home": at(home)})
    flight = Lockstep(asked, world)
    assert refused(flight) == (
        "PX4 cannot keep the mission's fence: a polygon crosses the 180th meridian, where PX4 "
        "takes it for another one\n    --autopilot-fence none leaves it alone"
    )
    assert areas(flight) == ()
    flight = Lockstep(asked, world, arming=ArmingTerms(fence=UploadPolicy.NONE))
    flight.until_the_end()
    assert flight.exit_code == 0


def test_the_autopilot_leaves_out_an_area_across_the_180th_meridian() -> None:
    """A ground station has drawn it; it does not contain home, and nothing else near it."""
    home = GlobalOrigin(-16.8, 179.9999, 5.0)
    corners = [(POLYGON, 4.0, home.to_global((*corner, 0.0))) for corner in SQUARE]
    world = world_of(mission(), {"version": 1, "home": at(home)})
    flight = Lockstep(mission(), world, has_station=True)
    upload(flight, *corners)
    assert areas(flight) == ()
    assert "a polygon crosses the 180th meridian" in refused(flight)


def test_somebody_elses_fence_is_refused_with_both_ways_out() -> None:
    flight = start()
    station_uploads(flight, (CIRCLE, 400.0, (0.0, 0.0, 0.0)))
    reason = refused(flight)
    assert reason.startswith("the vehicle has another fence (1 point, 1 area)\n")
    assert "--autopilot-fence keep" in reason and "--autopilot-fence replace" in reason
    (area,) = areas(flight)
    assert area.shape.radius_m == 400.0


@pytest.mark.parametrize("policy", [UploadPolicy.KEEP, UploadPolicy.REPLACE])
def test_it_is_kept_or_replaced_as_the_operator_says(policy: UploadPolicy) -> None:
    flight = start(policy=policy)
    station_uploads(flight, (CIRCLE, 400.0, (0.0, 0.0, 0.0)))
    armed(flight)
    told = FenceKept if policy is UploadPolicy.KEEP else FenceReplaced
    assert len(flight.of(told)) == 1
    assert len(areas(flight)) == (1 if policy is UploadPolicy.KEEP else 2)


def test_a_kept_fence_without_a_place_is_refused_by_its_name() -> None:
    flight = start(policy=UploadPolicy.KEEP)
    station_uploads(flight, (CIRCLE, 10.0, (0.0, 0.0, 0.0)))
    assert refused(flight) == "A lies outside the vehicle's own fence (area 1 of 1)"


def test_a_circle_before_a_polygon_is_seen() -> None:
    flight = start(policy=UploadPolicy.KEEP)
    corners = [(POLYGON, 4.0, (n, e, 0.0)) for n, e in SQUARE]
    station_uploads(flight, (CIRCLE, 400.0, (0.0, 0.0, 0.0)), *corners)
    assert "a circle stands before a polygon" in refused(flight)


def home_moves(flight: Lockstep) -> None:
    """The autopilot's home is elsewhere from now on, as by DO_SET_HOME."""
    flight.until_reported(PhaseEntered, phase=Phase.CHECKING)
    flight.simulation._autopilot.home = (300.0, 0.0, 0.0)


def test_a_home_elsewhere_is_seen() -> None:
    flight = start()
    home_moves(flight)
    assert "home" in refused(flight).lower()


@pytest.mark.parametrize("has_station", [False, True])
def test_an_area_that_is_left_out_is_heard_of(has_station: bool) -> None:
    """By PX4's event, or its text where a ground station is; nothing else shows it."""
    home = Deaf(dialect.MAVLINK_MSG_ID_HOME_POSITION)
    flight = start(up=home, has_station=has_station)
    home_moves(flight)
    home.is_deaf = True
    reason = refused(flight)
    assert "and leaves a part of it out" in reason
    assert "Geofence invalid, doesn't contain Home position" in reason
    assert [area.is_inclusion for area in areas(flight)] == [False]


def test_the_next_mission_of_this_companion_replaces_its_own() -> None:
    own = FlightMemory()
    first = armed(start(own=own))
    assert len(own.fences.written) == 1
    bigger = mission(tuple((n * 1.5, e * 1.5) for n, e in SQUARE))
    second = start(bigger, own=own)
    second.simulation = first.simulation
    second._ticks = first._ticks
    second.station_commands(dialect.MAV_CMD_COMPONENT_ARM_DISARM, 0, 21196)
    second.is_companion_alive = False
    second.run(1.0)
    second.is_companion_alive = True
    armed(second)
    told = second.one(FenceReplaced)
    assert (told.before, told.fence) == ("8 points, 2 areas", "4 points, 1 area")


def test_another_sender_that_pushes_it_out_is_held_by_the_autopilot() -> None:
    flight = start().until_reported(PhaseEntered, phase=Phase.TASK)

    def is_pushed_out() -> bool:
        push_out(flight)
        return flight.companion.has_ended

    flight.until(is_pushed_out, 60.0)
    assert flight.exit_code == 5
    assert flight.ending.text == "a failsafe of the autopilot has control, in AUTO.LOITER"
    assert flight.simulation.mode == "AUTO.LOITER"
    assert any("geofence" in said.words for said in flight.of(AutopilotSaid))
    held_s = flight.now_s
    flight.run(5.0)
    assert flight.simulation.mode == "AUTO.LOITER", "it does not come back by itself"
    assert all(sent.time_s <= held_s for sent in flight.setpoints)


def test_resume_does_not_go_on_from_a_breach_that_follows_a_short_silence() -> None:
    """Which looks like the hold by which the autopilot answers the loss of our stream."""
    link = Cut()
    flight = start(resumes=True, up=link).until_reported(PhaseEntered, phase=Phase.TASK)

    def is_pushed_out() -> bool:
        push_out(flight)
        link.is_cut = -14.7 < flight.simulation.flight.position[0] < -10.0
        return flight.of(ControlYielded) != []

    flight.until(is_pushed_out, 60.0)
    yielded_s = flight.now_s
    flight.run(20.0)
    assert flight.of(ControlTakenBack) == [] and flight.simulation.mode == "AUTO.LOITER"
    flight.station_commands(dialect.MAV_CMD_DO_PAUSE_CONTINUE, 1.0, component=COMPANION)
    flight.run(2.0)
    assert flight.simulation.mode == "AUTO.LOITER"
    assert max(sent.time_s for sent in flight.setpoints) <= yielded_s


def test_what_leaves_the_fence_is_refused_by_the_companions_own_gate(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Its margin lies inside, so the autopilot's fence on the same edge is never reached."""
    flight = start().until_reported(PhaseEntered, phase=Phase.TASK)
    fly = SetpointStream.fly

    def away(stream: SetpointStream, setpoint: Setpoint, **purpose: bool) -> None:
        fly(stream, replace(setpoint, position=(-15.2, 10.0, -3.0)), **purpose)

    monkeypatch.setattr(SetpointStream, "fly", away)
    before = len(flight.setpoints)
    flight.run(3.0)
    assert {event.reason for event in flight.of(SetpointRefused)} == {"outside the fence"}
    for sent in flight.setpoints[before + 1 :]:
        assert is_in_polygon((sent.message.x, sent.message.y), SQUARE)
    assert flight.simulation.mode == "OFFBOARD"


@pytest.mark.parametrize("blows_s", [6.0, 7.0])
def test_a_breach_in_the_climb_is_the_autopilots(blows_s: float) -> None:
    """Its hold looks like the end of the climb. Going on would take the vehicle from the fence."""
    asked = mission(((-15.0, -1.0), (-15.0, 35.0), (15.0, 35.0), (15.0, -1.0)))
    scenario, grid = world_of(asked, None)
    gale = ScenarioEvent(TimeTrigger(blows_s), (("wind", WindEventModel(east_mps=-18.0)),), "wind")
    scenario = replace(scenario, airframe="px4_sih", events=(gale,))
    flight = Lockstep(asked, (scenario, grid), has_station=True)
    flight.until(lambda: flight.companion.has_ended, 40.0)
    assert flight.exit_code == 5
    assert flight.ending.text == "a failsafe of the autopilot has control, in AUTO.LOITER"
    assert "OFFBOARD" not in [mode for _, mode in flight.modes]
