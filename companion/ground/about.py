"""What does the companion say of itself: once a second, and when it is asked for a message?

PROTOCOL_VERSION is not in the dialect that pymavlink's packages bring, so its layout stands here
(https://mavlink.io/en/messages/common.html#PROTOCOL_VERSION).
"""

from __future__ import annotations

import struct

from companion.ground.operations import Standing
from companion.mavlink.framing import Message, dialect

MAVLINK_2 = 200
CAPABILITIES = (
    dialect.MAV_PROTOCOL_CAPABILITY_MAVLINK2
    | dialect.MAV_PROTOCOL_CAPABILITY_COMMAND_INT
    | dialect.MAV_PROTOCOL_CAPABILITY_PARAM_ENCODE_BYTEWISE
    | dialect.MAV_PROTOCOL_CAPABILITY_FTP
)


STATUS = {
    Standing.STANDBY: dialect.MAV_STATE_STANDBY,
    Standing.ACTIVE: dialect.MAV_STATE_ACTIVE,
    Standing.CRITICAL: dialect.MAV_STATE_CRITICAL,
}


def heartbeat(standing: Standing) -> Message:
    """HEARTBEAT, as of a controller on board that is no autopilot."""
    return dialect.MAVLink_heartbeat_message(
        type=dialect.MAV_TYPE_ONBOARD_CONTROLLER,
        autopilot=dialect.MAV_AUTOPILOT_INVALID,
        base_mode=0,
        custom_mode=0,
        system_status=STATUS[standing],
        mavlink_version=3,
    )


class ProtocolVersion:
    """PROTOCOL_VERSION, as `framing.Endpoint.pack` needs a message."""

    id = 300
    msgname = "PROTOCOL_VERSION"
    crc_extra = 217
    fieldnames = ordered_fieldnames = (
        *("version", "min_version", "max_version"),
        *("spec_version_hash", "library_version_hash"),
    )
    fieldtypes = ("uint16_t", "uint16_t", "uint16_t", "uint8_t", "uint8_t")
    lengths = (1, 1, 1, 8, 8)
    unpacker = struct.Struct("<HHH8B8B")

    version = min_version = max_version = MAVLINK_2
    spec_version_hash = library_version_hash = (0,) * 8  # not known


def protocol_version() -> Message:
    """We speak MAVLink 2 alone."""
    return ProtocolVersion()


def autopilot_version() -> Message:
    """What this component can do; it is no autopilot, so it has no such versions."""
    none = [0] * 8
    return dialect.MAVLink_autopilot_version_message(
        CAPABILITIES, 0, 0, 0, 0, none, none, none, 0, 0, 0
    )
