"""Somebody on the link sends HEARTBEATs as if from the autopilot, in another mode."""

from __future__ import annotations

from functools import cache
from random import Random

import pytest
from campaign import LONGEST_S, actions, shipped, sweep, undisturbed, world
from lockstep import VEHICLE, Lockstep

from companion.errors import Aborted
from companion.flight_events.sortie import Phase, PhaseEntered, RunEnded
from companion.mavlink.framing import MavlinkCodec, dialect
from companion.mavlink.px4_modes import custom_mode
from companion.tick import TICK_S

pytestmark = pytest.mark.faults

SURVEILLANCE = "surveillance"
HEARTBEAT = bytes([0, 0, 0])
FLOWN_PHASES = (Phase.ARMING, Phase.TAKE_OFF, Phase.OFFBOARD, Phase.TASK, Phase.LANDING)


class Forger:
    """Sends one at each of some times, with the number that the autopilot's next message has.

    Attributes:
        sent_s: when it has.
    """

    def __init__(self, times_s: list[float], mode: str = "POSCTL") -> None:
        self._times_s = sorted(times_s)
        self._codec = MavlinkCodec(VEHICLE, 1)
        self._mode = custom_mode(mode)
        self.sent_s: list[float] = []

    def __call__(self, now_s: float, datagrams: list[bytes]) -> list[bytes]:
        numbers = [d[4] for d in datagrams if d[6] == 1]
        if not self._times_s or now_s < self._times_s[0] or not numbers:
            return datagrams
        self._times_s.pop(0)
        self.sent_s.append(now_s)
        self._codec.sequence = numbers[-1]
        status = dialect.MAV_STATE_ACTIVE
        forged = dialect.MAVLink_heartbeat_message(2, 12, 1, self._mode, status, 3)
        return [*datagrams, self._codec.pack(forged)]


@cache
def heartbeats_s() -> list[float]:
    """When the undisturbed flight hears the autopilot's heartbeats."""
    heard_s: list[float] = []

    def listen(now_s: float, datagrams: list[bytes]) -> list[bytes]:
        if any(d[6] == 1 and d[7:10] == HEARTBEAT for d in datagrams):
            heard_s.append(now_s)
        return datagrams

    flight = Lockstep(shipped(SURVEILLANCE), world(SURVEILLANCE), up=listen)
    flight.until(lambda: flight.companion.has_ended, LONGEST_S)
    return heard_s


@pytest.mark.long
def test_one_forged_heartbeat_after_another_changes_no_action() -> None:
    """One in each fourth second of the flight, at different times of it, from arming to landing.

    None right behind the autopilot's own: in a landing, a vehicle that is said to be disarmed for
    half a second has crashed.
    """
    chance, heard_s = Random("forged"), heartbeats_s()
    times_s = [heard_s[i + 1] - chance.uniform(0.1, 0.45) for i in range(3, len(heard_s) - 2, 4)]
    forger = Forger(times_s)
    flight = Lockstep(shipped(SURVEILLANCE), world(SURVEILLANCE), up=forger)
    flight.until(lambda: flight.companion.has_ended, LONGEST_S)
    assert len(forger.sent_s) > 8
    assert actions(flight) == actions(undisturbed(SURVEILLANCE))
    assert flight.armings == undisturbed(SURVEILLANCE).armings


@pytest.mark.parametrize("phase", sweep(FLOWN_PHASES, few=lambda phase: phase is Phase.TASK))
def test_nothing_leaves_from_the_first_on(phase: Phase) -> None:
    """Two in a row; the autopilot's own does not come with either."""
    begin_s = undisturbed(SURVEILLANCE).time_of(PhaseEntered, phase=phase)
    first_s = begin_s + 0.3
    if any(first_s - TICK_S < own_s < first_s + 2 * TICK_S for own_s in heartbeats_s()):
        first_s += 3 * TICK_S
    forger = Forger([first_s, first_s + TICK_S])
    flight = Lockstep(shipped(SURVEILLANCE), world(SURVEILLANCE), up=forger).run_for(begin_s + 5.0)
    sent = [s for s in (*flight.setpoints, *flight.commands) if s.time_s >= forger.sent_s[0]]
    assert sent == []
    assert flight.exit_code == Aborted.exit_code
    assert flight.time_of(RunEnded) == pytest.approx(forger.sent_s[1], abs=TICK_S)


@pytest.mark.parametrize("seed", sweep(range(40), few=lambda seed: seed < 1))
def test_a_forged_heartbeat_at_any_time_costs_no_more_than_a_hold(seed: int) -> None:
    """Whenever it comes: nothing arms again, and the flight ends well or is left to a failsafe."""
    end_s = undisturbed(SURVEILLANCE).time_of(RunEnded)
    forger = Forger([Random(f"forged {seed}").uniform(3.0, end_s - 1.0)])
    flight = Lockstep(shipped(SURVEILLANCE), world(SURVEILLANCE), up=forger)
    flight.until(lambda: flight.companion.has_ended, LONGEST_S)
    assert flight.armings == undisturbed(SURVEILLANCE).armings
    assert flight.simulation.collisions == 0
    assert flight.exit_code in (0, Aborted.exit_code)
