"""States of a vehicle, made by naming what is special about them."""

from __future__ import annotations

from collections import Counter, defaultdict
from dataclasses import fields, replace
from typing import Any

from companion.geometry import Ned
from companion.vehicle.ports.state import (
    Attitude,
    BatteryState,
    Heartbeat,
    MeasuredMotion,
    Mode,
    VehicleState,
)

AT_REST: Ned = (0.0, 0.0, 0.0)
_VALUES: dict[str, type] = {
    "motion": MeasuredMotion,
    "attitude": Attitude,
    "heartbeat": Heartbeat,
    "battery": BatteryState,
}
_COUNTS = Counter(field.name for kind in _VALUES.values() for field in fields(kind))
_FIELDS = {
    name: (value, field.name)
    for value, kind in _VALUES.items()
    for field in fields(kind)
    for name in (field.name, f"{value}_{field.name}")
    if name != field.name or _COUNTS[name] == 1
}
"""Names of fields -> the value that they belong to, and the name there."""


def standing(position: Ned = AT_REST) -> VehicleState:
    """A vehicle on the ground, disarmed, with a full battery, of which all was heard at 0 s."""
    return VehicleState(
        MeasuredMotion(position, AT_REST),
        Attitude(yaw_rad=0.0),
        Heartbeat(Mode.LOITER, is_armed=False, is_failsafe=False, received_s=0.0),
        is_landed=True,
        battery=BatteryState(percent=100),
    )


def flying(position: Ned = (0.0, 0.0, -2.0), heard_s: float = 0.0) -> VehicleState:
    """A vehicle in the air, in OFFBOARD, of which all was heard just now."""
    return heard_at(
        heard_s,
        changed(standing(position), mode=Mode.OFFBOARD, is_armed=True, is_landed=False),
    )


def heard_at(now_s: float, state: VehicleState) -> VehicleState:
    """The same state, heard and measured at another time."""
    return changed(
        state,
        motion_received_s=now_s,
        motion_measured_s=now_s,
        attitude_measured_s=now_s,
        heartbeat_received_s=now_s,
    )


def changed(state: VehicleState, **news: Any) -> VehicleState:
    """The state with other fields: its own, and those of its values.

    A field that several values have is preceded by the name of its value.

    >>> changed(standing(), mode=Mode.LAND, heartbeat_received_s=3.0).heartbeat
    Heartbeat(mode=<Mode.LAND: 'AUTO.LAND'>, is_armed=False, is_failsafe=False, received_s=3.0)
    """
    own: dict[str, Any] = {}
    values: dict[str, dict[str, Any]] = defaultdict(dict)
    for name, new in news.items():
        if name in _FIELDS:
            value, field = _FIELDS[name]
            values[value][field] = new
        else:
            own[name] = new
    for value, those in values.items():
        own[value] = replace(getattr(state, value), **those)
    return replace(state, **own)
