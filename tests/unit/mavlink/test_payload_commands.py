"""No command of a mission moves, arms, disarms, terminates, reboots or switches the vehicle."""

import pytest

from companion.mavlink.framing import dialect
from companion.mavlink.payload_commands import (
    ALL_COMPONENTS,
    AUTOPILOT,
    AUTOPILOT_OUTPUTS,
    PAYLOAD_COMMANDS,
    commands_for,
    why_not_sent,
)

COMMANDS = {entry.name: number for number, entry in dialect.enums["MAV_CMD"].items()}
PAYLOADS = sorted(set(range(256)) - {ALL_COMPONENTS, AUTOPILOT})
DANGEROUS = (  # what the names say: each kind that the rules speak of
    "_NAV_",
    "ARM_",
    "_CONDITION_",
    "PREFLIGHT",
    "MODE_",
    "GUIDED",
    "GOTO",
    "REPOSITION",
    "MISSION",
    "CHANGE_",
    "TERMINATION",
    "MOTOR",
    "ENGINE",
    "ACTUATOR_TEST",
    "CONFIGURE_ACTUATOR",
    "PARACHUTE",
    "PARAMETER",
    "SET_HOME",
    "ORBIT",
    "FIGURE_EIGHT",
    "FOLLOW",
    "LAND",
    "GO_AROUND",
    "PAUSE",
    "REVERSE",
    "AUTOTUNE",
    "FENCE",
    "VTOL",
    "INJECT",
    "FORWARD",
    "MAG_CAL",
    "SAFETY",
    "POSITION_ESTIMATE",
    "STANDARD_MODE",
    "DO_SET_MODE",
    "UAVCAN",
    "SURVEY",
    "JUMP",
    "HIGH_LATENCY",
    "AIRFRAME",
    "RX_PAIR",
    "LOGGING",
)


def test_all_names_are_of_the_dialect() -> None:
    assert PAYLOAD_COMMANDS <= COMMANDS.keys()


@pytest.mark.parametrize("word", DANGEROUS)
def test_no_payload_takes_a_dangerous_command(word: str) -> None:
    named = [name for name in COMMANDS if word in name and name != "MAV_CMD_SET_CAMERA_MODE"]
    assert named, "the dialect has such commands"
    for name in named:
        for component in range(256):
            assert why_not_sent(component, COMMANDS[name]), (name, component)


def test_the_autopilot_takes_its_outputs_alone() -> None:
    taken = {n for n in COMMANDS if why_not_sent(AUTOPILOT, COMMANDS[n]) is None}
    assert taken == AUTOPILOT_OUTPUTS == commands_for(AUTOPILOT)


@pytest.mark.parametrize("number", range(1, 6))
def test_user_commands_go_to_payloads_only(number: int) -> None:
    command = COMMANDS[f"MAV_CMD_USER_{number}"]
    assert why_not_sent(AUTOPILOT, command) is not None
    assert all(why_not_sent(component, command) is None for component in PAYLOADS)


def test_nothing_goes_to_all_components() -> None:
    assert all(why_not_sent(ALL_COMPONENTS, command) for command in COMMANDS.values())
    assert commands_for(ALL_COMPONENTS) == frozenset()


def test_a_command_that_the_dialect_has_not_is_refused() -> None:
    assert why_not_sent(25, 65_000) == "command 65000 is not a command for payloads"
