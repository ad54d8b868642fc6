"""The autopilot as a MAVLink component: messages in, frames out; component 1 of its system.

`SERVICES` maps each message to the service that handles it; others are not for the autopilot. In
each step the component also sends what is due on each link: streams, HEARTBEAT at once when armed
state, mode or system status change, the second answer to DO_SET_MODE, and notices as STATUSTEXT and
EVENT.

Sources: the services of https://mavlink.io/en/services/; observed answers of PX4.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from typing import ClassVar
from zlib import crc32

from companion.mavlink.framing import Message, dialect, source
from companion.mavlink.px4_modes import mode_name
from companion.mavlink.statustext import chunks
from sitl.autopilot.modes import FLIGHT_MODES
from sitl.autopilot.situation import heading
from sitl.link import parameters, setpoints
from sitl.link.autopilot_link import AUTOPILOT, AutopilotLink, Outgoing
from sitl.link.commands import ACCEPTED_FIRST, execute, request_from
from sitl.link.events import EventService
from sitl.link.messages import compose
from sitl.link.mission_items import MissionType, WireItem, areas_from, item_from, safe_points_from
from sitl.link.mission_progress import MissionProgressReporter
from sitl.link.mission_service import MissionService
from sitl.link.routing import MAV_TYPE_GCS, LinkName, Router, is_for
from sitl.link.streams import StreamReader
from sitl.link.telemetry.system import status
from sitl.link.time_offset import TimeOffset
from sitl.link.vehicle import SimulatedVehicle
from sitl.results import MavResult
from sitl.world.faults import ANSWERS, Answer

CONTINUAL = frozenset(
    {
        "HEARTBEAT",
        "SET_POSITION_TARGET_LOCAL_NED",
        "SET_POSITION_TARGET_GLOBAL_INT",
        "TIMESYNC",
    }
)
"""Messages that cause no answer beyond what is sent anyway."""
LISTED_PER_STEP = 5  # of a parameter list: 140 parameters take 0.1 s


class AutopilotComponent:
    """Component 1/1 on all its links.

    Args:
        system: system id.
        vehicle: the owner keeps `vehicle.state` current.
        links: those with somebody at the other end.
        router: knows where a ground station listens.
        answers: how a MAV_CMD is answered, where this differs from PX4; read with every command.
        refusals: reasons for which the scenario refuses arming.
        reader: the only reader of the streams, if there is just one.

    Attributes:
        is_asked: something has to be sent before the autopilot's next step.
        due_s: when the next stream is due.
    """

    def __init__(
        self,
        system: int,
        vehicle: SimulatedVehicle,
        links: frozenset[LinkName],
        router: Router,
        answers: Mapping[int, Answer],
        refusals: Iterable[str],
        reader: StreamReader | None = None,
    ) -> None:
        self.address = (system, AUTOPILOT)
        self._vehicle = vehicle
        self._router = router
        self._answers = answers
        self._late: list[tuple[float, AutopilotLink, Message]] = []
        self._out: Outgoing = []
        self._events = EventService(refusals)
        self._links = {
            name: AutopilotLink(name, system, vehicle, self._events, self._out, reader)
            for name in LinkName
            if name in links
        }
        self.is_asked = False
        self.attend()
        self._reported_status = status(vehicle.autopilot)
        self._text_count = 0
        self._progress = MissionProgressReporter()
        self._missions: MissionService = MissionService(
            self._accept_plan, lambda: vehicle.autopilot.mission.current
        )

    def time_offset(self, name: LinkName) -> TimeOffset:
        """The estimated offset of the clock at the other end of a link."""
        return self._links[name].time_offset

    def receive(self, name: LinkName, message: Message) -> None:
        """Handles a message that arrived on a link."""
        self.is_asked |= message.get_type() not in CONTINUAL
        service = self.SERVICES.get(message.get_type())
        link = self._links.get(name)
        if service and link and is_for(self.address, message):
            service(self, link, message)

    def attend(self) -> None:
        """Adapts the streams to their reader and to the requested intervals."""
        for link in self._links.values():
            link.streams.attend(self._vehicle.state.time_s)
        self._find_next_due()

    def _find_next_due(self) -> None:
        self.due_s = min([link.streams.due_s for link in self._links.values()], default=math.inf)

    def follow(self) -> None:
        """Notes that the autopilot has advanced; the next step sends what has changed."""
        autopilot = self._vehicle.autopilot
        if autopilot.status_texts or status(autopilot) != self._reported_status:
            self.is_asked = True

    def step(self, until_s: float) -> Outgoing:
        """The frames to send now; all that is sent before `until_s` arrives together."""
        self.is_asked = False
        vehicle, now_s = self._vehicle, self._vehicle.state.time_s
        now = status(vehicle.autopilot)
        for origin, message in self._missions.due(now_s):
            self._links[origin].send(message)
        common = [*self._progress.due(vehicle), *self._due_events(now_s)]
        if now != self._reported_status:
            common.append(compose("HEARTBEAT", vehicle))
            self._reported_status = now
        for link in self._links.values():
            if link.next_step or common:
                for message in (*link.next_step, *common):
                    link.send(message)
                link.next_step.clear()
            if link.listing:
                self._list_parameters(link)
                self.is_asked |= bool(link.listing)
            link.tell_origin()
        for link, name in self.due(now_s, until_s):
            link.stream(name)
        if self._late:
            for due_s, link, message in self._late:
                if due_s <= now_s:
                    link.send(message)
            self._late = [late for late in self._late if late[0] > now_s]
        self._send_status_texts()
        return self.flush()

    def due(self, now_s: float, until_s: float) -> list[tuple[AutopilotLink, str]]:
        """The streams that are due now, by name, each with its link."""
        if now_s < self.due_s:
            return []
        due = [
            (link, name)
            for link in self._links.values()
            for name in link.streams.due(now_s, until_s)
        ]
        self._find_next_due()
        return due

    def _list_parameters(self, link: AutopilotLink) -> None:
        known = self._vehicle.autopilot.parameters
        for name in link.listing[:LISTED_PER_STEP]:
            link.send(parameters.value_of(name, known))
        del link.listing[:LISTED_PER_STEP]

    def flush(self) -> Outgoing:
        """Takes the frames packed since the last call."""
        out = self._out.copy()
        self._out.clear()
        return out

    def _due_events(self, now_s: float) -> list[Message]:
        """The events of this step; now and then, the number of the newest."""
        autopilot, events = self._vehicle.autopilot, self._events
        if autopilot.is_armed and not autopilot.status_texts:
            return events.newest(now_s)  # nearly always the case
        boot_ms = self._vehicle.boot_ms
        common = [] if autopilot.is_armed else events.report(autopilot.arming_denials, boot_ms)
        for text in autopilot.status_texts:
            if text.event is not None:
                common.append(events.told(text.severity, text.event, boot_ms))
        return common + events.newest(now_s)

    def _send_status_texts(self) -> None:
        status_texts = self._vehicle.autopilot.status_texts
        if not status_texts:
            return
        for text in status_texts:
            self._text_count += 1
            for message in chunks(text.severity, text.text, self._text_count):
                for link in self._links.values():
                    if self._router.has_ground_station(link.name):
                        link.send(message)
        status_texts.clear()

    def _command(self, link: AutopilotLink, message: Message) -> None:
        request = request_from(message)
        system, component = source(message)

        def answer(value: MavResult) -> Message:
            return dialect.MAVLink_command_ack_message(
                request.command, value, 0, 0, system, component
            )

        if request.command in self._answers:
            answering = ANSWERS[self._answers[request.command]]
            if answering.has_effect:
                execute(link, request)
            now_s = self._vehicle.state.time_s
            self._late += [(now_s + s, link, answer(each)) for s, each in answering.results]
            return
        result = execute(link, request)
        if request.command in ACCEPTED_FIRST:
            link.send(answer(MavResult.ACCEPTED))
            link.next_step.append(answer(result))
        else:
            link.send(answer(result))

    def _set_mode(self, link: AutopilotLink, message: Message) -> None:
        """SET_MODE, as QGroundControl sends it; the HEARTBEAT is the answer."""
        mode = mode_name(message.custom_mode)
        if mode in FLIGHT_MODES:
            self._vehicle.autopilot.set_mode(mode)

    def _setpoint(self, link: AutopilotLink, message: Message) -> None:
        vehicle = self._vehicle
        setpoint = setpoints.setpoint_from(
            message, heading(vehicle.state), vehicle.origin, vehicle.autopilot.home[2]
        )
        if setpoint is not None:
            self._vehicle.autopilot.accept_setpoint(setpoint)

    def _ping(self, link: AutopilotLink, message: Message) -> None:
        if message.target_system == 0 and message.target_component == 0:
            link.send(
                dialect.MAVLink_ping_message(message.time_usec, message.seq, *source(message))
            )

    def _timesync(self, link: AutopilotLink, message: Message) -> None:
        if message.tc1 == 0:
            link.send(dialect.MAVLink_timesync_message(self._vehicle.boot_us * 1000, message.ts1))
        elif message.tc1 > 0:
            link.time_offset.take(self._vehicle.boot_us, message.tc1, message.ts1)

    def _ftp(self, link: AutopilotLink, message: Message) -> None:
        for answer in link.files.answers(self._vehicle.state.time_s, message):
            link.send(answer)

    def _request_event(self, link: AutopilotLink, message: Message) -> None:
        for answer in self._events.again(message, source(message)):
            link.send(answer)

    def _heartbeat(self, link: AutopilotLink, message: Message) -> None:
        if message.type == MAV_TYPE_GCS:
            self._vehicle.autopilot.note_ground_station()

    def _param_list(self, link: AutopilotLink, message: Message) -> None:
        link.listing = list(parameters.LISTED)

    def _param_read(self, link: AutopilotLink, message: Message) -> None:
        link.send_if(parameters.read(message, self._vehicle.autopilot.parameters))

    def _param_set(self, link: AutopilotLink, message: Message) -> None:
        link.send_if(parameters.write(message, self._vehicle.autopilot.parameters))

    def _mission(self, link: AutopilotLink, message: Message) -> None:
        for answer in self._missions.receive(link.name, message, self._vehicle.state.time_s):
            link.send(answer)

    def _mission_set_current(self, link: AutopilotLink, message: Message) -> None:
        vehicle = self._vehicle
        if not self._missions.is_busy and vehicle.autopilot.mission.set_current(message.seq):
            link.send(compose("MISSION_CURRENT", vehicle))

    def _accept_plan(
        self, kind: MissionType, items: tuple[WireItem, ...], current: int | None
    ) -> None:
        autopilot, origin = self._vehicle.autopilot, self._vehicle.origin
        self._vehicle.plan_numbers[kind] = crc32(repr(items).encode()) if items else 0
        if kind is MissionType.MISSION:
            flown = [item_from(item, origin) for item in items]
            autopilot.mission.load(flown, current, self._vehicle.state.time_s)
        elif kind is MissionType.FENCE:
            autopilot.load_fence(areas_from(items, origin))
        else:
            autopilot.safe_points = safe_points_from(items, origin)

    SERVICES: ClassVar[dict[str, Callable[[AutopilotComponent, AutopilotLink, Message], None]]] = {
        "HEARTBEAT": _heartbeat,
        "COMMAND_LONG": _command,
        "COMMAND_INT": _command,
        "SET_MODE": _set_mode,
        "SET_POSITION_TARGET_LOCAL_NED": _setpoint,
        "SET_POSITION_TARGET_GLOBAL_INT": _setpoint,
        "FILE_TRANSFER_PROTOCOL": _ftp,
        "REQUEST_EVENT": _request_event,
        "PING": _ping,
        "TIMESYNC": _timesync,
        "PARAM_REQUEST_LIST": _param_list,
        "PARAM_REQUEST_READ": _param_read,
        "PARAM_SET": _param_set,
        "MISSION_SET_CURRENT": _mission_set_current,
        **dict.fromkeys(MissionService.HANDLERS, _mission),
    }
    """Message -> the service that handles it."""
