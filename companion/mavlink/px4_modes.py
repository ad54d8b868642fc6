"""Converts PX4's flight modes from and to HEARTBEAT.custom_mode and MAV_CMD_DO_SET_MODE.

custom_mode contains the main mode in bits 16-23 and the sub mode in bits 24-31; DO_SET_MODE has
them in param2 and param3. Source: PX4, src/modules/commander/px4_custom_mode.h.
"""

from __future__ import annotations

MODES: dict[str, tuple[int, int]] = {
    "MANUAL": (1, 0),
    "ALTCTL": (2, 0),
    "POSCTL": (3, 0),
    "AUTO.READY": (4, 1),
    "AUTO.TAKEOFF": (4, 2),
    "AUTO.LOITER": (4, 3),
    "AUTO.MISSION": (4, 4),
    "AUTO.RTL": (4, 5),
    "AUTO.LAND": (4, 6),
    "ACRO": (5, 0),
    "OFFBOARD": (6, 0),
    "STABILIZED": (7, 0),
}
"""Name -> main mode, sub mode."""

_NAMES = {modes: name for name, modes in MODES.items()}


def custom_mode(name: str) -> int:
    """Returns the HEARTBEAT.custom_mode of a mode.

    >>> hex(custom_mode("OFFBOARD")), hex(custom_mode("AUTO.LOITER"))
    ('0x60000', '0x3040000')
    """
    main, sub = MODES[name]
    return main << 16 | sub << 24


def mode_name(custom: int) -> str | None:
    """Returns the name of a HEARTBEAT.custom_mode; None if it is not in the table."""
    return mode_from(custom >> 16 & 0xFF, custom >> 24 & 0xFF)


def mode_from(main: int, sub: int) -> str | None:
    """Returns the name of a main and sub mode; None if the pair is not in the table."""
    return _NAMES.get((main, sub))
