"""The events of a scenario: their triggers, their effects, and which are due.

1. An event has one trigger: a time, the n-th visit to a circle, or the n-th command of a kind to a
   component on board.
2. It may have a delay after the trigger, and has one or more effects.
3. It happens once, in the step in which it is due. Events of one step happen in the order of the
   file.

`EFFECTS` maps each key of the scenario to its effect on the world.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Protocol

from companion.geometry import GlobalOrigin, Ned, ned_from_enu
from companion.mavlink.framing import dialect
from sitl.flight.battery import BatteryChange
from sitl.results import MavResult
from sitl.world.battery_schema import battery_change, pad_change
from sitl.world.camera import CameraChange
from sitl.world.device_schema import camera_change, gimbal_change, gripper_change
from sitl.world.faults import Answer, Direction, LinkQuality, Port, Reboot
from sitl.world.gimbal import GimbalChange
from sitl.world.gripper import GripperChange
from sitl.world.marker_schema import marker_change
from sitl.world.markers import MarkerChange
from sitl.world.pads import PadChange
from sitl.world.payload import PayloadAnswer
from sitl.world.visits import Circle, VisitCounter

TIME_ROUNDING_S = 1e-9


class EffectReceiver(Protocol):
    """The world, as far as events can change it."""

    def show_target(self, is_seen: bool) -> None:
        """Switches the detector's sighting of the target on or off."""

    def set_payload_answer(self, answer: PayloadAnswer) -> None:
        """Replaces the payload's answer everywhere."""

    def set_wind(self, wind: Ned) -> None:
        """Sets the mean air velocity, NED."""

    def place_obstacle(self, name: str, is_present: bool) -> None:
        """Adds or removes an obstacle."""

    def change_battery(self, change: BatteryChange) -> None:
        """Changes the battery."""

    def change_pad(self, change: PadChange) -> None:
        """Changes a pad."""

    def set_gps(self, is_lost: bool | None, noise_m: float | None) -> None:
        """Sets the quality of GPS; None leaves a property as it is."""

    def refuse_arming(self, reason: str | None) -> None:
        """Refuses arming for a reason; None allows it."""

    def send_operator_command(self, command: str) -> None:
        """Lets the operator send a MAV_CMD to the companion."""

    def set_link_quality(
        self, port: Port | None, direction: Direction | None, quality: LinkQuality
    ) -> None:
        """Sets how a link treats datagrams; None as port or direction means both."""

    def jump_estimate(self, by: Ned) -> None:
        """Shifts the estimated position by a vector, NED."""

    def lay_origin(self, origin: GlobalOrigin) -> None:
        """Moves the origin of the autopilot's local frame."""

    def reboot(self, reboot: Reboot) -> None:
        """Restarts the autopilot."""

    def set_answer(self, command: int, answer: Answer | None) -> None:
        """Sets how the autopilot answers a MAV_CMD; None restores PX4's answer."""

    def change_marker(self, change: MarkerChange) -> None:
        """Changes a landing marker."""

    def change_camera(self, change: CameraChange) -> None:
        """Changes a camera."""

    def change_gimbal(self, change: GimbalChange) -> None:
        """Changes the gimbal."""

    def change_gripper(self, change: GripperChange) -> None:
        """Changes the gripper."""

    def report(self, values: Mapping[str, object]) -> None:
        """Lets a program on board report values to the companion."""


EFFECTS: Mapping[str, Callable[[EffectReceiver, Any], None]] = {
    "target": lambda world, value: world.show_target(value == "seen"),
    "payload": lambda world, value: world.set_payload_answer(
        PayloadAnswer(
            MavResult[value.result], value.after_s, value.silent, value.progress, value.lost
        )
    ),
    "wind": lambda world, value: world.set_wind(ned_from_enu(value.east_mps, value.north_mps, 0.0)),
    "obstacle": lambda world, value: world.place_obstacle(value.name, value.present),
    "battery": lambda world, value: world.change_battery(battery_change(value)),
    "pad": lambda world, value: world.change_pad(pad_change(value)),
    "gps": lambda world, value: world.set_gps(value.lost, value.noise_m),
    "arming": lambda world, value: world.refuse_arming(value.refused),
    "operator": lambda world, value: world.send_operator_command(value),
    "link": lambda world, value: world.set_link_quality(
        value.port,
        value.direction,
        LinkQuality(value.loss, value.doubled, value.delay_s, value.jitter_s),
    ),
    "estimate": lambda world, value: world.jump_estimate(
        ned_from_enu(value.east_m, value.north_m, value.up_m)
    ),
    "origin": lambda world, value: world.lay_origin(
        GlobalOrigin(value.latitude_deg, value.longitude_deg, value.altitude_m)
    ),
    "reboot": lambda world, value: world.reboot(Reboot(value.silent_s, value.recovers)),
    "answer": lambda world, value: world.set_answer(getattr(dialect, value.command), value.answer),
    "marker": lambda world, value: world.change_marker(marker_change(value)),
    "camera": lambda world, value: world.change_camera(camera_change(value)),
    "gimbal": lambda world, value: world.change_gimbal(gimbal_change(value)),
    "gripper": lambda world, value: world.change_gripper(gripper_change(value)),
    "report": lambda world, value: world.report(value),
}
"""Key of the scenario -> what it does with the key's value."""


@dataclass(frozen=True, slots=True)
class TimeTrigger:
    """Simulated seconds since the start."""

    at_s: float


@dataclass(frozen=True, slots=True)
class VisitTrigger:
    """The n-th visit to a circle, from 1."""

    circle: Circle
    visit: int


@dataclass(frozen=True, slots=True)
class CommandTrigger:
    """The n-th command of a kind, from 1; a repetition is the same command.

    Attributes:
        component: the addressee; None means any component on board.
    """

    command: int
    nth: int
    component: int | None


@dataclass(frozen=True, slots=True)
class ScenarioEvent:
    """A trigger and its effects.

    Attributes:
        effects: keys of `EFFECTS` with their values, as in the scenario.
        text: the effects in plain words.
        after_s: delay after the trigger.
    """

    trigger: TimeTrigger | VisitTrigger | CommandTrigger
    effects: tuple[tuple[str, Any], ...]
    text: str
    after_s: float = 0.0


@dataclass(slots=True)
class _PendingEvent:
    event: ScenarioEvent
    visits: VisitCounter | None
    commands: int = 0
    due_s: float | None = None


class EventSchedule:
    """The events that have not happened yet.

    Args:
        events: in the order of the file.
        start: first position of the vehicle.
    """

    def __init__(self, events: tuple[ScenarioEvent, ...], start: Ned) -> None:
        self._pending: list[_PendingEvent] = []
        for event in events:
            trigger = event.trigger
            pending = _PendingEvent(event, None)
            if isinstance(trigger, VisitTrigger):
                pending.visits = VisitCounter(trigger.circle, start)
            elif isinstance(trigger, TimeTrigger):
                pending.due_s = trigger.at_s + event.after_s
            self._pending.append(pending)

    def note_command(self, command: int, component: int, now_s: float) -> None:
        """Counts a command for a component on board; component 0 means all."""
        for pending in self._pending:
            trigger = pending.event.trigger
            if pending.due_s is None and isinstance(trigger, CommandTrigger):
                is_meant = component == 0 or trigger.component in (None, component)
                pending.commands += is_meant and command == trigger.command
                if pending.commands == trigger.nth:
                    pending.due_s = now_s + pending.event.after_s

    def step(self, position: Ned, now_s: float) -> list[ScenarioEvent]:
        """The events that happen now."""
        if not self._pending:
            return []
        due = []
        for pending in self._pending:
            trigger = pending.event.trigger
            if pending.visits and pending.due_s is None and isinstance(trigger, VisitTrigger):
                pending.visits.update(position)
                if pending.visits.count == trigger.visit:
                    pending.due_s = now_s + pending.event.after_s
            if pending.due_s is not None and now_s >= pending.due_s - TIME_ROUNDING_S:
                due.append(pending)
        for pending in due:
            self._pending.remove(pending)
        return [pending.event for pending in due]
