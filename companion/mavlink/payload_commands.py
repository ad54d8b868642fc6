"""Lists the MAVLink commands that a mission's skills may send, and to whom.

A skill commands payloads. The vehicle itself is flown by setpoints and by the companion's own
goals. So no mission may move, arm, disarm, terminate, reboot, calibrate or switch it, whoever is
addressed: a frame with such a command is only one router away from the autopilot. The first rule
that matches decides:

1. Component 0 stands for all components, including the autopilot: refused.
2. The autopilot (component 1) accepts commands for its own outputs: gripper, actuators, gimbals.
3. Any other component accepts commands for cameras, gimbals, grippers, winches, lights and storage,
   requests for its messages, and the user commands.
4. Everything else is refused, including commands of later dialects.

The rules are applied when a mission is read, and again before a command is sent. Source:
https://mavlink.io/en/messages/common.html#mav_commands.
"""

from __future__ import annotations

from companion.mavlink.framing import dialect

ALL_COMPONENTS = dialect.MAV_COMP_ID_ALL
AUTOPILOT = dialect.MAV_COMP_ID_AUTOPILOT1

AUTOPILOT_OUTPUTS = frozenset(
    {
        "MAV_CMD_DO_GIMBAL_MANAGER_CONFIGURE",
        "MAV_CMD_DO_GIMBAL_MANAGER_PITCHYAW",
        "MAV_CMD_DO_GRIPPER",
        "MAV_CMD_DO_SET_ACTUATOR",
    }
)
"""The commands that the autopilot accepts from a skill (rule 2)."""

PAYLOAD_COMMANDS = AUTOPILOT_OUTPUTS | {
    "MAV_CMD_CAMERA_STOP_TRACKING",
    "MAV_CMD_CAMERA_TRACK_POINT",
    "MAV_CMD_CAMERA_TRACK_RECTANGLE",
    "MAV_CMD_DO_CONTROL_VIDEO",
    "MAV_CMD_DO_DIGICAM_CONFIGURE",
    "MAV_CMD_DO_DIGICAM_CONTROL",
    "MAV_CMD_DO_ILLUMINATOR_CONFIGURE",
    "MAV_CMD_DO_MOUNT_CONFIGURE",
    "MAV_CMD_DO_MOUNT_CONTROL",
    "MAV_CMD_DO_MOUNT_CONTROL_QUAT",
    "MAV_CMD_DO_REPEAT_RELAY",
    "MAV_CMD_DO_REPEAT_SERVO",
    "MAV_CMD_DO_SET_CAM_TRIGG_DIST",
    "MAV_CMD_DO_SET_CAM_TRIGG_INTERVAL",
    "MAV_CMD_DO_SET_RELAY",
    "MAV_CMD_DO_SET_ROI",
    "MAV_CMD_DO_SET_ROI_LOCATION",
    "MAV_CMD_DO_SET_ROI_NONE",
    "MAV_CMD_DO_SET_ROI_SYSID",
    "MAV_CMD_DO_SET_SERVO",
    "MAV_CMD_DO_TRIGGER_CONTROL",
    "MAV_CMD_DO_WINCH",
    "MAV_CMD_ILLUMINATOR_ON_OFF",
    "MAV_CMD_IMAGE_START_CAPTURE",
    "MAV_CMD_IMAGE_STOP_CAPTURE",
    "MAV_CMD_PANORAMA_CREATE",
    "MAV_CMD_PAYLOAD_CONTROL_DEPLOY",
    "MAV_CMD_PAYLOAD_PREPARE_DEPLOY",
    "MAV_CMD_REQUEST_CAMERA_CAPTURE_STATUS",
    "MAV_CMD_REQUEST_CAMERA_IMAGE_CAPTURE",
    "MAV_CMD_REQUEST_CAMERA_INFORMATION",
    "MAV_CMD_REQUEST_CAMERA_SETTINGS",
    "MAV_CMD_REQUEST_MESSAGE",
    "MAV_CMD_REQUEST_STORAGE_INFORMATION",
    "MAV_CMD_REQUEST_VIDEO_STREAM_INFORMATION",
    "MAV_CMD_REQUEST_VIDEO_STREAM_STATUS",
    "MAV_CMD_RESET_CAMERA_SETTINGS",
    "MAV_CMD_SET_CAMERA_FOCUS",
    "MAV_CMD_SET_CAMERA_MODE",
    "MAV_CMD_SET_CAMERA_SOURCE",
    "MAV_CMD_SET_CAMERA_ZOOM",
    "MAV_CMD_SET_MESSAGE_INTERVAL",
    "MAV_CMD_SET_STORAGE_USAGE",
    "MAV_CMD_STORAGE_FORMAT",
    "MAV_CMD_USER_1",
    "MAV_CMD_USER_2",
    "MAV_CMD_USER_3",
    "MAV_CMD_USER_4",
    "MAV_CMD_USER_5",
    "MAV_CMD_VIDEO_START_CAPTURE",
    "MAV_CMD_VIDEO_START_STREAMING",
    "MAV_CMD_VIDEO_STOP_CAPTURE",
    "MAV_CMD_VIDEO_STOP_STREAMING",
}
"""The commands that any other component accepts (rule 3)."""


def why_not_sent(component: int, command: int) -> str | None:
    """Returns why a skill may not send a command to a component; None if it may.

    >>> why_not_sent(25, dialect.MAV_CMD_DO_GRIPPER)
    >>> why_not_sent(25, dialect.MAV_CMD_COMPONENT_ARM_DISARM)
    'MAV_CMD_COMPONENT_ARM_DISARM is not a command for payloads'

    Args:
        component: MAVLink component id of the addressee.
        command: number of the MAV_CMD.
    """
    entry = dialect.enums["MAV_CMD"].get(command)
    name = entry.name if entry else f"command {command}"
    if component == ALL_COMPONENTS:
        return "component 0 stands for all components, the autopilot among them"
    if component == AUTOPILOT and name not in AUTOPILOT_OUTPUTS:
        return f"{name} is not a command that the autopilot takes from a skill"
    if name not in PAYLOAD_COMMANDS:
        return f"{name} is not a command for payloads"
    return None


def commands_for(component: int) -> frozenset[str]:
    """Returns the names of the commands that a skill may send to a component."""
    if component == ALL_COMPONENTS:
        return frozenset()
    return AUTOPILOT_OUTPUTS if component == AUTOPILOT else PAYLOAD_COMMANDS
