"""Knows MAVLink's messages, fields and commands by their names, for the texts of a mission.

The names are those of pymavlink's `common` dialect, which the vehicle link speaks.
"""

from __future__ import annotations

from lark import Token
from pymavlink.dialects.v20 import common

from companion.documents import did_you_mean, most_similar
from companion.documents.units import Unit, unit_called
from companion.errors import FormulaError
from companion.grammars import error_at
from companion.mission.signals import COMMAND, REPORT, Signal

COMMANDS: dict[str, int] = {
    entry.name: number
    for number, entry in common.enums["MAV_CMD"].items()
    if entry.name != "MAV_CMD_ENUM_END"
}
"""MAV_CMD name -> number."""
PREFIX = "MAV_CMD_"

_MESSAGES = {message.msgname: message for message in common.mavlink_map.values()}


def command_number(command: Token, text: str) -> int:
    """The number of a MAV_CMD, which a word of a text names.

    Raises:
        FormulaError: there is no such command.
    """
    if command in COMMANDS:
        return COMMANDS[command]
    numbered = [known for known, number in COMMANDS.items() if command == str(number)]
    listed = "MAVLink's common.xml lists them, e.g. MAV_CMD_IMAGE_START_CAPTURE"
    meant = most_similar(command.removeprefix(PREFIX), [c.removeprefix(PREFIX) for c in COMMANDS])
    near = f"Did you mean {PREFIX}{meant}?" if meant else listed
    hint = f"write {numbered[0]}" if numbered else near
    raise error_at(command, f"unknown command {command}", hint, text)


def field_signal(message: Token, instance: Token | None, field: Token, text: str) -> Signal:
    """A field of a message, which the words of a text name.

    Raises:
        FormulaError: there is no such message or field, the field is not one number, or the
            message comes in instances and the text names none.
    """

    def error(token: Token, what: str, hint: str) -> FormulaError:
        return error_at(token, what, hint, text)

    known = _MESSAGES.get(message)
    if known is None:
        hint = (
            "MAVLink's common.xml lists them, e.g. BATTERY_STATUS; uORB topics are not among them"
        )
        if not message.islower():
            hint = did_you_mean(message, [*_MESSAGES, COMMAND]) or hint
        if message == REPORT:
            hint = f"a report is written {REPORT}[{instance or field}]"
        raise error(message, f"unknown MAVLink message {message}", hint)
    sizes = dict(zip(known.ordered_fieldnames, known.array_lengths, strict=True))
    numbers = [name for name in known.fieldnames if sizes[name] == 0]
    if field in sizes and field not in numbers:
        hint = f"fields with one number are {', '.join(numbers)}"
        raise error(field, f"{message}.{field} is not one number", hint)
    if field not in sizes:
        hint = f"fields are {', '.join(numbers)}. {did_you_mean(field, numbers)}".rstrip()
        raise error(field, f"{message} has no field {field}", hint)
    if sizes.get("name", 0) == 0:
        if instance is not None:
            raise error(instance, f"{message} has no instances", f"write {message}.{field}")
        return Signal(str(message), "", str(field))
    if instance is None:
        hint = f"say which one by its name: {message}[target].{field}"
        raise error(message, f"{message} comes in instances", hint)
    if not instance.isascii() or len(instance) > sizes["name"]:
        hint = f"MAVLink carries {sizes['name']} ASCII characters"
        raise error(instance, f"{instance} cannot be a name of {message}", hint)
    return Signal(str(message), str(instance), str(field))


def has_instances(message: str) -> bool:
    """Whether a message has a field `name` that tells its instances apart."""
    known = _MESSAGES.get(message)
    return known is not None and "name" in known.fieldnames


def unit_of(message: str, field: str) -> Unit | None:
    """The unit of a field; None if MAVLink gives none."""
    known = _MESSAGES.get(message)
    units = known.fieldunits_by_name if known is not None else {}
    return unit_called(units.get(field, ""))
