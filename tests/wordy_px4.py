"""A PX4 that says what a test wants in STATUSTEXT and EVENT, and has the metadata of its events."""

from __future__ import annotations

import json
import struct
from typing import Any

from companion.mavlink.framing import Message, dialect
from companion.mavlink.ftp_frames import Nak, Opcode
from companion.vehicle.autopilot_words import AutopilotWords

TICK_S = 0.05
AUTOPILOT = (1, 1)
HOLD, MANUAL = 50593792, 65536
CRITICAL, ERROR, WARNING, INFO = 2, 3, 4, 6
SUMMARY, HEALTH, NO_GPS, LOW_CPU, MODE_ONLY, DENIED, ALTITUDE, WARNS, SWITCHES = range(1, 10)
EXPLAINED = "append_health_and_arming_messages"
CHECK = [{"type": "uint32_t"}, {"type": "uint8_t"}]


def event(message: str, *types: str, **more: Any) -> dict[str, Any]:
    return {"name": "e", "message": message, "arguments": [{"type": t} for t in types]} | more


EVENTS = {
    "arming_check": {
        SUMMARY: event("", "uint8_t", type="summary"),
        NO_GPS: event("No GPS", "uint32_t", "uint8_t"),
        MODE_ONLY: event("No stick", "uint32_t", "uint8_t"),
    },
    "health": {
        HEALTH: event("", "uint8_t", type="summary"),
        LOW_CPU: event("CPU load {3:.1}%", "uint32_t", "uint8_t", "float"),
    },
    "default": {
        DENIED: event("Arming denied"),
        ALTITUDE: event("Low at {1:.1m_v}", "float"),
        WARNS: event("Failsafe warning:", type=EXPLAINED),
        SWITCHES: event("Failsafe activated: switching", type=EXPLAINED),
    },
}
GROUPS = {group: {"events": about} for group, about in EVENTS.items()}
COMPONENT = {
    "namespace": "px4",
    "event_groups": GROUPS,
    "navigation_mode_groups": {"groups": {"0": [MANUAL], "4": [HOLD]}},
}
FILES = {
    "g.json": json.dumps({"metadataTypes": [{"type": 4, "uri": "mftp://[;comp=1]/e.json"}]}),
    "/e.json": json.dumps({"components": {"1": COMPONENT}}),
}


class Px4:
    """Answers what `AutopilotWords` asks, and says what a test wants."""

    def __init__(self, files: dict[str, str] = FILES, hears: bool = True) -> None:
        self.words = AutopilotWords()
        self.words.custom_mode = HOLD
        self.files, self.hears = files, hears
        self.now_s, self.sequence = 100.0, 65530
        self.is_flown = False
        self.kept: dict[int, Message] = {}
        self.commands: list[int] = []
        self.asked: list[tuple[int, int]] = []
        self.report: list[tuple[int, int, bytes]] = []
        self._open = ""

    def run(self, seconds: float) -> None:
        end_s = self.now_s + seconds
        while self.now_s < end_s:
            self.now_s += TICK_S
            for message in self.words.due(self.now_s, AUTOPILOT, self.is_flown):
                self._answer(message)

    def _answer(self, message: Message) -> None:
        kind = message.get_type()
        assert (message.target_system, message.target_component) == AUTOPILOT
        if kind == "COMMAND_LONG":
            self.commands.append(message.command)
            if not self.hears:
                return
            if message.command == dialect.MAV_CMD_RUN_PREARM_CHECKS:
                self.say_report()
            else:
                uri = next(iter(self.files)).encode()
                self.say(dialect.MAVLink_component_metadata_message(0, 0, b"mftp://" + uri))
        elif kind == "REQUEST_EVENT":
            self.asked.append((message.first_sequence, message.last_sequence))
            number = message.first_sequence
            while number != (message.last_sequence + 1) % 65536:
                if number in self.kept:
                    self.say(self.kept[number])
                number = (number + 1) % 65536
        else:
            self._serve(bytes(message.payload))

    def _serve(self, payload: bytes) -> None:
        sequence, _, opcode, size, *_, offset = struct.unpack_from("<HBBBBBBI", payload)
        data, nak = b"", 0
        if opcode == Opcode.OPEN_FILE_RO:
            self._open = payload[12 : 12 + size].decode()
            nak = 0 if self._open in self.files else Nak.FILE_NOT_FOUND
            data = struct.pack("<I", len(self.files.get(self._open, "")))
        elif opcode == Opcode.READ_FILE:
            data = self.files[self._open].encode()[offset : offset + size]
        if nak:
            data = bytes([nak])
        head = struct.pack(
            "<HBBBBBBI", sequence + 1, 0, 129 if nak else 128, len(data), opcode, 0, 0, offset
        )
        full = (head + data).ljust(251, b"\0")
        self.say(dialect.MAVLink_file_transfer_protocol_message(0, 1, 191, list(full)))

    def say(self, message: Message) -> None:
        self.words.take(self.now_s, message)

    def event(self, number: int, level: int, arguments: bytes = b"", is_lost: bool = False) -> None:
        self.sequence = (self.sequence + 1) % 65536
        message = dialect.MAVLink_event_message(
            0, 0, 1 << 24 | number, 0, self.sequence, 0x60 | level, list(arguments.ljust(40, b"\0"))
        )
        self.kept[self.sequence] = message
        if not is_lost:
            self.say(message)

    def tell_newest(self) -> None:
        self.say(dialect.MAVLink_current_event_sequence_message(self.sequence, 0))

    def say_report(self, lost: int = -1) -> None:
        self.event(SUMMARY, 8, is_lost=lost == 0)
        for at, (number, level, arguments) in enumerate(self.report, start=1):
            self.event(number, level, arguments, is_lost=lost == at)
        self.event(HEALTH, 8, is_lost=lost == len(self.report) + 1)

    @property
    def why_not(self) -> list[str]:
        return self.words.why_not_armed(self.now_s)


def check(modes: int, *values: float) -> bytes:
    return struct.pack(f"<IB{len(values)}f", modes, 0, *values)
