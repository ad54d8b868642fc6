"""The schedule of the telemetry streams on each link.

`RATES_HZ` has the default rates of a PX4 in SITL on its two links, measured and rounded to what
PX4's `mavlink stream` configures. Messages that the simulator does not make are not listed.
MAV_CMD_SET_MESSAGE_INTERVAL changes one message on one link.
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Container
from typing import Protocol

from sitl.link.messages import MESSAGE_CLASSES
from sitl.link.routing import LinkName

EARLY_S = 1e-6  # sums of intervals are not exact
LEAST_INTERVAL_S = 1.5e-3
"""PX4's MAVLINK_MIN_INTERVAL: the shortest interval of a stream."""
RATES_HZ: dict[str, tuple[float, float]] = {
    # message                     gcs  offboard
    "HEARTBEAT": (1, 1),
    "SYS_STATUS": (1, 5),
    "BATTERY_STATUS": (0.5, 0.5),
    "ATTITUDE": (50, 100),
    "ATTITUDE_QUATERNION": (50, 50),
    "LOCAL_POSITION_NED": (50, 30),
    "GLOBAL_POSITION_INT": (50, 50),
    "GPS_RAW_INT": (5, 8),
    "HOME_POSITION": (0.5, 0.5),
    "EXTENDED_SYS_STATE": (1, 5),
    "ALTITUDE": (1, 10),
    "VFR_HUD": (4, 10),
    "HIGHRES_IMU": (0, 50),
    "SCALED_PRESSURE": (1, 1),
    "SYSTEM_TIME": (0, 1),
    "TIMESYNC": (0, 10),
    "PING": (0.1, 1),
    "ODOMETRY": (0, 30),
    "DISTANCE_SENSOR": (0.5, 10),
    "ESTIMATOR_STATUS": (0.5, 1),
    "VIBRATION": (0.1, 0.5),
    "ATTITUDE_TARGET": (50, 10),
    "FLIGHT_INFORMATION": (0, 0),
    "ACTUATOR_OUTPUT_STATUS": (0, 0),
    "GPS_GLOBAL_ORIGIN": (0, 0),
    "POSITION_TARGET_LOCAL_NED": (50, 10),
    "SERVO_OUTPUT_RAW": (50, 10),
    "MISSION_CURRENT": (1, 1),
}
"""Message -> Hz on each link; 0 is off by default, but can be requested."""

_COLUMN = {LinkName.GCS: 0, LinkName.OFFBOARD: 1}
_Due = tuple[float, int, str]
"""When a stream is due next, the id of its message, and its name."""


class StreamReader(Protocol):
    """The only reader of the streams of a link."""

    @property
    def wanted(self) -> Container[int]:
        """Ids of the messages that it reads."""

    @property
    def continual(self) -> Container[int]:
        """Those of them of which it reads only the newest of several that arrive together."""


class Streams:
    """The schedule of one link.

    A message that the reader does not read is not sent; its schedule continues in phase once it is.

    Args:
        link: whose default rates apply.
        now_s: the first messages are due now.
        reader: at the other end; without one, everything may be read.
    """

    def __init__(
        self, link: LinkName, now_s: float = 0.0, reader: StreamReader | None = None
    ) -> None:
        self._reader = reader
        self._defaults_s = {
            name: 1 / rates[_COLUMN[link]] if rates[_COLUMN[link]] else 0.0
            for name, rates in RATES_HZ.items()
        }
        self._intervals_s = {name: s for name, s in self._defaults_s.items() if s > 0}
        self._has_sent = False
        self._read: Container[int] | None = None
        self._asleep: list[_Due] = []
        self._queue = [(now_s, MESSAGE_CLASSES[name].id, name) for name in self._intervals_s]
        heapq.heapify(self._queue)

    @property
    def due_s(self) -> float:
        """When the next message is due."""
        return self._queue[0][0] - EARLY_S if self._queue else math.inf

    def attend(self, now_s: float) -> None:
        """Adapts to what the reader reads now; everything due before has been sent."""
        if self._reader is None or self._reader.wanted is self._read:
            return
        streams, self._read = [*self._queue, *self._asleep], self._reader.wanted
        sent_s = now_s + EARLY_S if self._has_sent else -math.inf
        self._queue = [self._after(each, sent_s) for each in streams if each[1] in self._read]
        self._asleep = [each for each in streams if each[1] not in self._read]
        heapq.heapify(self._queue)

    def due(self, now_s: float, until_s: float) -> list[str]:
        """The messages to send now; each keeps its rate over the long run.

        Of a continual message, only the last one before `until_s` is ever due.

        Args:
            now_s: the time.
            until_s: everything sent before this arrives together.
            until_s: what is sent until then arrives together.
        """
        queue, sent_s, messages = self._queue, now_s + EARLY_S, []
        continual = () if self._reader is None else self._reader.continual
        self._has_sent = True
        while queue and queue[0][0] <= sent_s:
            due_s, message_id, name = queue[0]
            interval_s = self._intervals_s[name]
            after_s = due_s + interval_s
            if after_s <= now_s:  # an interval shorter than a step: once per step
                after_s = now_s + interval_s
            if after_s - EARLY_S > until_s or message_id not in continual:
                messages.append(name)
            else:
                while after_s + interval_s - EARLY_S <= until_s:
                    after_s += interval_s
            heapq.heapreplace(queue, (after_s, message_id, name))
        return messages

    def _after(self, stream: _Due, sent_s: float) -> _Due:
        """The first time after `sent_s` at which a stream is due, in its present phase."""
        due_s, message_id, name = stream
        while due_s <= sent_s:
            due_s += self._intervals_s[name]
        return due_s, message_id, name

    def set_interval(self, name: str, interval_us: float, now_s: float) -> bool:
        """Changes a message's interval: 0 is the default, negative is off.

        Returns:
            False for a message that is not streamed.
        """
        if name not in self._defaults_s:
            return False
        interval_s = self._defaults_s[name] if interval_us == 0 else interval_us / 1e6
        self._intervals_s.pop(name, None)
        self._queue = [each for each in (*self._queue, *self._asleep) if each[2] != name]
        if interval_s > 0:
            interval_s = max(interval_s, LEAST_INTERVAL_S)
            self._intervals_s[name] = interval_s
            self._queue.append((now_s + interval_s, MESSAGE_CLASSES[name].id, name))
        heapq.heapify(self._queue)
        self._asleep, self._read = [], None  # `attend` fills these again
        return True

    def interval_us(self, name: str) -> int:
        """Interval of a message; 0 if it is not streamed."""
        return round(1e6 * self._intervals_s.get(name, 0.0))
