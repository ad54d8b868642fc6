"""Reads single parameters of the autopilot: requests each until it is answered. No I/O.

Source: https://mavlink.io/en/services/parameter.html. PX4 does not answer for a name that it does
not know.
"""

from __future__ import annotations

import logging

from companion.mavlink.framing import Message, dialect
from companion.mavlink.parameters import INT32, REAL32, decode

ASK_AGAIN_S = 0.5
BY_NAME = -1

log = logging.getLogger(__name__)


class ParameterReader:
    """The parameters that were requested, and their answers.

    Implements `ports.parameters.AutopilotParameters`.
    """

    def __init__(self) -> None:
        self._values: dict[str, float] = {}
        self._next_ask_s: dict[str, float] = {}

    def read(self, name: str) -> float | None:
        """The value of a parameter; None until the autopilot has answered."""
        if name not in self._values:
            self._next_ask_s.setdefault(name, 0.0)
        return self._values.get(name)

    def take(self, message: Message) -> None:
        """Takes a PARAM_VALUE."""
        is_known_type = message.param_type in (INT32, REAL32)
        if is_known_type and message.param_id in self._next_ask_s:
            del self._next_ask_s[message.param_id]
            value = float(decode(message.param_value, message.param_type))
            self._values[message.param_id] = value
            log.debug("parameter %s is %g", message.param_id, value)

    def due(self, now_s: float, target: tuple[int, int]) -> list[Message]:
        """The requests to send now to (system, component)."""
        questions = []
        for name, next_ask_s in self._next_ask_s.items():
            if now_s >= next_ask_s:
                self._next_ask_s[name] = now_s + ASK_AGAIN_S
                log.debug("parameter %s: asked %d/%d", name, *target)
                questions.append(
                    dialect.MAVLink_param_request_read_message(*target, name.encode(), BY_NAME)
                )
        return questions
