"""How does the autopilot speak MAVLink? Messages in, frames out; component 1 of its system.

`SERVICES` maps a message to what answers it; what is not listed is not for the autopilot. Per step
the component also sends what is due on each link: streams, HEARTBEAT at once when armed, mode or
system status changed, the second answer to DO_SET_MODE, and notices as STATUSTEXT.

Sources: the services of https://mavlink.io/en/services/; PX4's answers as they were seen.
Left out so far: MAVLink FTP, events.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import ClassVar

from companion.mavlink import ftp
from companion.mavlink.framing import MavlinkCodec, Message, dialect, source
from companion.mavlink.px4_modes import mode_name
from companion.mavlink.statustext import chunks
from sitl.autopilot.modes import FLIGHT_MODES
from sitl.autopilot.situation import heading
from sitl.link import parameters, setpoints
from sitl.link.commands import ACCEPTED_FIRST, execute, request_from
from sitl.link.messages import KINDS, MESSAGES, compose, message_name
from sitl.link.mission_items import Kind, WireItem, areas_from, item_from
from sitl.link.missions import Missions
from sitl.link.progress import Progress
from sitl.link.routing import MAV_TYPE_GCS, LinkName, Router, is_for
from sitl.link.streams import Streams
from sitl.link.telemetry.system import status
from sitl.link.vehicle import Vehicle
from sitl.results import Result

AUTOPILOT = 1  # MAV_COMP_ID_AUTOPILOT1
LISTED_PER_STEP = 5  # of a parameter list: 140 take 0.1 s
Outgoing = list[tuple[LinkName, bytes]]


class Link:
    """The autopilot's end of one link: its sequence numbers and its streams."""

    def __init__(self, name: LinkName, system: int, vehicle: Vehicle, out: Outgoing) -> None:
        self.name = name
        self.vehicle = vehicle
        self._out = out
        self.streams = Streams(name, vehicle.state.time_s)
        self.later: list[Message] = []
        self.listing: list[str] = []
        self._codec = MavlinkCodec(system, AUTOPILOT)

    def send(self, message: Message) -> None:
        """Pack a message for this link."""
        self._out.append((self.name, self._codec.pack(message)))

    def stream(self, name: str) -> None:
        """Pack a message of the telemetry for this link."""
        frame = self._codec.frame(KINDS[name], MESSAGES[name](self.vehicle))
        self._out.append((self.name, frame))

    def send_if(self, message: Message | None) -> None:
        """Pack a message, if there is one."""
        if message is not None:
            self.send(message)

    def request_message(self, message_id: int) -> bool:
        """Send a message once; False if there is none with that id."""
        if (name := message_name(message_id)) is None:
            return False
        self.later.append(compose(name, self.vehicle))
        return True

    def interval_us(self, message_id: int) -> int:
        """Interval of a stream, 0 for what is not sent by itself."""
        name = message_name(message_id)
        return self.streams.interval_us(name) if name else 0

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
        self._out: Outgoing = []
        self._links = {
            name: Link(name, system, vehicle, self._out) for name in LinkName if name in links
        }
        self._told = status(vehicle.autopilot)
        self._texts = 0
        self._progress = Progress()
        self._missions: Missions = Missions(
            self._take_plan, lambda: vehicle.autopilot.mission.current
        )

    def receive(self, name: LinkName, message: Message) -> None:
        """Handle a message that came in on a link."""
        service = self.SERVICES.get(message.get_type())
        link = self._links.get(name)
        if service and link and is_for(self.address, message):
            service(self, link, message)

    def step(self) -> Outgoing:
        """What leaves now."""
        vehicle, now_s = self._vehicle, self._vehicle.state.time_s
        now = status(vehicle.autopilot)
        for origin, message in self._missions.due(now_s):
            self._links[origin].send(message)
        common = self._progress.due(vehicle)
        if now != self._told:
            common.append(compose("HEARTBEAT", vehicle))
            self._told = now
        for link in self._links.values():
            for message in (*link.later, *common):
                link.send(message)
            link.later.clear()
            if link.listing:
                self._list_parameters(link)
            for name in link.streams.due(now_s):
                link.stream(name)
        self._send_notices()
        return self.flush()

    def _list_parameters(self, link: Link) -> None:
        known = self._vehicle.autopilot.parameters
        for name in link.listing[:LISTED_PER_STEP]:
            link.send(parameters.value_of(name, known))
        del link.listing[:LISTED_PER_STEP]

    def flush(self) -> Outgoing:
        """Take what has been packed since the last time."""
        out = self._out.copy()
        self._out.clear()
        return out

    def _send_notices(self) -> None:
        notices = self._vehicle.autopilot.notices
        if not notices:
            return
        for notice in notices:
            self._texts += 1
            for message in chunks(notice.severity, notice.text, self._texts):
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
        vehicle = self._vehicle
        target = setpoints.target_from(
            message, heading(vehicle.state), vehicle.origin, vehicle.autopilot.home[2]
        )
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

    def _ftp(self, link: Link, message: Message) -> None:
        link.send_if(ftp.refusal(message))

    def _heartbeat(self, link: Link, message: Message) -> None:
        if message.type == MAV_TYPE_GCS:
            self._vehicle.autopilot.hear_ground_station()

    def _param_list(self, link: Link, message: Message) -> None:
        link.listing = list(parameters.LISTED)

    def _param_read(self, link: Link, message: Message) -> None:
        link.send_if(parameters.read(message, self._vehicle.autopilot.parameters))

    def _param_set(self, link: Link, message: Message) -> None:
        link.send_if(parameters.write(message, self._vehicle.autopilot.parameters))

    def _mission(self, link: Link, message: Message) -> None:
        for answer in self._missions.receive(link.name, message, self._vehicle.state.time_s):
            link.send(answer)

    def _mission_set_current(self, link: Link, message: Message) -> None:
        vehicle = self._vehicle
        if not self._missions.is_busy and vehicle.autopilot.mission.set_current(message.seq):
            link.send(compose("MISSION_CURRENT", vehicle))

    def _take_plan(self, kind: Kind, items: tuple[WireItem, ...], current: int | None) -> bool:
        autopilot, origin = self._vehicle.autopilot, self._vehicle.origin
        if kind is Kind.MISSION:
            autopilot.load_mission([item_from(item, origin) for item in items], current)
        elif kind is Kind.FENCE:
            areas = areas_from(items, origin)
            if areas is None:
                return False
            autopilot.load_fence(areas)
        return True

    SERVICES: ClassVar[dict[str, Callable[[AutopilotComponent, Link, Message], None]]] = {
        "HEARTBEAT": _heartbeat,
        "COMMAND_LONG": _command,
        "COMMAND_INT": _command,
        "SET_MODE": _set_mode,
        "SET_POSITION_TARGET_LOCAL_NED": _setpoint,
        "SET_POSITION_TARGET_GLOBAL_INT": _setpoint,
        "FILE_TRANSFER_PROTOCOL": _ftp,
        "PING": _ping,
        "TIMESYNC": _timesync,
        "PARAM_REQUEST_LIST": _param_list,
        "PARAM_REQUEST_READ": _param_read,
        "PARAM_SET": _param_set,
        "MISSION_SET_CURRENT": _mission_set_current,
        **dict.fromkeys(Missions.HANDLERS, _mission),
    }
    """Message -> what answers it."""
