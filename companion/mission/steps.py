"""The steps of skills as values: primitives, and other skills. `model.py` hands them on.

Those that payloads do are in payload_steps.py, calls of functions in python_call.py.
"""

from __future__ import annotations

from dataclasses import dataclass

from companion.mission.payload_steps import Photo, PointGimbal
from companion.mission.python_call import PythonCall


@dataclass(frozen=True, slots=True)
class Fly:
    """Primitive: fly to the place bound to the parameter `place`."""

    place: str


@dataclass(frozen=True, slots=True)
class Command:
    """Primitive: send a MAVLink command to a component and wait for its final answer.

    Attributes:
        component: MAVLink component id.
        command: MAV_CMD number.
        name: how the mission file wrote the command, e.g. MAV_CMD_USER_1.
        parameters: param1..param7.
    """

    component: int
    command: int
    name: str
    parameters: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class Wait:
    """Primitive: hold position for a time."""

    duration_s: float


@dataclass(frozen=True, slots=True)
class Land:
    """Primitive: land where the vehicle is, and disarm."""


@dataclass(frozen=True, slots=True)
class LandOn:
    """Primitive: land on the marker of the place bound to the parameter `place`, and disarm."""

    place: str


@dataclass(frozen=True, slots=True)
class TakeOff:
    """Primitive: arm, climb to the altitude of the place, go on in OFFBOARD."""


@dataclass(frozen=True, slots=True)
class Charge:
    """Primitive: wait on the ground until the battery has so much.

    Attributes:
        percent: None for as much as the plan says.
        called_percent: with so much it ends as soon as the event of a line that is ready comes;
            None where no event ends it.
    """

    percent: float | None
    called_percent: int | None = None


@dataclass(frozen=True, slots=True)
class Do:
    """Another skill, which refines this one; arguments are parameters or constants."""

    skill: str
    arguments: tuple[str, ...]


Primitive = (
    Fly | Command | Photo | PointGimbal | PythonCall | Wait | Land | LandOn | TakeOff | Charge
)
Execution = Primitive | Do
