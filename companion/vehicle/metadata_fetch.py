"""Fetches the metadata of an autopilot's events from that autopilot. No I/O.

1. The autopilot is asked where its general metadata is (COMPONENT_METADATA). That file names the
   file about events. Both are read over MAVLink FTP.
2. A failed attempt is repeated after PAUSE_S, up to ATTEMPTS in all.
3. Checksums are ignored. They exist for caches; and PX4 sends that of the unpacked file, though the
   packed file has another one.
4. It takes a second or two, only happens while the vehicle stands disarmed, and nothing waits for
   it. If the vehicle is armed sooner, the words stay unknown until it is disarmed again.
5. The second file is unpacked and read in one step (12 ms for PX4 v1.16).

Source: https://mavlink.io/en/services/component_information.html.
"""

from __future__ import annotations

import logging
import math

from companion.mavlink.event_metadata import (
    MOST_FILE_BYTES,
    EventMetadata,
    MetadataError,
    events_file,
    read_events,
)
from companion.mavlink.framing import Message, dialect
from companion.mavlink.ftp_reading import FileReading, ReadingState

COMPONENT_METADATA = dialect.MAVLINK_MSG_ID_COMPONENT_METADATA
ASK_S = 0.5
ASKED_TIMES = 10
PAUSE_S = 15.0
ATTEMPTS = 3
_ON_THE_VEHICLE = "mftp://"

log = logging.getLogger(__name__)


class MetadataFetch:
    """Fetches the metadata, until it succeeds or gives up.

    Attributes:
        metadata: of the events; None until it was read.
    """

    def __init__(self) -> None:
        self.metadata: EventMetadata | None = None
        self._attempts = self._asked = 0
        self._next_s = -math.inf
        self._is_general = True
        self._reading: FileReading | None = None
        self._sequence = 0

    @property
    def has_given_up(self) -> bool:
        """Whether the words will stay unknown."""
        return self.metadata is None and self._attempts >= ATTEMPTS

    def due(self, now_s: float, target: tuple[int, int]) -> list[Message]:
        """The messages to send now to (system, component); none once it has ended."""
        if self.metadata is not None or self.has_given_up:
            return []
        reading = self._reading
        if reading is None:
            return self._ask(now_s, target)
        payloads = reading.due(now_s)
        if reading.state is ReadingState.ENDED:
            self._take_file(now_s, reading)
        return [
            dialect.MAVLink_file_transfer_protocol_message(0, *target, list(payload))
            for payload in payloads
        ]

    def interrupt(self) -> None:
        """Stops because the vehicle is armed; the attempt starts anew when it is not."""
        if self._reading is not None:
            self._sequence = self._reading.sequence + 1
        self._reading, self._asked = None, 0

    def take(self, now_s: float, message: Message) -> None:
        """Takes a COMPONENT_METADATA or a FILE_TRANSFER_PROTOCOL of the autopilot."""
        if message.get_type() == "FILE_TRANSFER_PROTOCOL":
            if self._reading is not None:
                self._reading.take(bytes(message.payload))
        elif self._asked and self._reading is None:
            self._asked = 0
            self._open(now_s, message.uri, is_general=True)

    def _ask(self, now_s: float, target: tuple[int, int]) -> list[Message]:
        if now_s < self._next_s:
            return []
        if self._asked >= ASKED_TIMES:
            self._fail(now_s, "it does not say where")
            return []
        self._asked += 1
        self._next_s = now_s + ASK_S
        command, number = dialect.MAV_CMD_REQUEST_MESSAGE, float(COMPONENT_METADATA)
        rest = (0.0,) * 6
        return [dialect.MAVLink_command_long_message(*target, command, 0, number, *rest)]

    def _open(self, now_s: float, uri: str, is_general: bool) -> None:
        path = uri.removeprefix(_ON_THE_VEHICLE)
        if path == uri:
            self._fail(now_s, f"it is not on the vehicle: {uri[:100]}")
            return
        if path.startswith("[;comp="):  # only this autopilot would name it
            path = path.partition("]")[2]
        self._is_general = is_general
        self._reading = FileReading(path, MOST_FILE_BYTES, self._sequence)

    def _take_file(self, now_s: float, reading: FileReading) -> None:
        content, self._reading = reading.content, None
        self._sequence = reading.sequence + 1
        if content is None:
            self._fail(now_s, reading.why_not)
            return
        try:
            if self._is_general:
                self._open(now_s, events_file(content), is_general=False)
            else:
                self.metadata = read_events(content)
                log.debug("%d events of the autopilot are known", len(self.metadata.events))
        except MetadataError as error:
            self._fail(now_s, str(error))

    def _fail(self, now_s: float, why_not: str) -> None:
        self._attempts += 1
        self._asked, self._next_s = 0, now_s + PAUSE_S
        log.debug("metadata of the autopilot's events, attempt %d: %s", self._attempts, why_not)
        if self.has_given_up:
            log.info("the autopilot's events are told by number: no metadata: %s", why_not)
