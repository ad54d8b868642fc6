"""A vehicle without MAVLink and without physics: a point that goes where its setpoint says.

Fulfils `Vehicle` of companion/vehicle/ports. It does what its script says: goals are reached after
a delay or fail, commands are answered after a delay, in order. Time is an argument, as everywhere.
"""

from __future__ import annotations

import math

from fake_devices import (
    FakeCameras,
    FakeFence,
    FakeGimbals,
    FakeMarkers,
    FakePayloads,
    FakeRally,
)
from states import changed, flying, heard_at, standing

from companion.geofence import KeptFence
from companion.geometry import GlobalOrigin, Ned
from companion.outcomes import Outcome, Progress, Refusal
from companion.vehicle.ports.control import Takeover
from companion.vehicle.ports.frame import Anchoring, FrameLocation
from companion.vehicle.ports.goals import Goal
from companion.vehicle.ports.setpoints import Setpoint
from companion.vehicle.ports.state import Mode, VehicleState

CLOSING_MPS = 1.0
"""How much faster than its setpoint the point may be, to close a gap."""


def on_hold(now_s: float) -> VehicleState:
    """A vehicle in the air, on hold, of which all was heard just now."""
    return changed(flying((1.0, 2.0, -3.0), now_s), mode=Mode.LOITER)


class FakeControl:
    """Control that is ours at first; tests take it."""

    def __init__(self) -> None:
        self.takeover: Takeover | None = None
        self.is_doubted = False

    def regain(self) -> None:
        self.takeover = None


class FakeFrame:
    """The frame of a vehicle whose positions are true.

    Attributes:
        doubt: why its position is not certain; nothing at first.
        location: where its frames lie on the earth; not known at first.
        anchoring: what decides where home lies.
        is_settling: it is measured where the vehicle stands.
    """

    def __init__(self, vehicle: FakeVehicle) -> None:
        self.doubt: Refusal | None = None
        self.origin: GlobalOrigin | None = None
        self.location: FrameLocation | None = None
        self.anchoring, self.is_settling = Anchoring.BY_VEHICLE, False
        self._vehicle = vehicle

    def gap_m(self, place: Ned, accuracy_m: float) -> float | None:
        state = self._vehicle.state
        return None if state is None else math.dist(state.motion.position[:2], place[:2])

    def stand_at(self, place: Ned) -> None:
        """Its frame is true."""


class FakeParameters(dict[str, float]):
    """The autopilot's parameters."""

    def read(self, name: str) -> float | None:
        return self.get(name)


class FakeSetpoints:
    """Setpoints that no gate refuses.

    Attributes:
        flown: every setpoint that was given; None when the vehicle was released.
    """

    def __init__(self) -> None:
        self.flown: list[Setpoint | None] = []
        self.refusal: Refusal | None = None
        self.kept_fence: KeptFence | None = None

    def fly(
        self, setpoint: Setpoint, *, is_for_task: bool = False, is_landing: bool = False
    ) -> None:
        self.flown.append(setpoint)

    def keep_within(self, fence: KeptFence) -> None:
        self.kept_fence = fence


class FakeGoals:
    """Goals that are reached, or fail, after a delay.

    Attributes:
        script: goal -> after how many seconds it comes to which outcome; at once to DONE if absent.
        pursued: the goals that were worked for, in order.
        takeoff_up_m: to where it takes off, unless it is told another altitude.
    """

    def __init__(self, vehicle: FakeVehicle) -> None:
        self.has_restarted = False
        self.script: dict[Goal, tuple[float, Outcome]] = {}
        self.pursued: list[Goal] = []
        self.takeoff_up_m = 2.0
        self._vehicle = vehicle
        self._since_s = 0.0

    def pursue(self, goal: Goal, takeoff_up_m: float | None = None) -> Outcome:
        vehicle = self._vehicle
        if not self.pursued or self.pursued[-1] is not goal:
            self.pursued.append(goal)
            self._since_s = vehicle.now_s
        delay_s, outcome = self.script.get(goal, (0.0, Progress.DONE))
        if vehicle.now_s - self._since_s < delay_s:
            return Progress.RUNNING
        if outcome is Progress.DONE:
            vehicle.change(**AFTER[goal])
            if goal is Goal.AIRBORNE and vehicle.state is not None:
                north, east, _ = vehicle.state.motion.position
                vehicle.change(position=(north, east, -(takeoff_up_m or self.takeoff_up_m)))
        return outcome


class FakeVehicle:
    """Stands on the ground at first, disarmed.

    Attributes:
        now_s: time of the last step.
        drift: where the point settles relative to its setpoint.
        is_stuck: it moves no longer.
        is_turning: its heading is that of its setpoint.
        pursued: the goals that were worked for, in order.
        flown: every setpoint that it was given; None when it was released.
        parameters: the autopilot's parameters; strong failsafes at first.
    """

    def __init__(self, position: Ned = (0.0, 0.0, 0.0)) -> None:
        self.state: VehicleState | None = standing(position)
        self.now_s = 0.0
        self.drift: Ned = (0.0, 0.0, 0.0)
        self.is_stuck = False
        self.is_turning = True
        self.control = FakeControl()
        self.goals = FakeGoals(self)
        self.setpoints = FakeSetpoints()
        self.pursued, self.flown = self.goals.pursued, self.setpoints.flown
        self.frame = FakeFrame(self)
        self.payloads = FakePayloads()
        self.markers = FakeMarkers()
        self.fence = FakeFence()
        self.rally = FakeRally()
        self.cameras = FakeCameras()
        self.gimbals = FakeGimbals()
        self.parameters = FakeParameters(
            COM_OF_LOSS_T=1.0,
            COM_OBL_RC_ACT=5.0,
            COM_LOW_BAT_ACT=3.0,
            GF_ACTION=2.0,
            COM_RCL_EXCEPT=0.0,
            RTL_RETURN_ALT=30.0,
            GF_MAX_HOR_DIST=0.0,
            GF_MAX_VER_DIST=0.0,
            MIS_TAKEOFF_ALT=2.5,
        )

    @property
    def setpoint(self) -> Setpoint | None:
        return self.flown[-1] if self.flown else None

    def change(self, **fields: object) -> None:
        """Changes fields of the state, and of its values."""
        assert self.state is not None
        self.state = changed(self.state, **fields)

    def take_off(self, up_m: float) -> FakeVehicle:
        """In the air and in OFFBOARD, as when a task begins."""
        assert self.state is not None
        north, east, _ = self.state.motion.position
        self.change(
            position=(north, east, -up_m), mode=Mode.OFFBOARD, is_armed=True, is_landed=False
        )
        return self

    def step(self, now_s: float) -> None:
        """Time passes: the point moves towards its setpoint, and its position is heard."""
        dt_s, self.now_s = now_s - self.now_s, now_s
        self.payloads.step(now_s)
        self.cameras.step(now_s)
        if self.state is None:
            return
        position, velocity = self.state.motion.position, (0.0, 0.0, 0.0)
        yaw_rad = self.state.attitude.yaw_rad
        if (
            self.setpoint is not None
            and not self.is_stuck
            and self.state.heartbeat.mode is Mode.OFFBOARD
        ):
            velocity = self.setpoint.velocity
            reach_m = (math.hypot(*velocity) + CLOSING_MPS) * dt_s
            position = _towards(position, _sum(self.setpoint.position, self.drift), reach_m)
            yaw_rad = self.setpoint.yaw_rad if self.is_turning else yaw_rad
        self.state = heard_at(now_s, self.state)
        self.change(position=position, velocity=velocity, yaw_rad=yaw_rad)

    def release(self) -> None:
        self.flown.append(None)


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
