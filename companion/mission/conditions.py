"""Reads conditions on MAVLink fields and detectors' reports: the `when` and `until` of events.

    MESSAGE.field OP NUMBER              BATTERY_STATUS.battery_remaining < 30
    MESSAGE[instance].field OP NUMBER    NAMED_VALUE_INT[target].value > 0
    COMMAND.MAV_CMD_NAME                 a command sent to the companion; short for `... != 0`
    EVENT[name] OP NUMBER                EVENT[persons] > 0, as another program reports it
    ... is silent                        EVENT[persons] is silent: not heard for `stale_s`

OP is one of < <= > >= == !=. The grammar is in `conditions.lark`; messages, fields and commands
are MAVLink's own (mavlink_names.py). Only messages with a field `name` have instances. Reports may
have any name; they arrive by `--events`.
"""

from __future__ import annotations

from typing import NamedTuple

from lark import Token, Transformer, v_args

from companion.documents.units import number_in_unit, unit_called
from companion.errors import FormulaError
from companion.grammars import END, Grammar, Misfit, error_at
from companion.mission.mavlink_names import (
    PREFIX,
    command_number,
    field_signal,
    has_instances,
    unit_of,
)
from companion.mission.signals import (
    COMMAND,
    REPORT,
    AnyCondition,
    Condition,
    Signal,
    Silence,
)

PERCENT = range(-1, 101)
"""The values of a field in per cent; -1 means unknown."""
MAX_REPORT_NAME = 63  # characters
_FORMS = (
    "write MESSAGE.field > NUMBER, MESSAGE[name].field > NUMBER, EVENT[name] > NUMBER"
    " or COMMAND.MAV_CMD_NAME"
)


class _WrittenSignal(NamedTuple):
    """A signal as it is written; a report has no field."""

    message: Token
    instance: Token | None
    field: Token | None


class _Alone(NamedTuple):
    """`SIGNAL`."""

    signal: _WrittenSignal


class _Compared(NamedTuple):
    """`SIGNAL OP NUMBER`."""

    signal: _WrittenSignal
    comparison: Token
    threshold: Token


class _Silent(NamedTuple):
    """`SIGNAL is silent`."""

    signal: _WrittenSignal
    words: Token


_Written = _Alone | _Compared | _Silent
"""A condition as it is written."""


@v_args(inline=True)
class _ConditionBuilder(Transformer[Token, _Written]):
    alone, compared, silent = _Alone, _Compared, _Silent

    def field(self, message: Token, *rest: Token) -> _WrittenSignal:
        *instance, field = rest
        return _WrittenSignal(message, instance[0] if instance else None, field)

    def instance(self, message: Token, instance: Token) -> _WrittenSignal:
        return _WrittenSignal(message, instance, None)


_CONDITIONS = Grammar(
    "condition", "conditions.lark", __file__, _ConditionBuilder(), ["condition", "mistake"]
)


def parse_condition(text: str) -> AnyCondition:
    """Reads a condition.

    >>> print(parse_condition("COMMAND.MAV_CMD_USER_1"), parse_condition("EVENT[persons]>0"))
    COMMAND.MAV_CMD_USER_1 EVENT[persons] > 0

    Raises:
        FormulaError: it is no condition, or names something that `common` does not have.
    """
    written = _CONDITIONS.read(text)
    if isinstance(written, Misfit):
        raise _explained(written, text)
    signal = _signal(written.signal, text)
    match written:
        case _Compared(_, comparison, threshold):
            condition = Condition(signal, str(comparison), float(threshold))
            _demand_change(condition, threshold, text)
            return condition
        case _Silent(_, words):
            if signal.is_pulse:
                raise error_at(words, "a command is silent but for a moment", "remove it", text)
            return Silence(signal)
    if signal.is_pulse:
        return Condition(signal, "!=", 0.0)
    what, end = f"{text.strip()} is compared with nothing", len(text.rstrip())
    raise FormulaError(what, text, end, hint="add a comparison, e.g. > 0")


def _signal(written: _WrittenSignal, text: str) -> Signal:
    message, instance, field = written
    if field is None:
        assert instance is not None
        return _report(message, instance, text)
    if message != COMMAND:
        return field_signal(message, instance, field, text)
    if instance is not None:
        raise error_at(instance, "a command has no instance", "write COMMAND.MAV_CMD_NAME", text)
    command_number(field, text)
    return Signal(COMMAND, "", str(field))


def _report(message: Token, name: Token, text: str) -> Signal:
    if message != REPORT:
        hint = f"write {message}[{name}].value" if has_instances(message) else _FORMS
        raise error_at(message, "not a condition", hint, text)
    is_name = name.isascii() and name.isidentifier() and len(name) <= MAX_REPORT_NAME
    if not is_name:
        what = f"{name} cannot be the name of a report"
        raise error_at(name, what, "write EVENT[name] > NUMBER, the name as for an event", text)
    return Signal(REPORT, str(name), "")


def _demand_change(condition: Condition, threshold: Token, text: str) -> None:
    """Refuses a comparison of a percentage that is always true, or never."""
    if unit_of(condition.signal.message, condition.signal.field) != unit_called("%"):
        return
    if 0 < condition.threshold < 1 and condition.comparison not in ("==", "!="):
        hint = f"write percent: {100 * condition.threshold:g}"
        raise error_at(threshold, f"{condition.threshold:g} is a share", hint, text)
    truths = set(map(condition.is_met_by, PERCENT))
    if len(truths) == 1:
        what = f"this is {'always' if truths.pop() else 'never'} so"
        hint = "a percentage is 0 to 100, or -1 while it is not known"
        raise error_at(threshold, what, hint, text)


_ADVICE = {
    "EQUALS": "write ==",
    "JOIN": "an event has one condition: make an event of each, and join them in the task",
    "TRUTH": "compare with a number: > 0 for true, == 0 for false",
}
"""What to write instead, by the kind of token that does not fit."""


def _explained(misfit: Misfit, text: str) -> FormulaError:
    """Why a text is no condition."""
    offset, length = misfit.offset, max(1, len(misfit.word))
    hint = _ADVICE.get(misfit.kind, _FORMS)
    if text.strip().startswith(PREFIX):
        offset, hint = 0, f"write {COMMAND}.{text.strip()}"
    elif "INSTANCE" in misfit.expected:
        hint = "the name of an instance stands in the brackets, e.g. NAMED_VALUE_INT[target].value"
    elif misfit.kind == "NAME" and "NUMBER" in misfit.expected:
        hint = "compare with a NUMBER: names of values are not known here"
    elif misfit.kind in ("NAME", "UNIT") and misfit.expected == {END}:
        hint = _without_unit(text[:offset], text[offset:].strip())
    return FormulaError("not a condition", text, offset, length, hint)


def _without_unit(condition: str, unit: str) -> str:
    """What to write instead of a condition that is followed by a unit."""
    written = _CONDITIONS.read(condition)
    if not isinstance(written, _Compared):
        return _FORMS
    message, _, field = written.signal
    wanted = unit_of(message, field) if field else None
    if wanted:
        return number_in_unit(written.threshold, unit, wanted)
    return f"write the number alone, without {unit}"
