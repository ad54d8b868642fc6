"""The steps of a skill's `execute`: what it does to the vehicle and its payloads.

fly(parameter)    command(component, MAV_CMD_NAME[, param1, ... param7])    wait(seconds)
land()    charge(percent)    take_off()    another skill with its arguments
"""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass

from companion.documents import did_you_mean
from companion.errors import FormulaError
from companion.mavlink.payload_commands import AUTOPILOT, commands_for, why_not_sent
from companion.mission.conditions import command_number
from companion.mission.model import Charge, Command, Do, Execution, Fly, Land, TakeOff, Wait

FLOAT32_MAX = 3.4028234e38  # MAVLink carries command parameters as IEEE 754 single precision
FORMS = {
    "fly": "fly(parameter)",
    "command": "command(component, MAV_CMD_NAME, param1, ... param7)",
    "wait": "wait(seconds)",
    "land": "land()",
    "charge": "charge(percent)",
    "take_off": "take_off()",
}
"""What `execute` may be."""

_COUNTS = {
    "fly": (1, 1),
    "command": (2, 9),
    "wait": (1, 1),
    "land": (0, 0),
    "charge": (1, 1),
    "take_off": (0, 0),
}
"""Fewest and most arguments."""

_CALL = re.compile(r"\s*(?P<verb>\w+)\s*\((?P<arguments>[^()]*)\)\s*", re.ASCII)


@dataclass(frozen=True, slots=True)
class _Argument:
    """One argument and the text that it stands in."""

    word: str
    offset: int
    text: str

    def error(self, what: str, hint: str) -> FormulaError:
        return FormulaError(what, self.text, self.offset, max(1, len(self.word)), hint)


def parse_execution(
    text: str,
    parameters: Collection[str],
    components: Mapping[str, int],
    skills: Collection[str] = (),
) -> Execution:
    """Reads a step: a primitive, or another skill, whose arguments are not checked here.

    Args:
        text: e.g. `fly(to)`.
        parameters: names of the skill's parameters.
        components: name -> MAVLink component id.
        skills: names of skills that may be called.

    Raises:
        FormulaError: unknown primitive, parameter, component or command, a wrong number, or a
            command that no skill may send to the component (`mavlink/payload_commands.py`).
    """
    match = _CALL.fullmatch(text)
    forms = ", ".join(FORMS.values())
    if match is None:
        raise FormulaError("not something to execute", text, 0, len(text), f"write {forms}")
    verb = match["verb"]
    arguments = list(_arguments(match))
    if verb in skills:
        return Do(verb, tuple(argument.word for argument in arguments))
    if verb not in FORMS:
        hint = f"write {forms}. {did_you_mean(verb, [*FORMS, *skills])}".rstrip()
        raise FormulaError(f"unknown primitive {verb}", text, match.start("verb"), len(verb), hint)
    least, most = _COUNTS[verb]
    if not least <= len(arguments) <= most:
        what = f"{verb} has {len(arguments)} arguments"
        raise FormulaError(what, text, match.start("verb"), len(verb), f"write {FORMS[verb]}")
    if verb == "fly":
        return _fly(arguments[0], parameters)
    if verb == "wait":
        return Wait(_duration_s(arguments[0]))
    if verb == "charge":
        return Charge(_percent(arguments[0]))
    if verb in ("land", "take_off"):
        return Land() if verb == "land" else TakeOff()
    return _command(arguments, components)


def _arguments(match: re.Match[str]) -> Iterator[_Argument]:
    offset = match.start("arguments")
    if not match["arguments"].strip():
        return
    for part in match["arguments"].split(","):
        leading = len(part) - len(part.lstrip())
        yield _Argument(part.strip(), offset + leading, match.string)
        offset += len(part) + 1


def _fly(place: _Argument, parameters: Collection[str]) -> Fly:
    if place.word not in parameters:
        listing = f"parameters are {', '.join(parameters)}." if parameters else "it has none."
        hint = f"{listing} {did_you_mean(place.word, parameters)}".rstrip()
        raise place.error(f"{place.word} is not a parameter of this skill", hint)
    return Fly(place.word)


def _command(arguments: list[_Argument], components: Mapping[str, int]) -> Command:
    component, command, *numbers = arguments
    if component.word not in components:
        listing = ", ".join(components) or "none yet"
        hint = f"components are {listing}. {did_you_mean(component.word, components)}".rstrip()
        raise component.error(f"unknown component {component.word}", hint)
    addressee = components[component.word]
    number = command_number(command.word, command.text, command.offset)
    if why_not := why_not_sent(addressee, number):
        raise command.error(
            why_not,
            f"to the autopilot skills send {', '.join(sorted(commands_for(addressee)))}"
            if addressee == AUTOPILOT
            else "skills command payloads; the vehicle is flown by fly(), land() and take_off()",
        )
    return Command(
        component=addressee,
        command=number,
        name=command.word,
        parameters=tuple(_number(argument) for argument in numbers),
    )


def _duration_s(argument: _Argument) -> float:
    seconds = _number(argument)
    if seconds < 0:
        raise argument.error("a time cannot be negative", "write seconds, 0 or more")
    return seconds


def _percent(argument: _Argument) -> float:
    percent = _number(argument)
    if not 0 < percent <= 100:
        raise argument.error("a battery has 0 to 100 percent", "write e.g. 90")
    return percent


def _number(argument: _Argument) -> float:
    try:
        number = float(argument.word)
    except ValueError:
        number = math.nan
    if not abs(number) <= FLOAT32_MAX:  # not a number compares as false
        raise argument.error(f"{argument.word or 'nothing'} is not a number", "write e.g. 1.5")
    return number
