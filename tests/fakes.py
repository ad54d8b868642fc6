"""A vehicle without MAVLink and without physics: a point that goes where its setpoint says.

Fulfils `companion.vehicle.port.Vehicle`. It does what its script says: goals are reached after a
delay or fail, commands are answered after a delay, in order. Time is an argument, as everywhere.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from companion.geofence import FenceArea, KeptFence, StoredFence
from companion.geometry import GlobalOrigin, Ned, NorthEast
from companion.motion.range_scan import RangeScan
from companion.outcomes import Refusal
from companion.rally_points import RallyPoint, StoredRally
from companion.vehicle.camera_port import (
    IntendedShot,
    NoPhoto,
    PhotoMade,
    ShotOutcome,
    ShotOwner,
    ShotReady,
)
from companion.vehicle.gimbal_port import Aim, Aimed, AimOutcome
from companion.vehicle.port import (
    Anchoring,
    Failed,
    FrameLocation,
    Goal,
    MarkerSighting,
    Mode,
    Outcome,
    Progress,
    Setpoint,
    Takeover,
    VehicleState,
)

CLOSING_MPS = 1.0
"""How much faster than its setpoint the point may be, to close a gap."""


def on_hold(now_s: float) -> VehicleState:
    """A vehicle in the air, on hold, of which all was heard just now."""
    return VehicleState(
        stamp_s=now_s,
        position=(1.0, 2.0, -3.0),
        velocity=(0.0, 0.0, 0.0),
        yaw_rad=0.0,
        mode=Mode.LOITER,
        is_armed=True,
        is_landed=False,
        is_failsafe=False,
        battery_percent=None,
        position_s=now_s,
        yaw_s=now_s,
        mode_s=now_s,
    )


class FakePayloads:
    """Answers commands as it was told.

    Attributes:
        answers: seconds and outcome for each command, in the order they are sent; then DONE.
        sent: every command, as (component, command, parameters).
        patience: how long the answer of each is waited for.
        left: the tickets of those that were left, and that nobody has come back to.
        forgotten: the tickets of those that were forgotten.
    """

    def __init__(self) -> None:
        self.answers: list[tuple[float, Outcome]] = []
        self.sent: list[tuple[int, int, tuple[float, ...]]] = []
        self.patience: list[float | None] = []
        self.left: list[int] = []
        self.forgotten: list[int] = []
        self._now_s = 0.0
        self._due: dict[int, tuple[float, Outcome]] = {}

    def number(self, command: str) -> int | None:
        return {"MAV_CMD_DO_GRIPPER": 211}.get(command)

    def step(self, now_s: float) -> None:
        """Time passes."""
        self._now_s = now_s

    def send(
        self, component: int, command: int, parameters: tuple[float, ...], timeout_s: float | None
    ) -> int:
        self.sent.append((component, command, parameters))
        self.patience.append(timeout_s)
        delay_s, outcome = self.answers.pop(0) if self.answers else (0.0, Progress.DONE)
        is_final = outcome is not Progress.RUNNING
        if timeout_s is not None and not (is_final and delay_s <= timeout_s):
            delay_s, outcome = timeout_s, Failed(f"no final answer in {timeout_s:g} s")
        self._due[len(self.sent)] = (self._now_s + delay_s, outcome)
        return len(self.sent)

    def outcome(self, ticket: int) -> Outcome:
        due_s, outcome = self._due[ticket]
        return outcome if self._now_s >= due_s else Progress.RUNNING

    def leave(self, ticket: int) -> None:
        self.left.append(ticket)

    def come_back(self, ticket: int) -> None:
        self.left.remove(ticket)

    def forget(self, ticket: int) -> None:
        self.forgotten.append(ticket)
        del self._due[ticket]


class FakeMarkers:
    """Sees what a test says.

    Attributes:
        seen, refused: since the tick before.
    """

    def __init__(self) -> None:
        self.seen: list[MarkerSighting] = []
        self.refused: list[Refusal] = []


class FakeFence:
    """The fence of an autopilot, which at first does not know where on the earth it is.

    Attributes:
        nowhere: why it does not; None where it does.
        stored: what it has.
        home: that of the autopilot.
        taken: what becomes of a fence that is written.
        objections: what is said when one is written.
        written: all that were written.
        is_mine: whether what it has was written by this companion, in another flight.
        is_as_sent: whether it tells what was written, wherever the frame is by now.
    """

    def __init__(self) -> None:
        self.is_as_sent = False
        self.nowhere: str | None = "the autopilot tells no position on the earth"
        self.stored: StoredFence | None = StoredFence((), 0)
        self.home: NorthEast | None = None
        self.outcome: Outcome = Progress.DONE
        self.taken: Outcome = Progress.DONE
        self.said: list[str] = []
        self.objections: list[str] = []
        self.written: list[tuple[FenceArea, ...]] = []
        self.is_mine = False
        self._vouched: object = None

    def locate(self) -> Outcome:
        return Progress.DONE if self.nowhere is None else Failed(self.nowhere)

    def read(self) -> None:
        """It is told at once."""

    def write(self, areas: Sequence[FenceArea]) -> None:
        self.written.append(tuple(areas))
        self.objections = list(self.said)
        if self.taken is Progress.DONE:
            self.stored = StoredFence(tuple(areas), 4 * len(areas))
        else:
            self.outcome = self.taken

    def is_own(self) -> bool:
        return self.is_mine

    def is_as_written(self) -> bool:
        return self.is_as_sent

    def is_vouched_for(self) -> bool:
        return self._vouched is self.stored

    def vouch(self) -> None:
        self._vouched = self.stored


class FakeRally:
    """The rally points of an autopilot, which knows where on the earth it is.

    Attributes:
        nowhere: why it does not; None where it does.
        stored: those that it has.
        taken: what becomes of those that are written.
        written: all that were written.
        is_mine: whether those that it has were written by this companion, in another flight.
        has_written: whether it has ever written some.
        reads: how often it was asked.
    """

    def __init__(self) -> None:
        self.nowhere: str | None = None
        self.stored: StoredRally | None = StoredRally(())
        self.outcome: Outcome = Progress.DONE
        self.taken: Outcome = Progress.DONE
        self.written: list[tuple[RallyPoint, ...]] = []
        self.is_mine = self.has_written = False
        self.reads = 0

    def locate(self) -> Outcome:
        return Progress.DONE if self.nowhere is None else Failed(self.nowhere)

    def read(self) -> None:
        """They are told at once."""
        self.reads += 1

    def write(self, points: Sequence[RallyPoint]) -> None:
        self.written.append(tuple(points))
        if self.taken is Progress.DONE:
            self.stored = StoredRally(tuple(points))
        else:
            self.outcome = self.taken

    def is_own(self) -> bool:
        return self.is_mine

    def is_as_written(self) -> bool:
        return False


class FakeCameras:
    """Makes every photo at once, unless it was told otherwise.

    Attributes:
        answers: seconds and outcome for each photo, in the order they are asked for; then made.
        prepared: whom each photo is for.
        shot: those that were asked for.
        recalled: photos of another process.
    """

    def __init__(self) -> None:
        self.answers: list[tuple[float, PhotoMade | NoPhoto]] = []
        self.prepared: list[tuple[int, ShotOwner]] = []
        self.shot: list[int] = []
        self.recalled: list[IntendedShot] = []
        self._now_s = 0.0
        self._due: dict[int, tuple[float, PhotoMade | NoPhoto]] = {}

    def step(self, now_s: float) -> None:
        """Time passes."""
        self._now_s = now_s

    def prepare(
        self, component: int, owner: ShotOwner, timeout_s: float | None, may_repeat: bool = False
    ) -> int:
        self.prepared.append((component, owner))
        return len(self.prepared)

    def shoot(self, ticket: int) -> None:
        self.shot.append(ticket)
        made = PhotoMade(len(self.shot), len(self.shot) - 1)
        delay_s, outcome = self.answers.pop(0) if self.answers else (0.0, made)
        self._due[ticket] = (self._now_s + delay_s, outcome)

    def outcome(self, ticket: int) -> ShotOutcome:
        if ticket not in self._due:
            return ShotReady(ticket, len(self.shot))
        due_s, outcome = self._due[ticket]
        return outcome if self._now_s >= due_s else None

    def forget(self, ticket: int) -> None:
        self._due.pop(ticket, None)

    def recall(self, shot: IntendedShot) -> None:
        self.recalled.append(shot)


class FakeGimbals:
    """Points wherever it is told to, at once.

    Attributes:
        outcomes: of each pointing, in order; then it points there.
        pointed: component and aim of each.
    """

    def __init__(self) -> None:
        self.outcomes: list[AimOutcome] = []
        self.pointed: list[tuple[int, Aim]] = []
        self._current: dict[int, AimOutcome] = {}

    def point(self, component: int, aim: Aim, timeout_s: float | None) -> int:
        self.pointed.append((component, aim))
        ticket = len(self.pointed)
        self._current[ticket] = self.outcomes.pop(0) if self.outcomes else Aimed()
        return ticket

    def outcome(self, ticket: int) -> AimOutcome:
        return self._current[ticket]

    def forget(self, ticket: int) -> None:
        del self._current[ticket]


class FakeVehicle:
    """Stands on the ground at first, disarmed.

    Attributes:
        script: goal -> after how many seconds it comes to which outcome; at once to DONE if absent.
        drift: where the point settles relative to its setpoint.
        is_stuck: it moves no longer.
        frame_doubt: why its position is not certain; nothing at first.
        location: where its frames lie on the earth; not known at first.
        anchoring: what decides where home lies.
        is_settling: it is measured where the vehicle stands.
        is_turning: its heading is that of its setpoint.
        payloads: its payloads.
        markers: what it sees of landing markers; nothing at first.
        takeoff_up_m: to where it takes off, unless it is told another altitude.
        fence, rally: of its autopilot.
        cameras: its cameras.
        gimbals: its gimbals.
        flown: every setpoint that it was given; None when it was released.
        pursued: the goals that were worked for, in order.
        scans: what it hears of its surroundings; nothing at first.
        parameters: the autopilot's parameters; strong failsafes at first.
    """

    def __init__(self, position: Ned = (0.0, 0.0, 0.0)) -> None:
        at_rest = (0.0, 0.0, 0.0)
        self.state: VehicleState | None = VehicleState(
            0.0, position, at_rest, 0.0, Mode.LOITER, False, True, False, 100
        )
        self.scans: list[RangeScan] = []
        self.takeover: Takeover | None = None
        self.is_doubted = self.has_restarted = False
        self.frame_doubt: Refusal | None = None
        self.origin: GlobalOrigin | None = None
        self.location: FrameLocation | None = None
        self.anchoring, self.is_settling = Anchoring.BY_VEHICLE, False
        self.refusal: Refusal | None = None
        self.takeoff_up_m = 2.0
        self.script: dict[Goal, tuple[float, Outcome]] = {}
        self.drift: Ned = (0.0, 0.0, 0.0)
        self.is_stuck = False
        self.is_turning = True
        self.flown: list[Setpoint | None] = []
        self.kept_fence: KeptFence | None = None
        self.payloads = FakePayloads()
        self.markers = FakeMarkers()
        self.fence = FakeFence()
        self.rally = FakeRally()
        self.cameras = FakeCameras()
        self.gimbals = FakeGimbals()
        self.pursued: list[Goal] = []
        self.parameters: dict[str, float] = {
            "COM_OF_LOSS_T": 1.0,
            "COM_OBL_RC_ACT": 5.0,
            "COM_LOW_BAT_ACT": 3.0,
            "GF_ACTION": 2.0,
            "COM_RCL_EXCEPT": 0.0,
            "RTL_RETURN_ALT": 30.0,
            "GF_MAX_HOR_DIST": 0.0,
            "GF_MAX_VER_DIST": 0.0,
            "MIS_TAKEOFF_ALT": 2.5,
        }
        self._now_s = self._since_s = 0.0

    @property
    def setpoint(self) -> Setpoint | None:
        return self.flown[-1] if self.flown else None

    def change(self, **fields: object) -> None:
        """Changes fields of the state."""
        assert self.state is not None
        self.state = replace(self.state, **fields)  # type: ignore[arg-type]

    def take_off(self, up_m: float) -> FakeVehicle:
        """In the air and in OFFBOARD, as when a task begins."""
        assert self.state is not None
        north, east, _ = self.state.position
        self.change(
            position=(north, east, -up_m), mode=Mode.OFFBOARD, is_armed=True, is_landed=False
        )
        return self

    def step(self, now_s: float) -> None:
        """Time passes: the point moves towards its setpoint, and its position is heard."""
        dt_s, self._now_s = now_s - self._now_s, now_s
        self.payloads.step(now_s)
        self.cameras.step(now_s)
        if self.state is None:
            return
        position, velocity = self.state.position, (0.0, 0.0, 0.0)
        yaw_rad = self.state.yaw_rad
        if self.setpoint is not None and not self.is_stuck and self.state.mode is Mode.OFFBOARD:
            velocity = self.setpoint.velocity
            reach_m = (math.hypot(*velocity) + CLOSING_MPS) * dt_s
            position = _towards(position, _sum(self.setpoint.position, self.drift), reach_m)
            yaw_rad = self.setpoint.yaw_rad if self.is_turning else yaw_rad
        heard = {"position": position, "velocity": velocity, "yaw_rad": yaw_rad}
        self.change(stamp_s=now_s, mode_s=now_s, position_s=now_s, yaw_s=now_s, **heard)

    def gap_m(self, place: Ned) -> float | None:
        return None if self.state is None else math.dist(self.state.position[:2], place[:2])

    def stand_at(self, place: Ned) -> None:
        """Its frame is true."""

    def parameter(self, name: str) -> float | None:
        return self.parameters.get(name)

    def pursue(self, goal: Goal, takeoff_up_m: float | None = None) -> Outcome:
        if not self.pursued or self.pursued[-1] is not goal:
            self.pursued.append(goal)
            self._since_s = self._now_s
        delay_s, outcome = self.script.get(goal, (0.0, Progress.DONE))
        if self._now_s - self._since_s < delay_s:
            return Progress.RUNNING
        if outcome is Progress.DONE:
            self.change(**AFTER[goal])
            if goal is Goal.AIRBORNE and self.state is not None:
                north, east, _ = self.state.position
                self.change(position=(north, east, -(takeoff_up_m or self.takeoff_up_m)))
        return outcome

    def fly(self, setpoint: Setpoint, is_for_task: bool = False, is_landing: bool = False) -> None:
        self.flown.append(setpoint)

    def keep_within(self, fence: KeptFence) -> None:
        self.kept_fence = fence

    def release(self) -> None:
        self.flown.append(None)

    def regain(self) -> None:
        self.takeover = None


AFTER: dict[Goal, dict[str, object]] = {
    Goal.ARMED: {"is_armed": True},
    Goal.AIRBORNE: {"is_landed": False, "mode": Mode.LOITER},
    Goal.OFFBOARD: {"mode": Mode.OFFBOARD},
    Goal.HOLDING: {"mode": Mode.LOITER},
    Goal.LANDED: {"is_landed": True, "is_armed": False, "mode": Mode.LAND},
}
"""What has changed in the state when a goal is reached."""


def _sum(a: Ned, b: Ned) -> Ned:
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


def _towards(start: Ned, goal: Ned, reach_m: float) -> Ned:
    gap_m = math.dist(start, goal)
    if gap_m <= reach_m:
        return goal
    share = reach_m / gap_m
    return _sum(start, tuple(share * (g - s) for s, g in zip(start, goal, strict=True)))  # type: ignore[arg-type]
