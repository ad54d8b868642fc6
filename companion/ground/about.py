"""Messages in which the companion describes itself: HEARTBEAT, versions, capabilities.

The dialect that comes with pymavlink lacks PROTOCOL_VERSION, so its layout is defined here
(https://mavlink.io/en/messages/common.html#PROTOCOL_VERSION).
"""

from __future__ import annotations

import struct

from companion.ground.operations import SystemStatus
from companion.mavlink.framing import Message, dialect

MAVLINK_2 = 200
CAPABILITIES = (
    dialect.MAV_PROTOCOL_CAPABILITY_MAVLINK2
    | dialect.MAV_PROTOCOL_CAPABILITY_COMMAND_INT
    | dialect.MAV_PROTOCOL_CAPABILITY_PARAM_ENCODE_BYTEWISE
    | dialect.MAV_PROTOCOL_CAPABILITY_FTP
)


MAV_STATES = {
    SystemStatus.STANDBY: dialect.MAV_STATE_STANDBY,
    SystemStatus.ACTIVE: dialect.MAV_STATE_ACTIVE,
    SystemStatus.CRITICAL: dialect.MAV_STATE_CRITICAL,
}


def heartbeat(status: SystemStatus) -> Message:
    """Returns the HEARTBEAT of an onboard controller that is not an autopilot."""
    return dialect.MAVLink_heartbeat_message(
        type=dialect.MAV_TYPE_ONBOARD_CONTROLLER,
        autopilot=dialect.MAV_AUTOPILOT_INVALID,
        base_mode=0,
        custom_mode=0,
        system_status=MAV_STATES[status],
        mavlink_version=3,
    )


class ProtocolVersion:
    """The message PROTOCOL_VERSION, with the attributes that packing needs."""

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
    """Returns PROTOCOL_VERSION: MAVLink 2 only."""
    return ProtocolVersion()


def autopilot_version() -> Message:
    """Returns AUTOPILOT_VERSION with the capabilities; the versions, which are an autopilot's, are
    0.
    """
    none = [0] * 8
    return dialect.MAVLink_autopilot_version_message(
        CAPABILITIES, 0, 0, 0, 0, none, none, none, 0, 0, 0
    )
