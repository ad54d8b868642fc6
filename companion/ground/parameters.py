"""The companion's own parameters, and its answers in the parameter protocol.

    name              unit   range         default
    CMP_BELIEF_RETRY  s      -1 to 3600    -1     after which a belief that a failure withdrew is
                                                  held again, if the mission does not say; -1 never
    CMP_MONITOR              0 or 1        as started  whether the monitor page is served; 0 again
                                                  if it cannot be, or has ended
    CMP_SPEED_MAX     m/s    0.1 to 50     50     greatest speed of plans and flights; the limits of
                                                  the mission and its vehicle apply as well
    CMP_TEXT_LEVEL           0 to 7        6      greatest MAV_SEVERITY that is sent as STATUSTEXT
    CMP_TICK_HZ       Hz     read only     20     ticks, and setpoints, a second

1. The list is sent completely, also on requests to all components: QGroundControl complains about
   incomplete lists.
2. A request that cannot be done is answered with PARAM_ERROR and the present value. An unknown name
   is an error only if this component alone was asked.
3. No value is kept after the program ends.

Source: https://mavlink.io/en/services/parameter.html.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from companion.mavlink.framing import Message, dialect, source
from companion.mavlink.parameters import INT32, REAL32, asked_for, decode, value_message
from companion.tick import TICK_S


@dataclass(frozen=True, slots=True)
class ParameterMetadata:
    """Type (MAV_PARAM_TYPE), default and range of a parameter; it is read only if the range is one
    value.
    """

    param_type: int
    default: float
    lowest: float
    highest: float

    @property
    def is_read_only(self) -> bool:
        """Whether it can only be read."""
        return self.lowest == self.highest


BELIEF_RETRY, MONITOR, SPEED_MAX, TEXT_LEVEL, TICK = (
    "CMP_BELIEF_RETRY",
    "CMP_MONITOR",
    "CMP_SPEED_MAX",
    "CMP_TEXT_LEVEL",
    "CMP_TICK_HZ",
)
TICK_HZ = round(1 / TICK_S)
PARAMETERS = {
    BELIEF_RETRY: ParameterMetadata(REAL32, -1.0, -1.0, 3600.0),
    MONITOR: ParameterMetadata(INT32, 0, 0, 1),
    SPEED_MAX: ParameterMetadata(REAL32, 50.0, 0.1, 50.0),
    TEXT_LEVEL: ParameterMetadata(INT32, 6, 0, 7),
    TICK: ParameterMetadata(INT32, TICK_HZ, TICK_HZ, TICK_HZ),
}
NAMES = tuple(PARAMETERS)


class CompanionParameters:
    """The values of the parameters, and the answers to requests.

    Args:
        effects: by name, what to do with a requested value; returns the value that results.

    Attributes:
        version: counts the changes.
    """

    def __init__(self, effects: Mapping[str, Callable[[float], float]]) -> None:
        self.version = 0
        self._effects = effects
        self._values = {name: p.default for name, p in PARAMETERS.items()}

    def __getitem__(self, name: str) -> float:
        return self._values[name]

    def values(self) -> list[Message]:
        """Returns PARAM_VALUE of all parameters."""
        return [self._value(name) for name in NAMES]

    def read(self, request: Message) -> list[Message]:
        """Returns the answer to PARAM_REQUEST_READ."""
        name = asked_for(request, NAMES)
        if name is None:
            is_for_us = request.target_component != 0
            return [_error(request, "DOES_NOT_EXIST")] if is_for_us else []
        return [self._value(name)]

    def write(self, request: Message) -> list[Message]:
        """Does what PARAM_SET requests, if allowed; returns the resulting value, and possibly an
        error.
        """
        parameter = PARAMETERS.get(request.param_id)
        if parameter is None:
            return [_error(request, "DOES_NOT_EXIST")]
        now = self._value(request.param_id)
        if parameter.is_read_only:
            return [now, _error(request, "READ_ONLY")]
        value = _value_of(request, parameter)
        if value is None or not parameter.lowest <= value <= parameter.highest:
            return [now, _error(request, "VALUE_OUT_OF_RANGE")]
        effect = self._effects.get(request.param_id)
        after = value if effect is None else effect(value)
        answer = self.put(request.param_id, after)
        return [answer] if after == value else [answer, _error(request, "VALUE_OUT_OF_RANGE")]

    def put(self, name: str, value: float) -> Message:
        """Sets a value without a request; returns the PARAM_VALUE that announces it."""
        self._values[name] = value
        self.version += 1
        return self._value(name)

    def _value(self, name: str) -> Message:
        value, param_type = self._values[name], PARAMETERS[name].param_type
        return value_message(name, value, param_type, len(NAMES), NAMES.index(name))


def _value_of(request: Message, parameter: ParameterMetadata) -> float | None:
    """Returns the number in a PARAM_SET; None if it has another type, or is not finite."""
    if request.param_type != parameter.param_type:
        return None
    value = decode(request.param_value, request.param_type)
    return value if math.isfinite(value) else None


def _error(request: Message, what: str) -> Message:
    return dialect.MAVLink_param_error_message(
        *source(request),
        request.param_id.encode(),
        getattr(request, "param_index", -1),
        getattr(dialect, f"MAV_PARAM_ERROR_{what}"),
    )
