"""Garbage on the companion's link: it raises nothing, beats on, and answers each command once.

Half is random bytes and pieces of frames, half are the messages that ground stations send to
component 191, valid but for their fields. A few thousand datagrams by default; 60,000 of each kind
with the marker `long`.
"""

from __future__ import annotations

import random
import struct
from collections import Counter
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest
from autopilot import Autopilot
from garbage import KINDS, any_frame, frame, payload_of, random_bytes, truncated_frame, with_fields
from notes import Notes
from preparations import Polled
from synthetic import mission

from companion.app import Companion
from companion.flight_events.event import Stamped
from companion.flight_events.sortie import Phase, PhaseEntered
from companion.ground.checking import CheckResult
from companion.ground.component import WANTED
from companion.ground.parameters import NAMES
from companion.ground.uploads import Uploads
from companion.mavlink.framing import MavlinkCodec, dialect
from companion.mission.model import Mission
from companion.mission_run import Recorder
from companion.run_sources.hosted_runs import HostedRuns
from companion.run_sources.only_run import OnlyRun
from companion.tick import TICK_S

TASK = "G F at(A) & G F at(B)"
PER_TICK = 4
COMMANDS = ("COMMAND_LONG", "COMMAND_INT")
SERVICES = sorted(
    number
    for number in KINDS
    if (name := dialect.mavlink_map[number].msgname) in WANTED or name.startswith("MISSION_")
)
FTP: int = dialect.MAVLINK_MSG_ID_FILE_TRANSFER_PROTOCOL
KNOWN = [
    dialect.MAV_CMD_MISSION_START,
    dialect.MAV_CMD_DO_PAUSE_CONTINUE,
    dialect.MAV_CMD_NAV_RETURN_TO_LAUNCH,
    dialect.MAV_CMD_DO_SET_MISSION_CURRENT,
    dialect.MAV_CMD_REQUEST_MESSAGE,
    dialect.MAV_CMD_REQUEST_PROTOCOL_VERSION,
    dialect.MAV_CMD_REQUEST_AUTOPILOT_CAPABILITIES,
    dialect.MAV_CMD_USER_1,
]
STATIONS = [(255, 190), (250, 1)]
PATHS = [b"a.yaml", b"maps", b"maps/a.pgm", b"/", b"../a.yaml", b"verdict.json"]
NUMBERS = [6_000, pytest.param(60_000, marks=pytest.mark.long)]


def ftp_request(rng: random.Random) -> bytes:
    """A payload of MAVLink FTP whose opcode and size make sense."""
    data = rng.choice([rng.randbytes(rng.randrange(240)), rng.choice(PATHS), b"a: 1\n"])
    head = struct.pack(
        "<HBBBBBBI",
        *(rng.randrange(65536), rng.randrange(2), rng.randrange(17), len(data), 0, 0, 0),
        rng.choice([0, 0, 0, rng.randrange(1000), rng.getrandbits(32)]),
    )
    return head + data


def for_the_companion(rng: random.Random, knows: bool) -> bytes:
    """A message to component 191, or to all; one that `knows` uses words that it understands."""
    number = rng.choice([rng.choice(SERVICES), FTP])
    fields = {"target_system": b"\1", "target_component": rng.choice([b"\xbf", b"\xbf", b"\0"])}
    if knows and rng.random() < 0.5:
        fields["command"] = struct.pack("<H", rng.choice(KNOWN))
        fields["param1"] = struct.pack("<f", rng.randrange(3))
        fields["param_id"] = rng.choice(NAMES).encode()
        fields["param_type"] = struct.pack("B", rng.choice([6, 9]))
    if knows:
        fields["payload"] = ftp_request(rng)
    payload = with_fields(number, payload_of(number, rng), fields)
    return frame(number, payload, rng, rng.choice(STATIONS))


def garbage(rng: random.Random, knows: bool) -> bytes:
    if rng.random() < 0.5:
        return rng.choice([random_bytes, truncated_frame, any_frame])(rng)
    return for_the_companion(rng, knows)


def means_nothing(datagram: bytes) -> bool:
    """Whether it sets and commands nothing that the companion knows, nor comes from on board."""
    for message in MavlinkCodec(0, 0).parse(datagram):
        is_known = getattr(message, "command", 0) in KNOWN
        if is_known or message.get_type() == "PARAM_SET" or message.get_srcSystem() == 1:
            return False
    return True


class Aboard(Notes):
    """A companion, the recorder of its runs and their host, with an autopilot without physics."""

    def __init__(self, root: Path | None = None) -> None:
        super().__init__()
        self.runs = 0
        self.uploads = Uploads(root, lambda folder, mission: Refused()) if root else None
        flown = mission(TASK)
        self.companion = Companion(
            HostedRuns(self, flown) if self.uploads else OnlyRun(flown, self)
        )
        self.beats_s: list[float] = []
        self.acknowledged = 0
        self._autopilot, self._ear = Autopilot(), MavlinkCodec(0, 0)
        self._answers: list[bytes] = []
        self._ticks = 0

    def load(self, path: Path) -> Mission:
        raise AssertionError("nothing that was uploaded here may be flown")

    def prepare(
        self, mission: Mission, speed_max_mps: float, ground_amsl_m: float | None
    ) -> Polled:
        return Polled(mission, speed_max_mps)

    def begin_run(self, mission: Mission) -> Recorder:
        self.runs += 1
        return self

    def end_run(self, recorder: Recorder) -> None:
        """Nothing is kept open."""

    def tell(self, stamped: Stamped) -> None:
        self.report(stamped)

    def tick(self, datagrams: list[bytes]) -> None:
        """One tick; every command to it is answered in it, once, to who has sent it."""
        now_s = self._ticks * TICK_S
        self._ticks += 1
        arriving = [*self._answers, *self._autopilot.telemetry(), *datagrams]
        sent = self.companion.step(now_s, arriving)
        self._answers = self._autopilot.answer(sent)
        if self._autopilot.is_landed:
            self._autopilot.mode, self._autopilot.position[2] = "AUTO.LOITER", 0.0
        left = [message for datagram in sent for message in self._ear.parse(datagram)]
        self.beats_s += [now_s for m in left if m.get_type() == "HEARTBEAT"]
        answers = Counter(
            (m.target_system, m.target_component, m.command)
            for m in left
            if m.get_type() == "COMMAND_ACK"
        )
        assert answers == asked_in(datagrams)
        self.acknowledged += answers.total()

    def beats_each_second(self) -> bool:
        gaps = [later - earlier for earlier, later in pairwise(self.beats_s)]
        ends_s = self._ticks * TICK_S - self.beats_s[-1]
        return max(*gaps, ends_s) < 1.0 + 1.5 * TICK_S


class Refused:
    """A check that is over at once."""

    def poll(self) -> CheckResult:
        return CheckResult(False, "no mission")

    def kill(self) -> None:
        """It is over."""


def asked_in(datagrams: list[bytes]) -> Counter[tuple[int, int, int]]:
    """The commands to component 191, by who sent them."""
    ear = MavlinkCodec(0, 0)
    messages: list[Any] = [m for d in datagrams for m in ear.parse(d)]
    return Counter(
        (m.get_srcSystem(), m.get_srcComponent(), m.command)
        for m in messages
        if m.get_type() in COMMANDS and (m.target_system, m.target_component) == (1, 191)
    )


@pytest.mark.parametrize("number", NUMBERS, ids=["few", "many"])
def test_a_companion_that_hosts_survives_what_ground_stations_cannot_mean(
    number: int, tmp_path: Path
) -> None:
    """They start, pause, call home, set parameters and write files as chance will have it."""
    rng = random.Random(9)
    aboard = Aboard(root=tmp_path)
    for _ in range(number // PER_TICK):
        aboard.tick([garbage(rng, knows=True) for _ in range(PER_TICK)])
    assert aboard.beats_each_second()
    assert not (tmp_path / "incoming" / "verdict.json").is_dir()
    assert aboard.runs >= 1 and aboard.acknowledged > number // 100
    assert PhaseEntered(Phase.TASK) in aboard.events


@pytest.mark.parametrize("number", NUMBERS, ids=["few", "many"])
def test_a_flight_takes_no_notice_of_what_means_nothing(number: int) -> None:
    """What is reported is the same, as far as it goes, as if nobody had said anything."""
    rng = random.Random(10)
    disturbed, undisturbed = Aboard(), Aboard()
    for _ in range(number // PER_TICK):
        said = [garbage(rng, knows=False) for _ in range(PER_TICK)]
        disturbed.tick([datagram for datagram in said if means_nothing(datagram)])
        undisturbed.tick([])
    assert disturbed.beats_each_second()
    assert disturbed.reports == undisturbed.reports
    assert "A" in disturbed.places and disturbed.acknowledged > number // 100
