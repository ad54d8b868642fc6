"""The events of the autopilot, as PX4 sends them: EVENT on all links, and metadata with texts.

1. Each text with a template (sitl/autopilot/status_texts.py) is an event.
2. The report of the arming checks is a sequence of events. It is sent when it changes and on
   request.
3. The newest KEPT events are sent again on request. The number of the newest is sent every
   NEWEST_S.
4. The metadata is generated from the same tables. A word in an event (a cause, a reason) is an enum
   there.

Sources: https://mavlink.io/en/services/events.html, component_information.html.
"""

from __future__ import annotations

import json
import lzma
import math
import struct
import zlib
from collections import deque
from collections.abc import Callable, Iterable
from typing import Any, NamedTuple

from companion.mavlink.framing import Message, dialect
from companion.mavlink.ftp_frames import crc32
from companion.mavlink.px4_modes import MODES, custom_mode
from sitl.autopilot.arming import REASONS
from sitl.autopilot.failsafes import FailsafeCause
from sitl.autopilot.status_texts import FLOAT, TEMPLATES, Severity, ToldEvent

COMPONENT = 1
KEPT = 20
NEWEST_S = 3.0
LOOK_MS, REPORT_MS = 100, 1000
ALL_MODES = 2**32 - 1
UNKNOWN_WORD = 255
PROTOCOL = 8  # log level of what no user is shown
GENERAL, DETAILS = "etc/extras/component_general.json.xz", "etc/extras/all_events.json.xz"
_RESET, _UNAVAILABLE = 1, 0
PX4_NUMBERS = {
    "Geofence invalid, doesn't contain Home position": 10973461,
    "Geofence invalid, doesn't contain current vehicle position": 9432105,
}
"""Events with PX4's own number; the others have one of ours."""


class Kind(NamedTuple):
    """An event of the metadata; its arguments have types of libevents."""

    group: str
    type: str
    message: str
    arguments: tuple[str, ...]

    @property
    def number(self) -> int:
        """Its number within the component, 24 bits."""
        if self.message in PX4_NUMBERS:
            return PX4_NUMBERS[self.message]
        return zlib.crc32(f"{self.group} {self.type} {self.message}".encode()) & 0xFFFFFF


_FLAGS = "uint32_t"
_CODES = {"uint8_t": "B", _FLAGS: "I", "float": "f", "word_t": "B"}
ARMING_SUMMARY = Kind("arming_check", "summary", "Arming check summary", ("uint8_t", *[_FLAGS] * 4))
CHECK = Kind("arming_check", "", "{3}", (_FLAGS, "uint8_t", "word_t"))
HEALTH_SUMMARY = Kind("health", "summary", "Health summary", ("uint8_t", *[_FLAGS] * 3))
TOLD = {
    template: Kind(
        "default", "", template, tuple("float" if t == FLOAT else "word_t" for t in types)
    )
    for template, types in TEMPLATES.items()
}


class EventService:
    """The events of one autopilot since it was started.

    Args:
        refusals: reasons for which the scenario refuses arming.

    Attributes:
        files: the metadata, by path.
        is_asked: whether to report the arming checks even if they have not changed.
    """

    def __init__(self, refusals: Iterable[str]) -> None:
        self._words = list(dict.fromkeys((*REASONS, *FailsafeCause, *refusals)))
        details = _packed(self._metadata())
        general = {
            "version": 1,
            "metadataTypes": [{"type": 4, "uri": f"mftp://{DETAILS}", "fileCrc": crc32(details)}],
        }
        self.files = {GENERAL: _packed(general), DETAILS: details}
        self._sequence = 0xFFFF
        self._kept: deque[Message] = deque(maxlen=KEPT)
        self._next_s = -math.inf
        self._reported: tuple[str, ...] = ()
        self._look_ms, self._reported_ms = 0, -REPORT_MS
        self.is_asked = False

    def metadata_message(self, boot_ms: int) -> Message:
        """COMPONENT_METADATA: where the general file is."""
        crc, uri = crc32(self.files[GENERAL]), f"mftp://{GENERAL}".encode()
        return dialect.MAVLink_component_metadata_message(boot_ms, crc, uri)

    def told(self, severity: Severity, event: ToldEvent, boot_ms: int) -> Message:
        """An event with a text for people."""
        values = [self._word(a) if isinstance(a, str) else a for a in event.arguments]
        return self._event(TOLD[event.template], severity, boot_ms, *values)

    def report(self, denials: Callable[[], tuple[str, ...]], boot_ms: int) -> list[Message]:
        """The report of the arming checks, if it is requested or has changed.

        Args:
            denials: the reasons why arming would be denied now; compared now and then.
            boot_ms: time since the boot.
        """
        if not self.is_asked and boot_ms < self._look_ms:
            return []
        self._look_ms, reasons = boot_ms + LOOK_MS, denials()
        is_due = reasons != self._reported and boot_ms >= self._reported_ms + REPORT_MS
        if not is_due and not self.is_asked:
            return []
        self._reported, self._reported_ms, self.is_asked = reasons, boot_ms, False
        failed = int(bool(reasons))
        can_arm = 0 if reasons else ALL_MODES
        return [
            self._event(ARMING_SUMMARY, PROTOCOL, boot_ms, 0, failed, 0, can_arm, ALL_MODES),
            *(
                self._event(CHECK, Severity.CRITICAL, boot_ms, ALL_MODES, 0, self._word(reason))
                for reason in reasons
            ),
            self._event(HEALTH_SUMMARY, PROTOCOL, boot_ms, 0, 1, 0, 0),
        ]

    def newest(self, now_s: float) -> list[Message]:
        """CURRENT_EVENT_SEQUENCE, when it is due."""
        if now_s < self._next_s:
            return []
        self._next_s = now_s + NEWEST_S
        flags = 0 if self._kept else _RESET
        return [dialect.MAVLink_current_event_sequence_message(self._sequence, flags)]

    def again(self, request: Message, asker: tuple[int, int]) -> list[Message]:
        """The answers to REQUEST_EVENT, at most as many as are kept."""
        kept = {message.sequence: message for message in self._kept}
        oldest = min(kept, key=lambda number: (number - self._sequence - 1) % 65536, default=0)
        count = (request.last_sequence - request.first_sequence) % 65536 + 1
        wanted = [(request.first_sequence + i) % 65536 for i in range(min(count, KEPT))]
        error = dialect.MAVLink_response_event_error_message
        return [
            kept[number] if number in kept else error(*asker, number, oldest, _UNAVAILABLE)
            for number in wanted
        ]

    def _event(self, kind: Kind, level: int, boot_ms: int, *values: float) -> Message:
        self._sequence = (self._sequence + 1) % 65536
        layout = "<" + "".join(_CODES[of_type] for of_type in kind.arguments)
        arguments = struct.pack(layout, *values).ljust(40, b"\0")
        number = COMPONENT << 24 | kind.number
        levels = level << 4 | level
        message = dialect.MAVLink_event_message(
            0, 0, number, boot_ms, self._sequence, levels, list(arguments)
        )
        self._kept.append(message)
        return message

    def _word(self, text: str) -> int:
        return self._words.index(text) if text in self._words else UNKNOWN_WORD

    def _metadata(self) -> dict[str, Any]:
        groups: dict[str, Any] = {}
        for kind in (ARMING_SUMMARY, CHECK, HEALTH_SUMMARY, *TOLD.values()):
            arguments = [{"name": f"arg{i}", "type": t} for i, t in enumerate(kind.arguments)]
            about = {"name": f"e{kind.number}", "message": kind.message, "arguments": arguments}
            about |= {"type": kind.type} if kind.type else {}
            groups.setdefault(kind.group, {"events": {}})["events"][str(kind.number)] = about
        entries = {str(i): {"name": f"w{i}", "description": w} for i, w in enumerate(self._words)}
        modes = {str(i): [custom_mode(name)] for i, name in enumerate(MODES)}
        own = {
            "namespace": "sitl",
            "enums": {"word_t": {"type": "uint8_t", "entries": entries}},
            "event_groups": groups,
            "navigation_mode_groups": {"groups": modes},
        }
        return {"version": 2, "components": {str(COMPONENT): own}}


def _packed(about: dict[str, Any]) -> bytes:
    return lzma.compress(json.dumps(about).encode(), preset=0)
