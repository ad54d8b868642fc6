"""A companion that hosts: from MISSION_START to the run, while the mission is prepared.

In lockstep; the preparation is done when it was asked so often.
"""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest
from autopilot import Autopilot, of_type
from notes import Notes
from preparations import Polled
from synthetic import mission

from companion.acting.preparation import PreparedMission
from companion.app import Companion
from companion.errors import CompanionError, NoPlanError
from companion.flight_events.event import Stamped
from companion.flight_events.fence import FenceMissing
from companion.flight_events.hosting import MissionReady, RunNotBegun
from companion.flight_events.plans import PlanMade
from companion.flight_events.sortie import Phase, PhaseEntered, RunEnded, TaskSatisfied
from companion.ground.operations import SystemStatus
from companion.mavlink.framing import MavlinkCodec, dialect
from companion.mission.model import Mission
from companion.mission_run import Recorder
from companion.run_sources.hosted_runs import HostedRuns
from companion.tick import TICK_S

ACCEPTED, NOT_NOW = dialect.MAV_RESULT_ACCEPTED, dialect.MAV_RESULT_TEMPORARILY_REJECTED
START = dialect.MAV_CMD_MISSION_START
PAUSE = dialect.MAV_CMD_DO_PAUSE_CONTINUE
RETURN = dialect.MAV_CMD_NAV_RETURN_TO_LAUNCH
TAKES_S = 4.0
"""A preparation, at a poll in each tick."""


class Refused:
    """A preparation that fails."""

    def done(self) -> bool:
        return True

    def result(self) -> PreparedMission:
        raise CompanionError("the planner made a wrong plan")


class Hosted(Notes):
    """A companion, its host and recorder, an autopilot without physics, and a ground station.

    Attributes:
        prepared: missions whose preparation was begun, with the speed that was allowed.
        begun: missions of which a run was begun.
        upload: a mission that was accepted and waits to be taken.
        told: news between two runs.
        beats_s: when HEARTBEAT left.
    """

    def __init__(self, flown: Mission, polls: int = round(TAKES_S / TICK_S)) -> None:
        super().__init__()
        self.prepared: list[tuple[str, float]] = []
        self.begun: list[str] = []
        self.upload: Mission | None = None
        self.told: list[Any] = []
        self.beats_s: list[float] = []
        self.preparation: Any = None
        self.autopilot = Autopilot()
        self.uploads: Any = self
        self.companion = Companion(HostedRuns(self, flown))
        self.now_s = 0.0
        self._polls = polls
        self._station, self._ear = MavlinkCodec(255, 190), MavlinkCodec(0, 0)
        self._answers: list[bytes] = []
        self.pass_time(1.0)

    # -- run_sources.host.Host -----------------------------------------------------------------

    def load(self, path: Path) -> Mission:
        assert self.upload is not None
        taken, self.upload = self.upload, None
        return taken

    def prepare(self, mission: Mission, speed_max_mps: float, ground_amsl_m: float | None) -> Any:
        self.prepared.append((str(mission.task["task"]), speed_max_mps))
        return self.preparation or Polled(mission, speed_max_mps, self._polls)

    def begin_run(self, mission: Mission) -> Recorder:
        self.begun.append(str(mission.task["task"]))
        return self

    def end_run(self, recorder: Recorder) -> None:
        """Nothing is kept open."""

    def tell(self, stamped: Stamped) -> None:
        self.told.append(stamped.event)

    # -- ground.operations.UploadService -------------------------------------------------------

    @property
    def has_waiting(self) -> bool:
        return self.upload is not None and self.is_flying

    def poll(self, now_s: float, is_flying: bool) -> list[Any]:
        self.is_flying = is_flying
        return []

    def take_active(self) -> Path | None:
        return Path("upload.yaml") if self.upload else None

    # -- time ----------------------------------------------------------------------------------

    def tick(self, *asked: Any) -> list[Any]:
        """One tick; what left the companion in it."""
        arriving = [*self._answers, *self.autopilot.telemetry(), *map(self._station.pack, asked)]
        sent = self.companion.step(self.now_s, arriving)
        self._answers = self.autopilot.answer(sent)
        left = [message for datagram in sent for message in self._ear.parse(datagram)]
        self.beats_s += [self.now_s for _ in of_type(left, "HEARTBEAT")]
        self.now_s += TICK_S
        return left

    def pass_time(self, duration_s: float) -> None:
        for _ in range(round(duration_s / TICK_S)):
            self.tick()

    def ask(self, command: int, *parameters: float) -> int:
        """The answer of component 191 to a command."""
        values = [*parameters, *[0.0] * (7 - len(parameters))]
        asked = dialect.MAVLink_command_long_message(1, 191, command, 0, *values)
        (answer,) = of_type(self.tick(asked), "COMMAND_ACK")
        return int(answer.result)

    def fly(self) -> None:
        """Until the run that was begun has ended."""
        while not self.reports or not isinstance(self.reports[-1].event, RunEnded):
            self.tick()
            assert self.now_s < 120.0, "it does not end"


@pytest.fixture
def hosted() -> Hosted:
    """MISSION_START was accepted a second ago; nothing is flown yet."""
    hosted = Hosted(mission("F at(A)"))
    assert hosted.ask(START) == ACCEPTED
    hosted.pass_time(1.0)
    return hosted


def test_a_mission_is_flown_when_it_is_prepared(hosted: Hosted) -> None:
    assert hosted.begun == [] and hosted.reports == []
    hosted.fly()
    assert hosted.prepared == [("F at(A)", 50.0)] and hosted.begun == ["F at(A)"]
    assert hosted.reports[-1].event == TaskSatisfied()


def test_the_time_of_a_run_begins_with_the_run(hosted: Hosted) -> None:
    """Time limits of the autopilot's answers count in it."""
    hosted.fly()
    times_s = {type(s.event): s.time_s for s in reversed(hosted.reports)}
    assert times_s[PlanMade] <= 2 * TICK_S
    checking, fence, arming = hosted.events[1:4]
    assert [checking, arming] == [PhaseEntered(Phase.CHECKING), PhaseEntered(Phase.ARMING)]
    assert isinstance(fence, FenceMissing)


def test_heartbeats_go_on_while_it_is_prepared(hosted: Hosted) -> None:
    hosted.pass_time(TAKES_S - 1.5)
    assert hosted.begun == []
    gaps = [later - earlier for earlier, later in pairwise(hosted.beats_s)]
    assert len(gaps) >= 3 and all(1.0 - 1e-9 <= gap <= 1.0 + TICK_S + 1e-9 for gap in gaps[1:])


def test_it_is_idle_and_on_standby_while_it_is_prepared(hosted: Hosted) -> None:
    """Files are still taken as fast as they come; the first tick of the run keeps its time."""
    assert hosted.companion.system_status is SystemStatus.STANDBY
    idle = []
    while not hosted.begun:
        idle.append(hosted.companion.is_idle)
        hosted.tick()
    assert idle == [True] * (len(idle) - 1) + [False]


def test_a_second_start_is_accepted_and_starts_nothing_twice(hosted: Hosted) -> None:
    assert hosted.ask(START) == ACCEPTED
    hosted.fly()
    hosted.pass_time(2 * TAKES_S)
    assert len(hosted.prepared) == len(hosted.begun) == 1


@pytest.mark.parametrize("command", [PAUSE, RETURN])
def test_there_is_nothing_to_pause_or_call_home_yet(hosted: Hosted, command: int) -> None:
    assert hosted.ask(command) == NOT_NOW
    hosted.fly()
    assert hosted.reports[-1].event == TaskSatisfied()


def arms(autopilot: Autopilot) -> None:
    autopilot.is_armed = True


def takes_off(autopilot: Autopilot) -> None:
    autopilot.is_landed = False


def falls_silent(autopilot: Autopilot) -> None:
    autopilot.unsent = {"HEARTBEAT", "LOCAL_POSITION_NED", "EXTENDED_SYS_STATE", "ATTITUDE"}


@pytest.mark.parametrize("happens", [arms, takes_off, falls_silent])
def test_a_vehicle_that_is_not_as_it_was_is_left_alone(happens: Any) -> None:
    hosted = Hosted(mission("F at(A)"), polls=round(15.0 / TICK_S))
    assert hosted.ask(START) == ACCEPTED
    happens(hosted.autopilot)
    hosted.pass_time(16.0)
    assert [type(event) for event in hosted.told] == [RunNotBegun]
    assert hosted.begun == [] and hosted.reports == []
    assert of_type(hosted.autopilot.heard, "COMMAND_LONG") == []
    hosted.autopilot = Autopilot()  # on the ground again
    hosted.pass_time(1.0)
    assert hosted.ask(START) == ACCEPTED
    hosted.fly()
    assert len(hosted.prepared) == 2


def test_a_start_of_a_vehicle_that_was_armed_meanwhile_is_refused(hosted: Hosted) -> None:
    hosted.autopilot.is_armed = True
    hosted.tick()
    assert hosted.ask(START) == NOT_NOW


def test_a_stop_ends_it_without_a_run(hosted: Hosted) -> None:
    hosted.companion.stop()
    assert hosted.companion.has_ended
    hosted.pass_time(2 * TAKES_S)  # a step that was under way
    assert hosted.begun == []


def test_a_start_beside_a_newer_upload_is_refused_before_the_take_off_too(hosted: Hosted) -> None:
    while not hosted.begun:
        hosted.tick()
    assert hosted.ask(START) == ACCEPTED
    hosted.upload = mission("F at(B)")
    hosted.tick()
    assert hosted.ask(START) == NOT_NOW
    hosted.fly()
    assert hosted.begun == ["F at(A)"]


def test_an_upload_is_kept_for_the_next_start(hosted: Hosted) -> None:
    """The host is told that the mission that is active has started: that is the one of the run."""
    hosted.upload = mission("F at(B)")
    hosted.pass_time(1.0)
    assert hosted.upload is not None and hosted.told == [] and hosted.is_flying
    assert hosted.ask(START) == NOT_NOW  # this one is not what is about to be flown
    hosted.fly()
    hosted.pass_time(1.0)
    assert hosted.told == [MissionReady("synthetic")]
    assert hosted.ask(START) == ACCEPTED
    hosted.pass_time(TAKES_S + 1.0)
    assert hosted.begun == ["F at(A)", "F at(B)"]


def test_a_task_without_a_plan_is_told_by_its_run() -> None:
    hosted = Hosted(mission("F at(A) & G !at(A)"))
    assert hosted.ask(START) == ACCEPTED
    hosted.fly()
    end = hosted.reports[-1].event
    assert isinstance(end, RunEnded) and end.exit_code == NoPlanError.exit_code
    assert hosted.companion.system_status is SystemStatus.CRITICAL
    assert not hosted.companion.has_ended


def test_a_preparation_that_fails_is_told_and_the_next_one_flies() -> None:
    hosted = Hosted(mission("F at(A)"))
    hosted.preparation = Refused()
    assert hosted.ask(START) == ACCEPTED
    hosted.pass_time(1.0)
    assert hosted.told == [RunNotBegun("the planner made a wrong plan")]
    assert hosted.begun == []
    hosted.preparation = None
    assert hosted.ask(START) == ACCEPTED
    hosted.fly()


def test_a_run_without_a_folder_does_not_begin(
    hosted: Hosted, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(mission: Mission) -> Recorder:
        raise OSError("disk full")

    monkeypatch.setattr(hosted, "begin_run", full)
    hosted.pass_time(TAKES_S)
    assert hosted.told == [RunNotBegun("no run folder: disk full")]


def test_the_speed_that_an_operator_allows_counts_in_the_first_plan() -> None:
    costs_s = []
    for speed_mps in (50.0, 0.5):
        hosted = Hosted(mission("F at(A)"))
        hosted.tick(dialect.MAVLink_param_set_message(1, 191, b"CMP_SPEED_MAX", speed_mps, 9))
        assert hosted.ask(START) == ACCEPTED
        hosted.pass_time(TAKES_S + 1.0)
        assert hosted.prepared == [("F at(A)", speed_mps)]
        (made,) = hosted.of(PlanMade)
        costs_s.append(made.plan.prefix_cost_s)
    assert costs_s[1] > 2 * costs_s[0]
