"""The lines that `companion watch` prints about a flight. Pure: messages in, lines out.

- Each STATUSTEXT of the companion is a line; the chunks of long ones are joined.
- The status line shows mode, battery and height, from the autopilot.
- A NAMED_VALUE_INT `exit_code` of the companion ends the run that is watched, with this code.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from companion.errors import printable
from companion.mavlink.framing import dialect
from companion.mavlink.px4_modes import mode_name
from companion.mavlink.statustext import CHUNK_BYTES

COMPANION = dialect.MAV_COMP_ID_ONBOARD_COMPUTER
AUTOPILOT = dialect.MAV_COMP_ID_AUTOPILOT1
EXIT_CODE = "exit_code"
NAMES = ("HEARTBEAT", "STATUSTEXT", "SYS_STATUS", "GLOBAL_POSITION_INT", "NAMED_VALUE_INT")
"""Names of the messages that are read here."""


class WatchedFlight:
    """What was heard of a flight so far.

    Attributes:
        exit_code: of the run, once it has ended.
        heard_s: when the companion's last heartbeat arrived.
    """

    def __init__(self, now_s: float) -> None:
        self.exit_code: int | None = None
        self.heard_s = now_s
        self._texts = StatusTextAssembler()
        self._mode = "?"
        self._is_armed = False
        self._battery_percent = -1
        self._height_m: float | None = None

    @property
    def status(self) -> str:
        """The state of the vehicle in one line."""
        battery = "?" if self._battery_percent < 0 else str(self._battery_percent)
        height = "?" if self._height_m is None else f"{self._height_m:.1f}"
        armed = "armed" if self._is_armed else "disarmed"
        return f"{self._mode}  {armed}  battery {battery} %  height {height} m"

    def take(self, now_s: float, component: int, name: str, fields: Mapping[str, Any]) -> list[str]:
        """Takes a message and returns the lines to print."""
        if component == COMPANION:
            return self._from_companion(now_s, name, fields)
        if component == AUTOPILOT:
            self._from_autopilot(name, fields)
        return []

    def _from_companion(self, now_s: float, name: str, fields: Mapping[str, Any]) -> list[str]:
        if name == "STATUSTEXT":
            return self._texts.take(
                fields.get("text", ""), fields.get("id", 0), fields.get("chunk_seq", 0)
            )
        if name == "HEARTBEAT":
            self.heard_s = now_s
        if name == "NAMED_VALUE_INT" and fields.get("name") == EXIT_CODE:
            self.exit_code = int(fields["value"])
        return []

    def _from_autopilot(self, name: str, fields: Mapping[str, Any]) -> None:
        if name == "HEARTBEAT":
            self._mode = mode_name(int(fields["custom_mode"])) or "?"
            self._is_armed = bool(int(fields["base_mode"]) & dialect.MAV_MODE_FLAG_SAFETY_ARMED)
        elif name == "SYS_STATUS":
            self._battery_percent = int(fields["battery_remaining"])
        elif name == "GLOBAL_POSITION_INT":
            self._height_m = int(fields["relative_alt"]) / 1000


class StatusTextAssembler:
    """Joins the chunks of texts (https://mavlink.io/en/messages/common.html#STATUSTEXT)."""

    def __init__(self) -> None:
        self._id = 0
        self._chunks: list[str] = []

    def take(self, text: str, number: int, chunk: int) -> list[str]:
        """Takes a chunk; returns the texts that are complete. A lost chunk is simply missing.

        >>> texts = StatusTextAssembler()
        >>> texts.take("a" * 50, 7, 0), texts.take("!", 7, 1)[0][-2:]
        ([], 'a!')
        """
        if number == 0:
            return [*self._rest(), printable(text)]
        whole = self._rest() if number != self._id or chunk == 0 else []
        self._id = number
        self._chunks.append(text)
        return whole + (self._rest() if len(text.encode()) < CHUNK_BYTES else [])

    def _rest(self) -> list[str]:
        joined, self._chunks = "".join(self._chunks), []
        return [printable(joined)] if joined else []
