"""The pilot takes over at any time, and the companion's loop hangs at any time."""

from __future__ import annotations

from functools import cache
from random import Random
from typing import Any

import meadow
import pytest
from campaign import shipped, sweep, world
from lockstep import Cut, Lockstep

from companion.errors import Aborted
from companion.flight_events.sortie import Phase, PhaseEntered, RunEnded, RunFailed, VehicleLanded
from companion.flights.simulated_world import world_of
from companion.mavlink.framing import MavlinkCodec
from companion.mavlink.px4_modes import mode_name

pytestmark = pytest.mark.faults

SURVEILLANCE = "surveillance"
SILENT_WITHIN_S = 0.3
STANDS_S = 22.95
"""When the vehicle of the mission that lands at A stands there, disarmed."""
FAILSAFE_WITHIN_S = 1.3
"""COM_OF_LOSS_T, and what PX4 needs besides."""


class HeardModes:
    """When the companion first heard of each mode in which the vehicle was not before."""

    def __init__(self) -> None:
        self.first_s: dict[str, float] = {}
        self._codec = MavlinkCodec(0, 0)

    def __call__(self, now_s: float, datagrams: list[bytes]) -> list[bytes]:
        for datagram in datagrams:
            if datagram[5:10] == bytes([1, 1, 0, 0, 0]):  # HEARTBEAT of the autopilot
                for message in self._codec.parse(datagram):
                    self.first_s.setdefault(mode_name(message.custom_mode) or "", now_s)
        return datagrams


def begin(**options: Any) -> Lockstep:
    """The surveillance mission, not begun yet; arming is rejected for 3 s."""
    name = "MAV_CMD_COMPONENT_ARM_DISARM"
    rejected = {"at_s": 0, "answer": {"command": name, "answer": "TEMPORARILY_REJECTED"}}
    slow = world(SURVEILLANCE, rejected, {"at_s": 3, "answer": {"command": name}})
    return Lockstep(shipped(SURVEILLANCE), slow, **options)


@cache
def phase_times() -> list[tuple[Phase, float, float]]:
    """The phases of the mission from arming on, each with its begin and its end."""
    flight = begin().until_the_end()
    begun = [(s.event.phase, s.time_s) for s in flight.reports if isinstance(s.event, PhaseEntered)]
    ends = [*(time_s for _, time_s in begun[1:]), flight.time_of(RunEnded)]
    return [
        (phase, begin_s, end_s)
        for (phase, begin_s), end_s in zip(begun, ends, strict=True)
        if phase is not Phase.CHECKING
    ]


@pytest.mark.parametrize("seed", sweep(range(50), few=lambda seed: seed < 2))
def test_the_pilot_takes_over(seed: int) -> None:
    """In each phase in turn, at a random time of it."""
    phases = phase_times()
    phase, begin_s, end_s = phases[seed % len(phases)]
    at_s = Random(f"pilot {seed}").uniform(begin_s + 0.1, end_s - 0.3)
    heard = HeardModes()
    flight = begin(has_station=True, up=heard)
    flight.run(at_s)
    flight.station_chooses("AUTO.RTL")
    flight.run(5.0)
    assert "AUTO.RTL" in heard.first_s, phase
    limit_s = heard.first_s["AUTO.RTL"] + SILENT_WITHIN_S
    assert [s for s in (*flight.setpoints, *flight.commands) if s.time_s > limit_s] == []
    assert flight.exit_code == Aborted.exit_code
    assert flight.simulation.mode != "OFFBOARD" or not flight.simulation.is_armed


@pytest.mark.parametrize("seed", sweep(range(20), few=lambda seed: seed < 1))
def test_the_loop_hangs(seed: int) -> None:
    """Nothing beside the loop sends setpoints, so the autopilot's failsafe has the vehicle."""
    task = next(p for p in phase_times() if p[0] is Phase.TASK)
    flight = begin(seed=seed)
    flight.run(Random(f"hang {seed}").uniform(task[1] + 0.5, task[2] - 0.5))
    flight.is_companion_alive = False
    hung_s = flight.now_s
    flight.run(FAILSAFE_WITHIN_S)
    assert flight.setpoints[-1].time_s <= hung_s + SILENT_WITHIN_S
    assert flight.simulation.mode == "AUTO.LOITER"
    flight.run(8.0)
    assert flight.simulation.collisions == 0


@pytest.mark.parametrize(
    "mode",
    ["AUTO.LOITER", *(pytest.param(m, marks=pytest.mark.long) for m in ("AUTO.LAND", "ALTCTL"))],
)
def test_the_pilot_takes_over_while_the_vehicle_waits_on_the_ground(mode: str) -> None:
    """Disarmed, in the middle of a skill that lands: hold and land are chosen there as well."""
    mission = meadow.stay("land()", "wait(20)", "take_off()")
    flight = Lockstep(mission, world_of(mission, {"version": 1}), has_station=True)
    flight.until_reported(VehicleLanded).run(6.0)
    assert flight.simulation.mode == "OFFBOARD" and not flight.companion.has_ended
    flight.station_chooses(mode)
    flight.run(25.0)
    assert flight.armings == 1 and flight.exit_code == Aborted.exit_code
    ending = flight.ending
    assert isinstance(ending, RunFailed)
    assert ending.reason == f"the pilot has control, in {mode}"


@pytest.mark.parametrize(
    ("cut_s", "holds"),
    sweep(
        ((-1.0, 4.0), (-1.0, 8.0), (0.3, 5.0), (1.5, 5.0), (4.0, 8.0)),
        (True, False),
        few=lambda cut_s, holds: cut_s == (-1.0, 8.0) and holds,
    ),
)
def test_the_pilot_holds_on_the_ground_while_nothing_is_heard(
    cut_s: tuple[float, float], holds: bool
) -> None:
    """A link that is lost about the landing, and a vehicle that has stood in OFFBOARD."""
    mission = meadow.stay("land()", "wait(20)", "take_off()")
    air = Cut()
    world = world_of(mission, {"version": 1})
    flight = Lockstep(mission, world, up=air, has_station=True)
    flight.run(STANDS_S + cut_s[0])
    air.is_cut = True
    flight.run(STANDS_S + cut_s[1] - 1.0 - flight.now_s)
    assert not flight.simulation.is_armed and flight.simulation.mode == "OFFBOARD"
    if holds:
        flight.station_chooses("AUTO.LOITER")
    flight.run(1.0)
    air.is_cut = False
    flight.until_the_end()
    assert flight.armings == 1 + (not holds)
    assert (flight.exit_code == Aborted.exit_code) is holds
