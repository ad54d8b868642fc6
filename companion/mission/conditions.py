"""Reads conditions on MAVLink fields and detectors' reports: the `when` and `until` of events.

    MESSAGE.field OP NUMBER              BATTERY_STATUS.battery_remaining < 30
    MESSAGE[instance].field OP NUMBER    NAMED_VALUE_INT[target].value > 0
    COMMAND.MAV_CMD_NAME                 a command sent to the companion; short for `... != 0`
    EVENT[name] OP NUMBER                EVENT[persons] > 0, as another program reports it
    ... is silent                        EVENT[persons] is silent: not heard for `stale_s`

OP is one of < <= > >= == !=. Messages, fields and commands are checked against pymavlink's `common`
dialect, which the vehicle link speaks. Only messages with a field `name` have instances. Reports
may have any name; they arrive by `--events`.
"""

from __future__ import annotations

import re

from pymavlink.dialects.v20 import common

from companion.documents import did_you_mean, most_similar
from companion.documents.units import number_in_unit, unit_called
from companion.errors import FormulaError
from companion.mission.signals import (
    COMMAND,
    REPORT,
    AnyCondition,
    Condition,
    Signal,
    Silence,
)

COMMANDS: dict[str, int] = {
    entry.name: number
    for number, entry in common.enums["MAV_CMD"].items()
    if entry.name != "MAV_CMD_ENUM_END"
}
"""MAV_CMD name -> number."""
_PREFIX = "MAV_CMD_"

PERCENT = range(-1, 101)
"""The values of a field in per cent; -1 means unknown."""

_MESSAGES = {message.msgname: message for message in common.mavlink_map.values()}

_SAYS = (
    r"\s*(?:(?P<comparison><=|>=|==|!=|<|>)\s*"
    r"(?P<threshold>[-+]?(?:\d{1,20}\.?\d{0,20}|\.\d{1,20})(?:[eE][-+]?\d{1,2})?)\s*"
    r"|(?P<silent>is\s+silent)\s*)?"
)
_CONDITION = re.compile(
    r"\s*(?P<message>\w+)\s*(?:\[\s*(?P<instance>[^\[\]]*?)\s*\])?\s*\.\s*(?P<field>\w+)" + _SAYS,
    re.ASCII,
)
_REPORT = re.compile(
    rf"\s*(?P<message>{REPORT})\s*\[\s*(?P<instance>[A-Za-z_]\w{{0,62}})\s*\]" + _SAYS, re.ASCII
)
_NAMED_ALONE = re.compile(r"(NAMED_VALUE_(?:INT|FLOAT)\s*\[[^\[\]]*\])\s*(?![.\s])", re.ASCII)


def parse_condition(text: str) -> AnyCondition:
    """Reads a condition.

    >>> print(parse_condition("COMMAND.MAV_CMD_USER_1"), parse_condition("EVENT[persons]>0"))
    COMMAND.MAV_CMD_USER_1 EVENT[persons] > 0

    Raises:
        FormulaError: it is no condition, or names something that `common` does not have.
    """
    match = _compared(text)
    if match is None:
        longest = _REPORT.match(text) or _CONDITION.match(text)
        offset = longest.end() if longest else 0
        raise FormulaError("not a condition", text, offset, hint=_remedy(text, offset))
    signal = _signal(match)
    if match["silent"]:
        if signal.is_pulse:
            raise _error(match, "silent", "a command is silent but for a moment", "remove it")
        return Silence(signal)
    if match["comparison"]:
        condition = Condition(signal, match["comparison"], float(match["threshold"]))
        _demand_change(condition, match)
        return condition
    if signal.message != COMMAND:
        raise FormulaError(
            f"{text.strip()} is compared with nothing",
            text,
            len(text.rstrip()),
            hint="add a comparison, e.g. > 0",
        )
    return Condition(signal, "!=", 0.0)


def _compared(text: str) -> re.Match[str] | None:
    return _REPORT.fullmatch(text) or _CONDITION.fullmatch(text)


def _remedy(text: str, offset: int) -> str:
    """What to write instead of the text after an offset."""
    rest = text[offset:].strip()
    if rest.startswith("MAV_CMD_"):
        return f"write COMMAND.{rest}"
    if re.match(r"=\s*[-+\d]", rest):
        return "write =="
    if re.match(r"(and|or|&+|\|+)\s", rest):
        return "an event has one condition: make an event of each, and join them in the task"
    if re.match(r"[=!<>]=?\s*(true|false)\b", rest, re.IGNORECASE):
        return "compare with a number: > 0 for true, == 0 for false"
    if re.match(r"[=!<>]=?\s*[A-Za-z]", rest):
        return "compare with a NUMBER: names of values are not known here"
    if re.match(r"[A-Za-z%°]", rest) and (begun := _compared(text[:offset])):
        return _without_unit(begun, rest)
    if named := _NAMED_ALONE.match(rest):
        return f"write {named[1]}.value"
    return (
        "write MESSAGE.field > NUMBER, MESSAGE[name].field > NUMBER, EVENT[name] > NUMBER"
        " or COMMAND.MAV_CMD_NAME"
    )


def _without_unit(begun: re.Match[str], unit: str) -> str:
    """What to write instead of a threshold that is followed by a unit.

    Args:
        begun: the condition up to the threshold.
        unit: the text that follows.
    """
    message, threshold = _MESSAGES.get(begun["message"]), begun["threshold"]
    units = message.fieldunits_by_name if message is not None else {}
    if threshold and units and (wanted := unit_called(units.get(begun["field"], ""))):
        return number_in_unit(threshold, unit, wanted)
    return f"write the number alone, without {unit}"


def _demand_change(condition: Condition, match: re.Match[str]) -> None:
    """Refuses a comparison of a percentage that is always true, or never."""
    message = _MESSAGES.get(condition.signal.message)
    units = message.fieldunits_by_name if message is not None else {}
    if units.get(condition.signal.field) != "%":
        return
    if 0 < condition.threshold < 1 and condition.comparison not in ("==", "!="):
        hint = f"write percent: {100 * condition.threshold:g}"
        raise _error(match, "threshold", f"{condition.threshold:g} is a share", hint)
    truths = set(map(condition.is_met_by, PERCENT))
    if len(truths) == 1:
        what = "always" if truths.pop() else "never"
        hint = "a percentage is 0 to 100, or -1 while it is not known"
        raise _error(match, "threshold", f"this is {what} so", hint)


def command_number(name: str, text: str, offset: int) -> int:
    """Returns the number of a MAV_CMD; `text` and `offset` are the name's place, for the error."""
    if name not in COMMANDS:
        numbered = [known for known, number in COMMANDS.items() if name == str(number)]
        listed = "MAVLink's common.xml lists them, e.g. MAV_CMD_IMAGE_START_CAPTURE"
        meant = most_similar(
            name.removeprefix(_PREFIX), [c.removeprefix(_PREFIX) for c in COMMANDS]
        )
        near = f"Did you mean {_PREFIX}{meant}?" if meant else listed
        hint = f"write {numbered[0]}" if numbered else near
        raise FormulaError(f"unknown command {name}", text, offset, len(name), hint)
    return COMMANDS[name]


def _signal(match: re.Match[str]) -> Signal:
    if match.re is _REPORT:
        return Signal(REPORT, match["instance"], "")
    return _command_signal(match) if match["message"] == COMMAND else _field_signal(match)


def _command_signal(match: re.Match[str]) -> Signal:
    if match["instance"] is not None:
        raise _error(match, "instance", "a command has no instance", "write COMMAND.MAV_CMD_NAME")
    command_number(match["field"], match.string, match.start("field"))
    return Signal(COMMAND, "", match["field"])


def _field_signal(match: re.Match[str]) -> Signal:
    name, field, instance = match["message"], match["field"], match["instance"]
    message = _MESSAGES.get(name)
    if message is None:
        hint = "MAVLink's common.xml lists them, e.g. BATTERY_STATUS; uORB topics are none"
        if not name.islower():
            hint = did_you_mean(name, [*_MESSAGES, COMMAND]) or hint
        if name == REPORT:
            hint = f"a report is written {REPORT}[{field}]"
        raise _error(match, "message", f"unknown MAVLink message {name}", hint)
    sizes = dict(zip(message.ordered_fieldnames, message.array_lengths, strict=True))
    numbers = [n for n in message.fieldnames if sizes[n] == 0]
    if field in sizes and field not in numbers:
        hint = f"fields with one number are {', '.join(numbers)}"
        raise _error(match, "field", f"{name}.{field} is not one number", hint)
    if field not in sizes:
        hint = f"fields are {', '.join(numbers)}. {did_you_mean(field, numbers)}".rstrip()
        raise _error(match, "field", f"{name} has no field {field}", hint)
    if sizes.get("name", 0) == 0:
        if instance is not None:
            hint = f"write {name}.{field}"
            raise _error(match, "instance", f"{name} has no instances", hint)
        return Signal(name, "", field)
    if not instance:
        hint = f"say which one by its name: {name}[target].{field}"
        raise _error(match, "message", f"{name} comes in instances", hint)
    if not instance.isascii() or len(instance) > sizes["name"]:
        hint = f"MAVLink carries {sizes['name']} ASCII characters"
        raise _error(match, "instance", f"{instance} cannot be a name of {name}", hint)
    return Signal(name, instance, field)


def _error(match: re.Match[str], group: str, what: str, hint: str) -> FormulaError:
    start, end = match.span(group)
    return FormulaError(what, match.string, start, max(1, end - start), hint)
