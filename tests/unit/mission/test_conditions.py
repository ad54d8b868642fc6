"""Conditions are read as written, and held against MAVLink's own names."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pymavlink.dialects.v20 import common

from companion.errors import FormulaError
from companion.mission.conditions import parse_condition
from companion.mission.mavlink_names import COMMANDS
from companion.mission.signals import Condition, Signal


@pytest.mark.parametrize(
    ("text", "condition"),
    [
        (
            "NAMED_VALUE_INT[target].value > 0",
            Condition(Signal("NAMED_VALUE_INT", "target", "value"), ">", 0.0),
        ),
        (
            "BATTERY_STATUS.battery_remaining<30",
            Condition(Signal("BATTERY_STATUS", "", "battery_remaining"), "<", 30.0),
        ),
        (
            " COMMAND.MAV_CMD_NAV_RETURN_TO_LAUNCH ",
            Condition(Signal("COMMAND", "", "MAV_CMD_NAV_RETURN_TO_LAUNCH"), "!=", 0.0),
        ),
        (
            "COMMAND.MAV_CMD_USER_1 == 1",
            Condition(Signal("COMMAND", "", "MAV_CMD_USER_1"), "==", 1.0),
        ),
        ("VFR_HUD.alt >= -1.5e1", Condition(Signal("VFR_HUD", "", "alt"), ">=", -15.0)),
    ],
)
def test_condition(text: str, condition: Condition) -> None:
    assert parse_condition(text) == condition


@pytest.mark.parametrize(
    ("text", "what", "hint"),
    [
        ("§BATERY_STATUS.id > 0", "unknown MAVLink message BATERY_STATUS", "mean BATTERY_STATUS?"),
        ("BATTERY_STATUS.§batery_remaining > 0", "has no field", "mean battery_remaining?"),
        ("BATTERY_STATUS.§voltages > 0", "is not one number", "current_battery"),
        ("BATTERY_STATUS[§one].id > 0", "has no instances", "write BATTERY_STATUS.id"),
        ("§NAMED_VALUE_INT.value > 0", "comes in instances", "NAMED_VALUE_INT[target].value"),
        ("NAMED_VALUE_INT[§].value > 0", "not a condition", "NAMED_VALUE_INT[target].value"),
        ("NAMED_VALUE_INT[§elevenchars].value > 0", "cannot be a name", "10 ASCII characters"),
        ("NAMED_VALUE_INT[target].§name > 0", "is not one number", "value"),
        ("COMMAND.§MAV_CMD_USER_9", "unknown command", "Did you mean MAV_CMD_USER_"),
        ("COMMAND[§x].MAV_CMD_USER_1", "a command has no instance", "write COMMAND"),
        ("§NAMED_VALUE_INT[gas] > 0", "not a condition", "write NAMED_VALUE_INT[gas].value"),
        ("§NAMED_VALUE_FLOAT [gas]", "not a condition", "write NAMED_VALUE_FLOAT[gas].value"),
        ("BATTERY_STATUS §> 0", "not a condition", "MESSAGE[name].field > NUMBER"),
        ("VFR_HUD.alt§", "is compared with nothing", "> 0"),
        ("VFR_HUD.alt > §nan", "not a condition", "NUMBER"),
        ("VFR_HUD.alt > §True", "not a condition", "> 0 for true"),
        ("VFR_HUD.alt §= 3", "not a condition", "write =="),
        ("VFR_HUD.alt > 1 §or VFR_HUD.alt < 0", "not a condition", "make an event of each"),
        ("VFR_HUD.climb >§", "not a condition", "NUMBER"),
        ("NAMED_VALUE_INT[target.value > 0§", "not a condition", "MESSAGE[name].field"),
        ("VFR_HUD.alt > 1 §& 2", "not a condition", "make an event of each"),
        ("VFR_HUD.airspeed > 30 §km/h", "not a condition", "write metres per second: 8.33"),
        ("GLOBAL_POSITION_INT.vx > 5 §m/s", "not a condition", "centimetres per second: 500"),
        ("EVENT[persons] > 3 §times", "not a condition", "the number alone, without times"),
        ("§", "not a condition", "NUMBER"),
        ("§EVENT.persons > 0", "unknown MAVLink message EVENT", "written EVENT[persons]"),
        ("EVENT[§two words] > 0", "cannot be the name of a report", "EVENT[name] > NUMBER"),
        ("§EVENT[persons].value > 0", "unknown MAVLink message EVENT", "written EVENT[persons]"),
        ("COMMAND.MAV_CMD_USER_1 §is silent", "a command is silent but for a moment", "remove it"),
    ],
)
def test_wrong_condition(text: str, what: str, hint: str) -> None:
    offset = text.index("§")
    with pytest.raises(FormulaError) as caught:
        parse_condition(text.replace("§", ""))
    assert (caught.value.offset, what in caught.value.what) == (offset, True)
    assert hint in caught.value.advice


@given(message=st.sampled_from(list(common.mavlink_map.values())), data=st.data())
def test_every_number_on_the_wire_can_be_named(message: type, data: st.DataObject) -> None:
    """A field is accepted exactly if a message that carries it decodes it to one number."""
    field = data.draw(st.sampled_from(message.fieldnames))  # type: ignore[attr-defined]
    name = message.msgname  # type: ignore[attr-defined]
    sizes = dict(zip(message.ordered_fieldnames, message.array_lengths, strict=True))  # type: ignore[attr-defined]
    instance = "[x]" if sizes.get("name", 0) else ""
    text = f"{name}{instance}.{field} != 0"
    if sizes[field] == 0:
        assert parse_condition(text).signal == Signal(name, instance.strip("[]"), field)
    else:
        with pytest.raises(FormulaError, match="is not one number"):
            parse_condition(text)


def test_command_numbers_are_common_xml_s() -> None:
    assert COMMANDS["MAV_CMD_USER_1"] == common.MAV_CMD_USER_1 == 31010
    assert "MAV_CMD_ENUM_END" not in COMMANDS


@pytest.mark.parametrize(
    ("text", "what"),
    [
        ("BATTERY_STATUS.battery_remaining < -5", "never"),
        ("BATTERY_STATUS.battery_remaining > 100", "never"),
        ("BATTERY_STATUS.battery_remaining == 0.3", "never"),
        ("SYS_STATUS.battery_remaining >= -1", "always"),
    ],
)
def test_a_percentage_is_compared_with_what_it_may_be(text: str, what: str) -> None:
    with pytest.raises(FormulaError, match=f"this is {what} so"):
        parse_condition(text)


def test_a_battery_that_is_not_known_is_a_condition() -> None:
    condition = parse_condition("BATTERY_STATUS.battery_remaining < 0")
    assert isinstance(condition, Condition) and condition.is_met_by(-1)
