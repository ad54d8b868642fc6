"""Reads the steps of a skill's `execute`: what it does to the vehicle and its payloads.

fly(parameter)    wait(seconds)    land()    land_on(parameter)    take_off()
charge(percent or auto)
command(component, MAV_CMD_NAME[, param1, ... param7])    photo(camera)
gimbal(component, pitch_deg, yaw_deg)    grip(component)    release(component)
python(name, arguments), a function of an installed package    another skill with its arguments
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping
from functools import partial
from math import radians
from typing import NamedTuple

from companion.documents import did_you_mean
from companion.documents.units import number_in_unit, unit_called
from companion.errors import FormulaError
from companion.mavlink.framing import dialect
from companion.mavlink.payload_commands import AUTOPILOT, commands_for, why_not_sent
from companion.mission.calls import WrittenArgument, WrittenCall, read_call
from companion.mission.mavlink_names import command_number
from companion.mission.payload_steps import Photo, PointGimbal
from companion.mission.python_call import FORM as PYTHON_FORM
from companion.mission.python_call import MAX_ARGUMENTS, PYTHON, PythonCall, python_call
from companion.mission.steps import Charge, Command, Do, Execution, Fly, Land, LandOn, TakeOff, Wait
from companion.skills.authoring import FLOAT32_MAX


class _Known(NamedTuple):
    """The names that a step may use.

    Attributes:
        parameters: names of the skill's parameters.
        components: name -> MAVLink component id.
    """

    parameters: Collection[str]
    components: Mapping[str, int]


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
    call = read_call(text, "not something to execute", FORMS)
    if call.name in skills:
        call.refuse_names(f"{call.name}(argument, ...)")
        return Do(str(call.name), call.words)
    kind = KINDS.get(call.name)
    if kind is None:
        raise _unknown(call, skills)
    if not kind.fewest <= len(call.arguments) <= kind.most:
        what = f"{call.name} has {len(call.arguments)} arguments"
        raise call.error(call.name, what, f"write {kind.form}")
    if call.name != PYTHON:
        call.refuse_names(kind.form)
    return kind.read(call, _Known(parameters, components))


def _unknown(call: WrittenCall, skills: Collection[str]) -> FormulaError:
    verb, forms = call.name.lower(), ", ".join(FORMS.values())
    meant = _NO_STEP.get(verb) or did_you_mean(call.name, [*KINDS, *skills])
    if verb in _ELSEWHERE:
        meant = f"Did you mean {_ELSEWHERE[verb]}?"
    hint = f"{meant} Write {forms}" if meant else f"write {forms}"
    return call.error(call.name, f"unknown primitive {call.name}", hint)


def _fly(call: WrittenCall, known: _Known) -> Fly:
    return Fly(_parameter(call, known))


def _land_on(call: WrittenCall, known: _Known) -> LandOn:
    return LandOn(_parameter(call, known))


def _parameter(call: WrittenCall, known: _Known) -> str:
    """The only argument, which is the name of a parameter of the skill."""
    place, parameters = call.arguments[0].value, known.parameters
    if place not in parameters:
        listing = f"parameters are {', '.join(parameters)}." if parameters else "it has none."
        listing += " A plan says which place a parameter is."
        hint = f"{listing} {did_you_mean(place, parameters)}".rstrip()
        raise call.error(place, f"{place} is not a parameter of this skill", hint)
    return str(place)


def _command(call: WrittenCall, known: _Known) -> Command:
    component, command, *numbers = call.arguments
    addressee = _addressee(component, call, known)
    number = command_number(command.value, call.text)
    if why_not := why_not_sent(addressee, number):
        raise call.error(
            command.value,
            why_not,
            f"to the autopilot skills send {', '.join(sorted(commands_for(addressee)))}"
            if addressee == AUTOPILOT
            else "skills command payloads; fly(), land(), land_on(), take_off() move the vehicle",
        )
    return Command(
        component=addressee,
        command=number,
        name=str(command.value),
        parameters=tuple(_number(argument, call) for argument in numbers),
    )


def _photo(call: WrittenCall, known: _Known) -> Photo:
    (camera,) = call.arguments
    addressee = _addressee(camera, call, known)
    if addressee == AUTOPILOT:
        hint = "a camera is a component of its own, usually 100; one that the autopilot triggers "
        hint += "is commanded by command()"
        raise call.error(camera.value, "the autopilot is not a camera", hint)
    return Photo(addressee, str(camera.value))


def _gimbal(call: WrittenCall, known: _Known) -> PointGimbal:
    component, pitch, yaw = call.arguments
    addressee = _addressee(component, call, known)
    pitch_deg, yaw_deg = _number(pitch, call, "deg"), _number(yaw, call, "deg")
    if not -90 <= pitch_deg <= 90:
        what = "a gimbal looks 90 degrees down to 90 up"
        raise call.error(pitch.value, what, "write e.g. -90 for down")
    if not -180 <= yaw_deg <= 180:
        what = "a gimbal looks 180 degrees to the left or to the right"
        raise call.error(yaw.value, what, "write e.g. 90")
    return PointGimbal(addressee, str(component.value), radians(pitch_deg), radians(yaw_deg))


def _gripper(action: int, call: WrittenCall, known: _Known) -> Command:
    number, name = dialect.MAV_CMD_DO_GRIPPER, "MAV_CMD_DO_GRIPPER"
    addressee = _addressee(call.arguments[0], call, known)
    return Command(addressee, number, name, (1.0, float(action)))


def _addressee(argument: WrittenArgument, call: WrittenCall, known: _Known) -> int:
    """The component id of a name."""
    component, components = argument.value, known.components
    if component not in components:
        hint = (
            f"components are {', '.join(components)}; add others there, {{NAME: ID}}. "
            f"{did_you_mean(component, components)}"
            if components
            else f"add components: {{{component}: 100}}, with its MAVLink component id"
        ).rstrip()
        raise call.error(component, f"unknown component {component}", hint)
    return components[component]


def _wait(call: WrittenCall, _: _Known) -> Wait:
    (argument,) = call.arguments
    seconds = _number(argument, call, "s")
    if seconds < 0:
        what = "a time cannot be negative"
        raise call.error(argument.value, what, "write seconds, 0 or more")
    return Wait(seconds)


def _charge(call: WrittenCall, _: _Known) -> Charge:
    (argument,) = call.arguments
    if argument.value == AUTO:
        return Charge(None)
    percent = _number(argument, call, "%")
    if not 0 < percent <= 100:
        raise call.error(argument.value, "a battery has 0 to 100 percent", "write e.g. 90")
    if percent < 1:
        what = f"{percent:g} is a share"
        raise call.error(argument.value, what, f"write percent: {100 * percent:g}")
    return Charge(percent)


def _number(argument: WrittenArgument, call: WrittenCall, unit: str = "") -> float:
    """The number that an argument is.

    Args:
        unit: what it is a number of; it is not written.
    """
    token = argument.value
    number = float(token) if token.type in ("INTEGER", "DECIMAL") else math.nan
    if not abs(number) <= FLOAT32_MAX:  # not a number compares as false
        hint = "write e.g. 1.5"
        if token.type == "QUANTITY":
            written = token.lstrip("+-.0123456789").strip()
            digits = token.removesuffix(written).strip()
            hint = number_in_unit(digits, written, unit_called(unit))
        raise call.error(token, f"{token} is not a number", hint)
    return number


def _python(call: WrittenCall, known: _Known) -> PythonCall:
    return python_call(call, known.components)


AUTO = "auto"
"""The argument of `charge` that leaves the percentage to the plan."""


class StepKind(NamedTuple):
    """A kind of step.

    Attributes:
        form: how the step is written.
        fewest, most: limits of the number of arguments.
        read: makes the step from its call.
    """

    form: str
    fewest: int
    most: int
    read: Callable[[WrittenCall, _Known], Execution]


KINDS = {
    "fly": StepKind("fly(parameter)", 1, 1, _fly),
    "command": StepKind("command(component, MAV_CMD_NAME, param1, ... param7)", 2, 9, _command),
    "photo": StepKind("photo(camera)", 1, 1, _photo),
    "gimbal": StepKind("gimbal(component, pitch_deg, yaw_deg)", 3, 3, _gimbal),
    "grip": StepKind("grip(component)", 1, 1, partial(_gripper, dialect.GRIPPER_ACTION_GRAB)),
    "release": StepKind(
        "release(component)", 1, 1, partial(_gripper, dialect.GRIPPER_ACTION_RELEASE)
    ),
    "wait": StepKind("wait(seconds)", 1, 1, _wait),
    "land": StepKind("land()", 0, 0, lambda *_: Land()),
    "land_on": StepKind("land_on(parameter)", 1, 1, _land_on),
    "charge": StepKind("charge(percent or auto)", 1, 1, _charge),
    "take_off": StepKind("take_off()", 0, 0, lambda *_: TakeOff()),
    PYTHON: StepKind(PYTHON_FORM, 1, MAX_ARGUMENTS, _python),
}
"""All kinds of steps, by name."""

FORMS = {name: kind.form for name, kind in KINDS.items()}
"""How each kind of step is written, by name."""

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
