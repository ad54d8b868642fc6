"""A gripper as a MAVLink component; its sensor sends NAMED_VALUE_INT "load" twice a second."""

from __future__ import annotations

from companion.mavlink.framing import Message, dialect, source
from sitl.flight.physics import FlightState
from sitl.link.component_sender import COMMANDS, ComponentSender, PackedMessage
from sitl.link.routing import target
from sitl.world.gripper import Gripper

REPORT_S = 0.5
LOAD = b"load"
_GRIPPER = dialect.MAV_CMD_DO_GRIPPER


class GripperComponent:
    """The gripper as a component.

    Args:
        system: the system id of the vehicle.
        gripper: its actions.
    """

    def __init__(self, system: int, gripper: Gripper) -> None:
        self.address = (system, gripper.spec.component)
        self._gripper = gripper
        self._sender = ComponentSender(self.address)

    def receive(self, message: Message, state: FlightState) -> list[PackedMessage]:
        """Handles a command to the gripper."""
        if self._gripper.is_silent:
            return []
        is_ours = message.get_type() in COMMANDS and target(message) == self.address
        if not is_ours or message.command != _GRIPPER:
            return self._sender.refuse(message, self.address)
        acks = self._gripper.act(source(message), message.param2, state.time_s)
        return [self._sender.acknowledge(_GRIPPER, ack) for ack in acks]

    def step(self, state: FlightState) -> list[PackedMessage]:
        """HEARTBEAT, the reading, and the answer that is due."""
        sent = self._sender.heartbeat(state.time_s)
        if ack := self._gripper.step(state.position, state.time_s):
            sent.append(self._sender.acknowledge(_GRIPPER, ack))
        if self._sender.is_due(REPORT_S, state.time_s):
            report = dialect.MAVLink_named_value_int_message(
                round(state.time_s * 1e3), LOAD, int(self._gripper.has_load)
            )
            sent.append(self._sender.pack(report))
        return [] if self._gripper.is_silent else sent
