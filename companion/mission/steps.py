"""The steps of skills as values: primitives, and calls of other skills.

Steps that use payloads are in payload_steps.py, calls of functions in python_call.py.
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
    """Primitive: arm, climb to the altitude of the place, and continue in OFFBOARD."""


@dataclass(frozen=True, slots=True)
class Charge:
    """Primitive: wait on the ground until the battery has reached a level.

    Attributes:
        percent: the level; None for the one that the plan says.
        called_percent: at or above this level, the event of a ready line ends the charge; None if
            no event does.
    """

    percent: float | None
    called_percent: int | None = None


@dataclass(frozen=True, slots=True)
class Do:
    """Calls another skill, which refines this one; arguments are parameters or constants."""

    skill: str
    arguments: tuple[str, ...]


Primitive = (
    Fly | Command | Photo | PointGimbal | PythonCall | Wait | Land | LandOn | TakeOff | Charge
)
Execution = Primitive | Do
