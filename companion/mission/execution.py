"""Reads the steps of a skill's `execute`: what it does to the vehicle and its payloads.

fly(parameter)    wait(seconds)    land()    land_on(parameter)    take_off()
charge(percent or auto)
command(component, MAV_CMD_NAME[, param1, ... param7])    photo(camera)
gimbal(component, pitch_deg, yaw_deg)    grip(component)    release(component)
python(name, arguments), a function of an installed package    another skill with its arguments
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from math import radians
from typing import NamedTuple

from companion.documents import did_you_mean
from companion.errors import FormulaError
from companion.mavlink.framing import dialect
from companion.mavlink.payload_commands import AUTOPILOT, commands_for, why_not_sent
from companion.mission.conditions import command_number
from companion.mission.model import Charge, Command, Do, Execution, Fly, Land, LandOn, TakeOff, Wait
from companion.mission.payload_steps import Photo, PointGimbal
from companion.mission.python_call import FORM as PYTHON
from companion.mission.python_call import MAX_ARGUMENTS, PythonCall, parse_python
from companion.skills.authoring import FLOAT32_MAX

_CALL = re.compile(
    r"""\s*(?P<verb>\w+)\s*\((?P<arguments>(?:[^()"']|"[^"]*"|'[^']*')*)\)\s*""", re.ASCII
)


class _Known(NamedTuple):
    """The names that a step may use.

    Attributes:
        parameters: names of the skill's parameters.
        components: name -> MAVLink component id.
    """

    parameters: Collection[str]
    components: Mapping[str, int]


@dataclass(frozen=True, slots=True)
class _Argument:
    """One argument, and the text that it is part of."""

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
    """Reads a step: a primitive or a call of another skill, whose arguments are checked elsewhere.

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
    forms = ", ".join(kind.form for kind in KINDS.values())
    if match is None:
        hint = f"write {KINDS[text.strip()].form}" if text.strip() in KINDS else f"write {forms}"
        if text.count("(") > text.count(")"):
            kind = KINDS.get(text.partition("(")[0].strip())
            meant = f'"{kind.form}"' if kind is not None else forms
            hint = f"its parenthesis is not closed; inside {{ }} and [ ] put quotes around {meant}"
        elif text.count("(") > 1:
            hint = f"write a list: [{text}]"
        raise FormulaError("not something to execute", text, 0, len(text), hint)
    verb = match["verb"]
    arguments = list(_arguments(match))
    if verb in skills:
        return Do(verb, tuple(argument.word for argument in arguments))
    kind = KINDS.get(verb)
    if kind is None:
        ours = _ELSEWHERE.get(verb.lower(), "")
        meant = f"Did you mean {ours}?" if ours else did_you_mean(verb, [*KINDS, *skills])
        if verb.lower() in _NO_STEP:
            meant = _NO_STEP[verb.lower()]
        hint = f"{meant} Write {forms}".lstrip() if meant else f"write {forms}"
        raise FormulaError(f"unknown primitive {verb}", text, match.start("verb"), len(verb), hint)
    if not kind.fewest <= len(arguments) <= kind.most:
        what = f"{verb} has {len(arguments)} arguments"
        raise FormulaError(what, text, match.start("verb"), len(verb), f"write {kind.form}")
    return kind.read(arguments, _Known(parameters, components))


def _arguments(match: re.Match[str]) -> Iterator[_Argument]:
    offset = match.start("arguments")
    if not match["arguments"].strip():
        return
    for part in match["arguments"].split(","):
        leading = len(part) - len(part.lstrip())
        yield _Argument(part.strip(), offset + leading, match.string)
        offset += len(part) + 1


def _fly(arguments: list[_Argument], known: _Known) -> Fly:
    return Fly(_parameter(arguments[0], known))


def _parameter(place: _Argument, known: _Known) -> str:
    """The name of a parameter of the skill."""
    parameters = known.parameters
    if place.word not in parameters:
        listing = f"parameters are {', '.join(parameters)}." if parameters else "it has none."
        listing += " A plan says which place a parameter is."
        hint = f"{listing} {did_you_mean(place.word, parameters)}".rstrip()
        raise place.error(f"{place.word} is not a parameter of this skill", hint)
    return place.word


def _command(arguments: list[_Argument], known: _Known) -> Command:
    component, command, *numbers = arguments
    addressee = _addressee(component, known)
    number = command_number(command.word, command.text, command.offset)
    if why_not := why_not_sent(addressee, number):
        raise command.error(
            why_not,
            f"to the autopilot skills send {', '.join(sorted(commands_for(addressee)))}"
            if addressee == AUTOPILOT
            else "skills command payloads; fly(), land(), land_on(), take_off() move the vehicle",
        )
    return Command(
        component=addressee,
        command=number,
        name=command.word,
        parameters=tuple(_number(argument) for argument in numbers),
    )


def _photo(arguments: list[_Argument], known: _Known) -> Photo:
    (camera,) = arguments
    addressee = _addressee(camera, known)
    if addressee == AUTOPILOT:
        hint = "a camera is a component of its own, usually 100; one that the autopilot triggers "
        raise camera.error("the autopilot is no camera", hint + "is commanded by command()")
    return Photo(addressee, camera.word)


def _gimbal(arguments: list[_Argument], known: _Known) -> PointGimbal:
    component, pitch, yaw = arguments
    addressee, pitch_deg, yaw_deg = _addressee(component, known), _number(pitch), _number(yaw)
    if not -90 <= pitch_deg <= 90:
        raise pitch.error("a gimbal looks 90 degrees down to 90 up", "write e.g. -90 for down")
    if not -180 <= yaw_deg <= 180:
        raise yaw.error("a gimbal looks 180 degrees to the left or to the right", "write e.g. 90")
    return PointGimbal(addressee, component.word, radians(pitch_deg), radians(yaw_deg))


def _gripper(action: int, arguments: list[_Argument], known: _Known) -> Command:
    number, name = dialect.MAV_CMD_DO_GRIPPER, "MAV_CMD_DO_GRIPPER"
    return Command(_addressee(arguments[0], known), number, name, (1.0, float(action)))


def _python(arguments: list[_Argument], known: _Known) -> PythonCall:
    """Reads the whole step again, because its texts may contain commas."""
    return parse_python(arguments[0].text, known.components)


def _addressee(component: _Argument, known: _Known) -> int:
    """The component id of a name."""
    components = known.components
    if component.word not in components:
        hint = (
            f"components are {', '.join(components)}; add others there, {{NAME: ID}}. "
            f"{did_you_mean(component.word, components)}"
            if components
            else f"add components: {{{component.word}: 100}}, with its MAVLink component id"
        ).rstrip()
        raise component.error(f"unknown component {component.word}", hint)
    return components[component.word]


def _duration_s(argument: _Argument) -> float:
    seconds = _number(argument)
    if seconds < 0:
        raise argument.error("a time cannot be negative", "write seconds, 0 or more")
    return seconds


def _charge(argument: _Argument) -> Charge:
    return Charge(None if argument.word == AUTO else _percent(argument))


def _percent(argument: _Argument) -> float:
    percent = _number(argument)
    if not 0 < percent <= 100:
        raise argument.error("a battery has 0 to 100 percent", "write e.g. 90")
    if percent < 1:
        raise argument.error(f"{percent:g} is a share", f"write percent: {100 * percent:g}")
    return percent


def _number(argument: _Argument) -> float:
    try:
        number = float(argument.word)
    except ValueError:
        number = math.nan
    if not abs(number) <= FLOAT32_MAX:  # not a number compares as false
        raise argument.error(f"{argument.word or 'nothing'} is not a number", "write e.g. 1.5")
    return number


AUTO = "auto"
"""The argument of `charge` that leaves the percentage to the plan."""


class StepKind(NamedTuple):
    """A kind of step.

    Attributes:
        form: how the step is written.
        fewest, most: limits of the number of arguments.
        read: makes the step from its arguments.
    """

    form: str
    fewest: int
    most: int
    read: Callable[[list[_Argument], _Known], Execution]


KINDS = {
    "fly": StepKind("fly(parameter)", 1, 1, _fly),
    "command": StepKind("command(component, MAV_CMD_NAME, param1, ... param7)", 2, 9, _command),
    "photo": StepKind("photo(camera)", 1, 1, _photo),
    "gimbal": StepKind("gimbal(component, pitch_deg, yaw_deg)", 3, 3, _gimbal),
    "grip": StepKind("grip(component)", 1, 1, partial(_gripper, dialect.GRIPPER_ACTION_GRAB)),
    "release": StepKind(
        "release(component)", 1, 1, partial(_gripper, dialect.GRIPPER_ACTION_RELEASE)
    ),
    "wait": StepKind("wait(seconds)", 1, 1, lambda given, _: Wait(_duration_s(given[0]))),
    "land": StepKind("land()", 0, 0, lambda *_: Land()),
    "land_on": StepKind(
        "land_on(parameter)", 1, 1, lambda given, known: LandOn(_parameter(given[0], known))
    ),
    "charge": StepKind("charge(percent or auto)", 1, 1, lambda given, _: _charge(given[0])),
    "take_off": StepKind("take_off()", 0, 0, lambda *_: TakeOff()),
    "python": StepKind(PYTHON, 1, MAX_ARGUMENTS, _python),
}
"""All kinds of steps, by name."""

_ELSEWHERE = {
    **dict.fromkeys(("goto", "go", "go_to", "move", "fly_to", "waypoint"), "fly"),
    **dict.fromkeys(("takeoff", "launch"), "take_off"),
    **dict.fromkeys(("sleep", "delay", "hover", "loiter", "hold"), "wait"),
    **dict.fromkeys(("picture", "image", "take_photo", "take_picture"), "photo"),
}
"""The name of a step in other programs -> its name here."""

_NO_STEP = {
    **dict.fromkeys(
        ("rtl", "return_home", "return_to_launch", "go_home", "home"),
        "The way home is a line of the task: F G at(Home).",
    ),
    **dict.fromkeys(
        ("arm", "disarm"), "The vehicle is armed for the flight, and disarmed after it."
    ),
}
"""Steps of other programs that do not exist here."""
