"""Skills, suggesters and tests of places as functions of installed packages (docs/skills.md).

Their authors import this module. The import is fast and loads nothing else of the companion.
"""

from companion.skills.authoring import Cancelled, place_test, skill, suggester
from companion.skills.authoring import FunctionRun as Run
from companion.skills.authoring import KnownPlace as Place
from companion.skills.authoring import KnownVehicle as Vehicle
from companion.skills.authoring import SkillFailure as Failed
from companion.skills.authoring import WaypointEnu as Waypoint

__all__ = [
    "Cancelled",
    "Failed",
    "Place",
    "Run",
    "Vehicle",
    "Waypoint",
    "place_test",
    "skill",
    "suggester",
]
