"""Frames as an attacker makes them, through the real parser: nothing is raised, nothing changes.

Those of `attacks.py`; taken in, verified, chosen and decoded as on the companion's link. A few
thousand by default, and with the markers `faults` and `long` 2,000,000 for a companion that waits
on the ground, and as many in flight.
"""

from __future__ import annotations

import random
from pathlib import Path

import pytest
from attacks import KEY, NOW_S, PER_TICK, attacks, means_nothing
from autopilot import Autopilot
from notes import Notes
from preparations import Polled
from synthetic import mission

from companion.app import Companion
from companion.flight_events.event import Stamped
from companion.flight_events.sortie import Phase, PhaseEntered
from companion.mavlink.framing import dialect, message_id, split_frames
from companion.mavlink.intake import Intake
from companion.mavlink.signing import Signing, of_signed_vehicle
from companion.mission.model import Mission
from companion.mission_run import Recorder
from companion.run_sources.hosted_runs import HostedRuns
from companion.run_sources.only_run import OnlyRun

TICK_S = 0.05
ATTACKER, AUTOPILOT = ("127.0.0.1", 40000), ("127.0.0.1", 14580)
TAKE_OFF_S = 6.0
"""No setpoint is needed for so long."""
ASKING = frozenset(
    {
        dialect.MAVLINK_MSG_ID_COMMAND_INT,
        dialect.MAVLINK_MSG_ID_COMMAND_LONG,
        dialect.MAVLINK_MSG_ID_PARAM_SET,
        dialect.MAVLINK_MSG_ID_SET_MODE,
        dialect.MAVLINK_MSG_ID_SET_POSITION_TARGET_LOCAL_NED,
    }
)
"""Messages by which something is asked of a vehicle."""
FRAMES = [
    4_000,
    pytest.param(1_000_000, marks=[pytest.mark.faults, pytest.mark.long]),
]
"""Of each of the four: with and without signing, in flight and on the ground."""


class Waiting(Notes):
    """The host of a companion that waits on the ground, and has no reason to fly."""

    uploads = None

    def load(self, path: Path) -> Mission:
        raise AssertionError("nothing is uploaded")

    def prepare(
        self, mission: Mission, speed_max_mps: float, ground_amsl_m: float | None
    ) -> Polled:
        raise AssertionError("nobody starts")

    def begin_run(self, mission: Mission) -> Recorder:
        raise AssertionError("nobody starts")

    def end_run(self, recorder: Recorder) -> None:
        raise AssertionError("nothing has begun")

    def tell(self, stamped: Stamped) -> None:
        self.report(stamped)


class Aboard:
    """A companion with an autopilot that is heard in each tick, and what a fuzzer sends besides.

    Attributes:
        notes: what was reported.
        beats: how many heartbeats left.
        asked: of the vehicle in the newest tick, without the numbers of the frames.
    """

    def __init__(self, signing: Signing | None, is_flying: bool) -> None:
        flown = mission("G F at(A) & G F at(B)")
        waiting = Waiting()
        self.notes: Notes = Notes() if is_flying else waiting
        self.beats, self.asked = 0, list[bytes]()
        self._companion = Companion(
            OnlyRun(flown, self.notes) if is_flying else HostedRuns(waiting, flown)
        )
        self._autopilot, self._intake = Autopilot(), Intake()
        self._answers: list[bytes] = []
        self._signing, self._vehicle = signing, Signing(KEY, NOW_S) if signing else None

    def tick(self, now_s: float, datagrams: list[bytes]) -> None:
        own = [*self._answers, *self._autopilot.telemetry()]
        if self._vehicle is not None:
            own = self._vehicle.send(now_s, own)
        self._intake.begin_step()
        taken = [d for d in datagrams if self._intake.takes(ATTACKER, d, AUTOPILOT)]
        arrived = [*taken, *own]
        if self._signing is not None:
            arrived = self._signing.receive(now_s, arrived)
            assert [f for f in arrived if f in own] == own, "the autopilot is always heard"
        sent = self._companion.step(now_s, arrived)
        frames = [frame for datagram in sent for frame in split_frames(datagram)]
        self.beats += sum(message_id(f) == dialect.MAVLINK_MSG_ID_HEARTBEAT for f in frames)
        self.asked = [f[5:-2] for f in frames if message_id(f) in ASKING]
        self._answers = self._autopilot.answer(sent)


@pytest.mark.parametrize("is_flying", [True, False], ids=["in flight", "on the ground"])
@pytest.mark.parametrize("is_signed", [True, False], ids=["signed", "unsigned"])
@pytest.mark.parametrize("number", FRAMES, ids=["few", "million"])
def test_a_companion_is_as_if_nobody_had_sent_anything(
    number: int, is_signed: bool, is_flying: bool
) -> None:
    """With a key whatever was sent; without one, whatever is damaged or from somebody else.

    In each tick it asks the same of the vehicle: the setpoint, in flight, and each command.
    """
    rng = random.Random(11)
    signing = Signing(KEY, NOW_S, of_signed_vehicle) if is_signed else None
    disturbed = Aboard(signing, is_flying)
    undisturbed = Aboard(Signing(KEY, NOW_S, of_signed_vehicle) if is_signed else None, is_flying)
    sent, silent_ticks = 0, 0
    for tick in range(number // PER_TICK):
        said = attacks(rng)
        sent += len(said)
        if not is_signed:
            said = [datagram for datagram in said if means_nothing(datagram)]
        disturbed.tick(tick * TICK_S, said)
        undisturbed.tick(tick * TICK_S, [])
        assert disturbed.asked == undisturbed.asked
        silent_ticks += not disturbed.asked
    assert sent >= number
    assert disturbed.notes.reports == undisturbed.notes.reports
    assert disturbed.beats == undisturbed.beats > 0
    if is_flying:
        assert PhaseEntered(Phase.TASK) in disturbed.notes.events
        assert silent_ticks * TICK_S < TAKE_OFF_S
    else:
        assert silent_ticks == number // PER_TICK
    if signing is not None:
        assert signing.refused.unsigned and signing.refused.forged and not signing.refused.old
