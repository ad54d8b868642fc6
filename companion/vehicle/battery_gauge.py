"""Reads the state of the battery from the autopilot's BATTERY_STATUS."""

from __future__ import annotations

from companion.mavlink.framing import Message, dialect
from companion.vehicle.ports.state import BatteryState

VOLTAGE_UNKNOWN = 65535
KNOWN_S = 5.0
"""How long the last known charge is kept after the autopilot says that it does not know the
charge."""
CRITICAL = (
    dialect.MAV_BATTERY_CHARGE_STATE_CRITICAL,
    dialect.MAV_BATTERY_CHARGE_STATE_EMERGENCY,
)
LOW = (dialect.MAV_BATTERY_CHARGE_STATE_LOW, *CRITICAL)


def battery_after(before: BatteryState, now_s: float, message: Message) -> BatteryState:
    """The state of a battery after a BATTERY_STATUS."""
    percent, percent_s = before.percent, before.percent_s
    if message.battery_remaining >= 0:
        percent, percent_s = message.battery_remaining, now_s
    elif now_s - percent_s > KNOWN_S:
        percent = None
    is_low = message.charge_state in LOW
    low_since_s = now_s if before.low_since_s is None else before.low_since_s
    return BatteryState(
        percent,
        percent_s,
        is_critical=message.charge_state in CRITICAL,
        low_since_s=low_since_s if is_low else None,
        power_w=_power_w(message),
    )


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
