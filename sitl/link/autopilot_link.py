"""The autopilot's end of one link: its sequence numbers, its streams, its pending messages."""

from __future__ import annotations

from companion.geometry import GlobalOrigin
from companion.mavlink.framing import MavlinkCodec, Message, dialect
from sitl.link.events import EventService
from sitl.link.files import FileServer
from sitl.link.messages import MESSAGE_CLASSES, MESSAGES, compose, message_name
from sitl.link.routing import LinkName
from sitl.link.streams import StreamReader, Streams
from sitl.link.time_offset import TimeOffset
from sitl.link.vehicle import SimulatedVehicle

AUTOPILOT = 1  # MAV_COMP_ID_AUTOPILOT1
ORIGIN_S = 1.0  # how often PX4 checks whether the origin has changed
Outgoing = list[tuple[LinkName, bytes]]


class AutopilotLink:
    """One link of the autopilot.

    Args:
        name: the name of the link.
        system: system id.
        vehicle: the owner keeps `vehicle.state` current.
        events: shared by all links.
        out: receives the frames, in order.
        reader: the only reader of the streams, if there is just one.

    Attributes:
        files: what the link offers by FTP.
        streams: the schedule.
        next_step: answers to send with the next step.
        listing: names of parameters that are still to be listed.
        time_offset: the offset of the clock at the other end.
    """

    def __init__(
        self,
        name: LinkName,
        system: int,
        vehicle: SimulatedVehicle,
        events: EventService,
        out: Outgoing,
        reader: StreamReader | None,
    ) -> None:
        self.name = name
        self.files = FileServer(events.files)
        self._events = events
        self.vehicle = vehicle
        self._out = out
        self.streams = Streams(name, vehicle.state.time_s, reader)
        self.next_step: list[Message] = []
        self.listing: list[str] = []
        self.time_offset = TimeOffset()
        self._codec = MavlinkCodec(system, AUTOPILOT)
        self._told_origin: GlobalOrigin | None = None
        self._origin_due_s = vehicle.state.time_s

    def tell_origin(self) -> None:
        """Packs GPS_GLOBAL_ORIGIN if it has changed; like PX4, it checks once a second."""
        now_s, origin = self.vehicle.state.time_s, self.vehicle.origin
        if now_s < self._origin_due_s:
            return
        self._origin_due_s += ORIGIN_S
        if origin != self._told_origin:
            self._told_origin = origin
            self.stream("GPS_GLOBAL_ORIGIN")

    def send(self, message: Message) -> None:
        """Packs a message for this link."""
        self._out.append((self.name, self._codec.pack(message)))

    def stream(self, name: str) -> None:
        """Packs a telemetry message for this link."""
        frame = self._codec.frame(MESSAGE_CLASSES[name], MESSAGES[name](self.vehicle))
        self._out.append((self.name, frame))

    def send_if(self, message: Message | None) -> None:
        """Packs a message, if there is one."""
        if message is not None:
            self.send(message)

    def request_message(self, message_id: int) -> bool:
        """Sends a message once; False if the id is unknown."""
        if message_id == dialect.MAVLINK_MSG_ID_COMPONENT_METADATA:
            self.next_step.append(self._events.metadata_message(self.vehicle.boot_ms))
            return True
        if (name := message_name(message_id)) is None:
            return False
        self.next_step.append(compose(name, self.vehicle))
        return True

    def ask_for_checks(self) -> None:
        """Reports the arming checks in the next step."""
        self._events.is_asked = True

    def interval_us(self, message_id: int) -> int:
        """Interval of a stream; 0 for what is not streamed."""
        name = message_name(message_id)
        return self.streams.interval_us(name) if name else 0

    def set_interval(self, message_id: int, interval_us: float) -> bool:
        """Changes a stream's interval; False if it is not streamed."""
        name = message_name(message_id)
        now_s = self.vehicle.state.time_s
        return name is not None and self.streams.set_interval(name, interval_us, now_s)
