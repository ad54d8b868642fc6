"""Gimbals, message by message: control first, frames and flags, and when one points there."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any, cast

import pytest
from states import changed, flying

from companion.mavlink.framing import MavlinkCodec, dialect
from companion.outcomes import Failed, Outcome, Progress
from companion.vehicle.gimbals import CONFIGURE, PITCHYAW, TURN_S, MavlinkGimbals
from companion.vehicle.ports.gimbals import Aim
from companion.vehicle.services import Moment
from companion.vehicle.telemetry import Telemetry
from companion.vehicle.wire import Wire

AUTOPILOT, DEVICE, TICK_S = 1, 154, 0.05
HEADING_RAD = math.radians(120.0)
ACCEPTED, DENIED = dialect.MAV_RESULT_ACCEPTED, dialect.MAV_RESULT_DENIED
LOCK, VEHICLE, EARTH = 16, 32, 64


class Talk:
    """A manager that answers as it was told; what is sent is in `sent`."""

    def __init__(self, manager: int = DEVICE) -> None:
        telemetry = SimpleNamespace(state=changed(flying(), yaw_rad=HEADING_RAD))
        self.gimbals = MavlinkGimbals(
            cast(Wire, SimpleNamespace(system=1)), cast(Telemetry, telemetry)
        )
        self.manager = manager
        self.answers = {CONFIGURE: ACCEPTED, PITCHYAW: ACCEPTED}
        self.sent: list[Any] = []
        self.now_s = 10.0
        self._codecs = {id: MavlinkCodec(1, id) for id in (manager, DEVICE)}
        self._ticket = 0

    def points(self, aim: Aim) -> Talk:
        self.run(0.1)
        self._ticket = self.gimbals.point(self.manager, aim, None)
        self.run(0.5)
        return self

    @property
    def outcome(self) -> Outcome:
        return self.gimbals.outcome(self._ticket)

    def says(self, component: int, message: Any) -> None:
        codec = self._codecs[component]
        (parsed,) = codec.parse(codec.pack(message))
        self.gimbals.take(Moment(self.now_s, self.now_s, is_quiet=False), parsed)

    def attitude(self, pitch_deg: float, yaw_deg: float, flags: int, device: int = DEVICE) -> None:
        p, y = math.radians(pitch_deg) / 2, math.radians(yaw_deg) / 2
        q = (
            math.cos(p) * math.cos(y),
            -math.sin(p) * math.sin(y),
            math.sin(p) * math.cos(y),
            math.cos(p) * math.sin(y),
        )
        told = dialect.MAVLink_gimbal_device_attitude_status_message(
            target_system=0,
            target_component=0,
            time_boot_ms=0,
            flags=flags,
            q=q,
            angular_velocity_x=0.0,
            angular_velocity_y=0.0,
            angular_velocity_z=0.0,
            failure_flags=0,
            delta_yaw=math.nan,
            delta_yaw_velocity=math.nan,
            gimbal_device_id=0,
        )
        self.says(device, told)
        self.run(TICK_S)

    def status(self, device: int, *control: int) -> None:
        message = dialect.MAVLink_gimbal_manager_status_message(0, 0, device, *control, 0, 0)
        self.says(self.manager, message)

    def run(self, seconds: float) -> None:
        for _ in range(round(seconds / TICK_S)):
            self.now_s += TICK_S
            moment = Moment(self.now_s, self.now_s, is_quiet=False)
            self.gimbals.step(moment)
            for message in self.gimbals.due(moment):
                self.sent.append(message)
                result = self.answers.get(message.command)
                if result is not None:
                    answer = dialect.MAVLink_command_ack_message(
                        message.command, result, target_system=1, target_component=191
                    )
                    self.says(self.manager, answer)


DOWN = Aim(math.radians(-45.0), math.radians(30.0), is_from_north=False)
NORTH = Aim(math.radians(-45.0), math.radians(30.0), is_from_north=True)


@pytest.mark.parametrize(("aim", "flags"), [(DOWN, 4 + 8 + VEHICLE), (NORTH, 4 + 8 + LOCK + EARTH)])
def test_control_is_asked_for_in_figures_then_the_direction(aim: Aim, flags: int) -> None:
    talk = Talk().points(aim)
    configure, turn = talk.sent
    assert (configure.command, configure.target_component) == (CONFIGURE, DEVICE)
    assert (configure.param1, configure.param2, configure.param3) == (1.0, 191.0, -1.0)
    assert turn.command == PITCHYAW
    assert (turn.param1, turn.param2) == pytest.approx((-45.0, 30.0))
    assert math.isnan(turn.param3) and turn.param5 == flags
    assert talk.outcome is Progress.RUNNING  # accepted, and not there


@pytest.mark.parametrize(
    ("aim", "yaw_deg", "flags"),
    [
        (DOWN, 30.0, VEHICLE),
        (DOWN, 150.0, EARTH),
        (DOWN, 30.0, 0),
        (DOWN, 150.0, LOCK),
        (NORTH, 30.0, EARTH),
        (NORTH, -90.0, VEHICLE),
        (NORTH, -90.0, VEHICLE | LOCK),
    ],
)
def test_it_is_there_by_the_attitude_in_whatever_frame(
    aim: Aim, yaw_deg: float, flags: int
) -> None:
    talk = Talk().points(aim)
    talk.attitude(-45.0, yaw_deg + 4.0, flags)
    beside = talk.outcome
    talk.attitude(-43.5, yaw_deg, flags)
    assert (beside, talk.outcome) == (Progress.RUNNING, Progress.DONE)


def test_straight_down_has_no_yaw() -> None:
    talk = Talk().points(Aim(-math.pi / 2, 0.0, is_from_north=True))
    talk.attitude(-89.0, 77.0, EARTH)
    assert talk.outcome == Progress.DONE


def test_an_attitude_from_before_the_answer_says_nothing() -> None:
    talk = Talk()
    talk.answers.pop(PITCHYAW)
    talk.points(DOWN)
    talk.attitude(-45.0, 30.0, VEHICLE)
    assert talk.outcome is Progress.RUNNING


def test_the_device_of_a_manager_is_the_one_that_it_names() -> None:
    talk = Talk(AUTOPILOT).points(DOWN)
    talk.status(DEVICE, 1, 191)
    talk.attitude(-45.0, 30.0, VEHICLE)
    assert talk.outcome == Progress.DONE
    talk = Talk(AUTOPILOT).points(DOWN)
    talk.status(1, 1, 191)  # a gimbal of its own, on servo outputs
    talk.attitude(-45.0, 30.0, VEHICLE)
    by_another = talk.outcome
    talk.attitude(-45.0, 30.0, VEHICLE, device=AUTOPILOT)
    assert (by_another, talk.outcome) == (Progress.RUNNING, Progress.DONE)


def test_a_denial_says_who_has_control() -> None:
    talk = Talk()
    talk.answers[PITCHYAW] = DENIED
    talk.status(DEVICE, 255, 190)
    talk.points(DOWN)
    told = "the gimbal (component 154): denied; component 190 of system 255 controls it"
    assert talk.outcome == Failed(told)


@pytest.mark.parametrize(
    ("yaw_deg", "words"), [(60.0, "is 21 degrees off"), (None, "does not say where it points")]
)
def test_one_that_does_not_get_there(yaw_deg: float | None, words: str) -> None:
    talk = Talk().points(DOWN)
    if yaw_deg is not None:
        talk.attitude(-45.0, yaw_deg, VEHICLE)
    talk.run(TURN_S)
    assert talk.outcome == Failed(f"the gimbal (component 154) {words} after 15 s")


def test_control_is_given_back_once() -> None:
    talk = Talk().points(DOWN)
    talk.sent.clear()
    for _ in range(3):
        talk.gimbals.give_back()
        talk.run(1.0)
    (message,) = talk.sent
    assert (message.command, message.param1, message.param2) == (CONFIGURE, -3.0, -3.0)
