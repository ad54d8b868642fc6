"""How does the autopilot speak MAVLink? Messages in, frames out; component 1 of its system.

`SERVICES` maps a message to what answers it; what is not listed is not for the autopilot. Per step
the component also sends what is due on each link: streams, HEARTBEAT at once when armed, mode or
system status changed, the second answer to DO_SET_MODE, and notices as STATUSTEXT.

Sources: the services of https://mavlink.io/en/services/; PX4's answers as they were seen.
Left out so far: missions (an empty list is served), MAVLink FTP, events.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import ClassVar

from companion.mavlink.framing import Endpoint, Message, dialect, source
from companion.mavlink.parameters import decode, encode
from companion.mavlink.px4_modes import mode_name
from sitl.autopilot.modes import FLIGHT_MODES, heading
from sitl.autopilot.parameters import PARAMETERS, index_of, name_at
from sitl.link import setpoints
from sitl.link.commands import ACCEPTED_FIRST, execute, request_from
from sitl.link.messages import MESSAGES, Vehicle, message_name, status
from sitl.link.routing import LinkName, Router, is_for
from sitl.link.streams import Streams
from sitl.results import Result

AUTOPILOT = 1  # MAV_COMP_ID_AUTOPILOT1
Outgoing = list[tuple[LinkName, bytes]]


class Link:
    """The autopilot's end of one link: its sequence numbers and its streams."""

    def __init__(self, name: LinkName, system: int, vehicle: Vehicle) -> None:
        self.name = name
        self.vehicle = vehicle
        self.frames: list[bytes] = []
        self.streams = Streams(name, vehicle.state.time_s)
        self.later: list[Message] = []
        self._endpoint = Endpoint(system, AUTOPILOT)

    def send(self, message: Message) -> None:
        """Pack a message for this link."""
        self.frames.append(self._endpoint.pack(message))

    def request_message(self, message_id: int) -> bool:
        """Send a message once; False if there is none with that id."""
        if (name := message_name(message_id)) is None:
            return False
        self.later.append(MESSAGES[name](self.vehicle))
        return True

    def set_interval(self, message_id: int, interval_us: float) -> bool:
        """Change a stream's interval; False if it is not streamed."""
        name = message_name(message_id)
        now_s = self.vehicle.state.time_s
        return name is not None and self.streams.set_interval(name, interval_us, now_s)


class AutopilotComponent:
    """Component 1/1 on all its links.

    Args:
        system: system id.
        vehicle: whom it speaks for; the owner keeps `vehicle.state` current.
        links: those with somebody at the other end.
        router: knows where a ground station listens.
    """

    def __init__(
        self, system: int, vehicle: Vehicle, links: frozenset[LinkName], router: Router
    ) -> None:
        self.address = (system, AUTOPILOT)
        self._vehicle = vehicle
        self._router = router
        self._links = {name: Link(name, system, vehicle) for name in LinkName if name in links}
        self._told = status(vehicle.autopilot)

    def receive(self, name: LinkName, message: Message) -> None:
        """Handle a message that came in on a link."""
        service = self.SERVICES.get(message.get_type())
        link = self._links.get(name)
        if service and link and is_for(self.address, message):
            service(self, link, message)

    def step(self) -> Outgoing:
        """What leaves now."""
        vehicle = self._vehicle
        now = status(vehicle.autopilot)
        for link in self._links.values():
            for message in link.later:
                link.send(message)
            link.later.clear()
            if now != self._told:
                link.send(MESSAGES["HEARTBEAT"](vehicle))
            for name in link.streams.due(vehicle.state.time_s):
                link.send(MESSAGES[name](vehicle))
        self._told = now
        self._send_notices()
        return self.flush()

    def flush(self) -> Outgoing:
        """Take what has been packed since the last time."""
        out = [(link.name, frame) for link in self._links.values() for frame in link.frames]
        for link in self._links.values():
            link.frames.clear()
        return out

    def _send_notices(self) -> None:
        notices = self._vehicle.autopilot.notices
        for notice in notices:
            message = dialect.MAVLink_statustext_message(notice.severity, notice.text.encode())
            for link in self._links.values():
                if self._router.has_ground_station(link.name):
                    link.send(message)
        notices.clear()

    def _command(self, link: Link, message: Message) -> None:
        request = request_from(message)
        result = execute(link, request)
        system, component = source(message)

        def answer(value: Result) -> Message:
            return dialect.MAVLink_command_ack_message(
                request.command, value, 0, 0, system, component
            )

        if request.command in ACCEPTED_FIRST:
            link.send(answer(Result.ACCEPTED))
            link.later.append(answer(result))
        else:
            link.send(answer(result))

    def _set_mode(self, link: Link, message: Message) -> None:
        """SET_MODE, QGroundControl's way; the HEARTBEAT is the answer."""
        mode = mode_name(message.custom_mode)
        if mode in FLIGHT_MODES:
            self._vehicle.autopilot.set_mode(mode)

    def _setpoint(self, link: Link, message: Message) -> None:
        target = setpoints.target_from(message, heading(self._vehicle.state))
        if target is not None:
            self._vehicle.autopilot.accept_setpoint(target)

    def _ping(self, link: Link, message: Message) -> None:
        if message.target_system == 0 and message.target_component == 0:
            link.send(
                dialect.MAVLink_ping_message(message.time_usec, message.seq, *source(message))
            )

    def _timesync(self, link: Link, message: Message) -> None:
        if message.tc1 == 0:
            link.send(dialect.MAVLink_timesync_message(self._vehicle.boot_us * 1000, message.ts1))

    def _param_list(self, link: Link, message: Message) -> None:
        for name in PARAMETERS:
            self._send_parameter(link, name)

    def _param_read(self, link: Link, message: Message) -> None:
        name = name_at(message.param_index) if message.param_index >= 0 else message.param_id
        if name in PARAMETERS:
            self._send_parameter(link, name)

    def _param_set(self, link: Link, message: Message) -> None:
        """Unknown names are met with silence, another type leaves the value as it is (PX4)."""
        name = message.param_id
        if name not in PARAMETERS:
            return
        if message.param_type == PARAMETERS[name][0]:
            value = decode(message.param_value, message.param_type)
            self._vehicle.autopilot.parameters.set(name, value)
        self._send_parameter(link, name)

    def _send_parameter(self, link: Link, name: str) -> None:
        param_type, _ = PARAMETERS[name]
        value = encode(self._vehicle.autopilot.parameters[name], param_type)
        link.send(
            dialect.MAVLink_param_value_message(
                name.encode(), value, param_type, len(PARAMETERS), index_of(name)
            )
        )

    def _mission_list(self, link: Link, message: Message) -> None:
        link.send(dialect.MAVLink_mission_count_message(*source(message), 0, message.mission_type))

    SERVICES: ClassVar[dict[str, Callable[[AutopilotComponent, Link, Message], None]]] = {
        "COMMAND_LONG": _command,
        "COMMAND_INT": _command,
        "SET_MODE": _set_mode,
        "SET_POSITION_TARGET_LOCAL_NED": _setpoint,
        "PING": _ping,
        "TIMESYNC": _timesync,
        "PARAM_REQUEST_LIST": _param_list,
        "PARAM_REQUEST_READ": _param_read,
        "PARAM_SET": _param_set,
        "MISSION_REQUEST_LIST": _mission_list,
    }
    """Message -> what answers it."""
