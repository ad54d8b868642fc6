"""Reads the state of the battery from the autopilot's BATTERY_STATUS."""

from __future__ import annotations

import math

from companion.mavlink.framing import Message, dialect

VOLTAGE_UNKNOWN = 65535
KNOWN_S = 5.0
"""How long the last known charge is kept after the autopilot says that it does not know the
charge."""
CRITICAL = (
    dialect.MAV_BATTERY_CHARGE_STATE_CRITICAL,
    dialect.MAV_BATTERY_CHARGE_STATE_EMERGENCY,
)
LOW = (dialect.MAV_BATTERY_CHARGE_STATE_LOW, *CRITICAL)


class BatteryGauge:
    """The newest values.

    Attributes:
        percent: remaining charge, None while unknown.
        percent_s: when the charge was last reported.
        is_critical: the autopilot reports the charge as critical or worse.
        low_since_s: since when the autopilot reports the charge as low or worse; inf while it does
            not.
        power_w: power drawn, voltage times current; None while one of them is not known.
    """

    def __init__(self) -> None:
        self.percent: int | None = None
        self.percent_s = 0.0
        self.is_critical = False
        self.low_since_s = math.inf
        self.power_w: float | None = None

    def take(self, now_s: float, message: Message) -> None:
        """Takes a BATTERY_STATUS."""
        if message.battery_remaining >= 0:
            self.percent, self.percent_s = message.battery_remaining, now_s
        elif now_s - self.percent_s > KNOWN_S:
            self.percent = None
        self.is_critical = message.charge_state in CRITICAL
        self.low_since_s = min(self.low_since_s, now_s) if message.charge_state in LOW else math.inf
        self.power_w = _power_w(message)


def voltage_v(message: Message) -> float | None:
    """Sum of the cell voltages in a BATTERY_STATUS; None if not known."""
    cells_mv = [each for each in message.voltages if each != VOLTAGE_UNKNOWN]
    return sum(cells_mv) / 1000 if cells_mv else None


def _power_w(message: Message) -> float | None:
    """Voltage times current of a BATTERY_STATUS; None without one of them.

    A negative current, as from a charger, is not used: PX4 sends -1 if it does not know the
    current.
    """
    volts, amperes = voltage_v(message), message.current_battery / 100
    return None if volts is None or amperes < 0 else volts * amperes
