"""What the vehicle flies by goes away: the ground station, the satellites, the time of day."""

from __future__ import annotations

import math
import time
from itertools import count

import pytest
from campaign import fly, shipped, sweep, undisturbed, world
from lockstep import Lockstep

from companion.errors import Aborted
from companion.flight_events.sortie import Phase, PhaseEntered, RunFailed, SetpointRefused
from companion.mavlink.framing import MavlinkCodec, dialect
from companion.tick import TICK_S
from companion.vehicle.position_watch import WORST_M

pytestmark = pytest.mark.faults

SURVEILLANCE = "surveillance"
HOUR_US = 3_600_000_000


@pytest.mark.parametrize("away_s", sweep((2.0, 15.0, 200.0), few=lambda away_s: away_s == 15.0))
def test_a_ground_station_that_is_gone_changes_nothing(away_s: float) -> None:
    """And when it is there again it hears what happens."""
    gone = {"at_s": 8, "link": {"port": "ground", "loss": 1}}
    back = {"at_s": 8 + away_s, "link": {}}
    flight, calm = (
        Lockstep(shipped(SURVEILLANCE), world(SURVEILLANCE, *faults), has_station=True)
        for faults in ((gone, back), ())
    )
    assert flight.until_the_end().story == calm.until_the_end().story
    texts = [s.time_s for s in flight.heard if s.message.get_type() == "STATUSTEXT"]
    assert not [time_s for time_s in texts if 8.1 < time_s < 8.0 + away_s]
    heard_again = [time_s for time_s in texts if time_s >= 8.0 + away_s]
    assert bool(heard_again) is (8.0 + away_s < flight.now_s)


@pytest.mark.parametrize("at_s", sweep((6.0, 10.0, 22.0, 30.0), few=lambda at_s: at_s == 10.0))
def test_without_satellites_the_autopilot_has_the_vehicle(at_s: float) -> None:
    """Once its estimate is bad; then nothing is sent, also when they are back."""
    lost, back = ({"at_s": t, "gps": {"lost": t == at_s}} for t in (at_s, at_s + 12.0))
    flight = fly(SURVEILLANCE, lost, back)
    (taken_s,) = [time_s for time_s, mode in flight.modes if mode == "ALTCTL"]
    ended = RunFailed("a failsafe of the autopilot has control, in ALTCTL", Aborted.exit_code)
    assert flight.ending == ended
    flight.run(15.0)
    sent = [s.time_s for s in (*flight.setpoints, *flight.commands)]
    assert at_s < taken_s < at_s + 6.0
    assert max(sent) <= taken_s


@pytest.mark.parametrize("at_s", sweep((8.0, 10.0, 22.0, 30.0), few=lambda at_s: at_s == 10.0))
@pytest.mark.parametrize("noise_m", [pytest.param(0.0, marks=pytest.mark.long), 0.25])
def test_without_satellites_nothing_moves_a_second_after_the_bound(
    at_s: float, noise_m: float
) -> None:
    """The autopilot tells its accuracy once a second, and takes the vehicle only later."""
    noise = {"at_s": 0.1, "gps": {"noise_m": noise_m}}
    lost = {"at_s": at_s, "gps": {"lost": True, "noise_m": noise_m}}
    flight = Lockstep(shipped(SURVEILLANCE), world(SURVEILLANCE, noise, lost))
    flight.until(lambda: flight.simulation._estimator.accuracy_m > WORST_M)
    bound_s = flight.now_s
    assert at_s < bound_s and flight.simulation.mode == "OFFBOARD"
    flight.until(lambda: flight.simulation.mode != "OFFBOARD", 10.0)
    later = [s.message for s in flight.setpoints if s.time_s > bound_s + 1.0 + 2 * TICK_S]
    assert flight.now_s - bound_s > 1.2 and len(later) > 3
    assert not any(math.hypot(m.vx, m.vy, m.vz) for m in later)
    assert "gets worse" in flight.of(SetpointRefused)[-1].reason


@pytest.mark.long
@pytest.mark.parametrize("away_s", [2.0, 4.8])
def test_a_short_loss_of_satellites_changes_no_action(away_s: float) -> None:
    """Meanwhile the vehicle keeps more from walls, as its position is good for less, or holds.

    By a wider way it may pass beside where the target is seen, and see it a lap later.
    """
    back = {"at_s": 10 + away_s, "gps": {"lost": False}}
    flight = fly(SURVEILLANCE, {"at_s": 10, "gps": {"lost": True}}, back)
    refused = [event.reason for event in flight.of(SetpointRefused)]
    assert bool(refused) is (away_s > 4.0) and all("gets worse" in why for why in refused)
    expected = undisturbed(SURVEILLANCE)
    laps, places = flight.places[: -len(expected.places)], flight.places[-len(expected.places) :]
    assert places == expected.places and laps == [*"ABC"] * (len(laps) // 3)
    assert flight.ending == expected.ending
    assert flight.simulation.collisions == 0


@pytest.mark.parametrize("step_us", [pytest.param(HOUR_US, marks=pytest.mark.long), -HOUR_US])
def test_a_clock_that_is_set_moves_no_flight(step_us: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Neither ours nor the autopilot's: each second another hour."""
    autopilot, ticks = MavlinkCodec(1, 1), count()
    hours = count(1)
    monkeypatch.setattr(time, "time", lambda: 1.8e9 + 1e-6 * step_us * next(hours))

    def told_the_time(now_s: float, datagrams: list[bytes]) -> list[bytes]:
        unix_us = 1_800_000_000_000_000 + step_us * next(ticks)
        said = dialect.MAVLink_system_time_message(unix_us, round(1e3 * now_s))
        return [*datagrams, autopilot.pack(said)]

    flight = fly(SURVEILLANCE, up=told_the_time)
    assert flight.reports == undisturbed(SURVEILLANCE).reports


@pytest.mark.parametrize(
    ("vehicle_s", "station_s"),
    sweep((0.0, 5.0), (0.0, 4.0, 20.0), few=lambda vehicle_s, station_s: station_s == 4.0),
)
def test_they_may_be_started_in_any_order(vehicle_s: float, station_s: float) -> None:
    """Companion, vehicle and ground station; who comes late is heard from then on."""
    absent = {"at_s": 0, "link": {"port": "ground", "loss": 1}}
    present = {"at_s": station_s, "link": {"port": "ground"}}
    silent = {"at_s": 0, "link": {"port": "companion", "loss": 1}}
    speaks = {"at_s": vehicle_s, "link": {"port": "companion"}}
    happens = [absent, present, silent, speaks]
    flight = Lockstep(shipped(SURVEILLANCE), world(SURVEILLANCE, *happens), has_station=True)
    flight.until_reported(PhaseEntered, phase=Phase.TASK).run(station_s)
    assert flight.time_of(PhaseEntered, phase=Phase.TASK) >= vehicle_s
    assert [s for s in flight.heard if s.message.get_type() == "HEARTBEAT"]
