"""The model of a mission file's YAML, key by key.

This is the written form, in people's units (east, north, up; seconds). loader.py makes the checked
`Mission` of model.py from it. The descriptions are written for the author of a mission: they become
the JSON Schema (missions/mission.schema.json, by scripts/make_schema.py) from which editors
complete, and the hints of error messages. Limits and places are in world_schema.py, drawn maps in
companion/drawn_maps.py.

Texts with a syntax of their own are not parsed here: formulas and facts (companion/ltl/formula.py),
conditions (conditions.py), `execute` (execution.py).
"""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, ConfigDict, Field

from companion.drawn_maps import DrawnModel, MapEntry
from companion.mission.battery_schema import BatteryEntry
from companion.mission.keys import DAY_S, Name, Text, given
from companion.mission.line_entry import TaskKey
from companion.mission.otherwise import PATIENCE_S
from companion.mission.skill_schema import SkillEntry
from companion.mission.world_schema import LandAtEntry, LimitsEntry, PlaceEntry
from companion.vehicle_files import VehicleEntry, VehicleKey

PATIENCE = "If there is no plan now, but may be one later: seconds to hold before `otherwise`."


class EventEntry(DrawnModel):
    """A fact that the vehicle observes and cannot choose."""

    when: Annotated[
        Text,
        Field(
            description="Condition that makes the fact true, e.g. "
            "NAMED_VALUE_INT[target].value > 0, EVENT[persons] > 0 (another program's report), "
            "EVENT[persons] is silent, or COMMAND.MAV_CMD_USER_1. A command is true at the moment "
            "when it comes; the task sees it at the next position."
        ),
    ]
    until: Annotated[
        Text | None,
        BeforeValidator(given, json_schema_input_type=Text),
        Field(
            description="Condition that makes the fact false again; without this key, the "
            "fact is false when `when` is."
        ),
    ] = None
    latch: Annotated[bool, Field(description="true: once true, the fact stays true for ever.")] = (
        False
    )
    for_s: Annotated[
        float,
        Field(
            ge=0,
            le=DAY_S,
            description="Seconds for which a condition must hold before it counts; a command "
            "counts at once.",
        ),
    ] = 0.0
    stale_s: Annotated[
        float | None,
        BeforeValidator(given, json_schema_input_type=float),
        Field(
            gt=0,
            le=DAY_S,
            description="If the message is not heard for so many seconds, the fact keeps its "
            "value, the companion reports this, and `is silent` is true.",
        ),
    ] = None
    restarts: Annotated[
        list[Name],
        Field(
            description="Lines of the task that begin anew when the fact becomes true: their "
            "earlier demands are dropped."
        ),
    ] = []
    restores: Annotated[
        list[Name],
        Field(
            description="Beliefs that are restored when the fact becomes true, by the name of "
            "their predicate, e.g. [canUpload]. With it, an operator can give a skill "
            "another chance."
        ),
    ] = []


class MissionFile(DrawnModel):
    """A mission says what must hold, not where to fly next."""

    model_config = ConfigDict(title="Mission")

    version: Annotated[Literal[1], Field(description="Version of this format: 1.")]
    name: Annotated[
        str,
        Field(
            pattern=r"^[A-Za-z0-9][A-Za-z0-9_-]*$",
            max_length=40,
            description="Letters, digits, - and _; names the folder of each run.",
        ),
    ]
    frame: Annotated[
        Literal["enu", "wgs84"],
        Field(
            description="The meaning of coordinates. enu: metres east, north and up of home. "
            "wgs84: places have lat_deg, lon_deg and either up_m or amsl_m, corners are "
            "[lat, lon]; a map stays in metres, from the place where the mission "
            "begins."
        ),
    ] = "enu"
    map: Annotated[
        Text | MapEntry | None,
        BeforeValidator(given, json_schema_input_type=Text | MapEntry),
        Field(
            description="What the companion knows of the world before the flight: a map file "
            "(ROS map_server YAML), relative to this file, or an area with walls: "
            "{east_m: [-2, 12], north_m: [-2, 12], walls: [{east_m: [4, 5], north_m: "
            "[0, 6]}]}. Without it, an open field: the area of the fence."
        ),
    ] = None
    vehicle: VehicleKey = VehicleEntry()
    limits: Annotated[
        LimitsEntry,
        Field(description="The speed limit, altitude band and fence that all setpoints keep."),
    ]
    battery: Annotated[
        BatteryEntry | None,
        BeforeValidator(given, json_schema_input_type=BatteryEntry),
        Field(
            description="{reserve: 20}: plans keep enough energy to land at a safe place at any "
            "time, and skills may charge. Without this key, plans do not consider "
            "energy."
        ),
    ] = None
    places: Annotated[
        dict[Name, PlaceEntry],
        Field(
            min_length=1,
            description="Name: {east_m, north_m, up_m, radius_m}; with frame: wgs84 {lat_deg, "
            "lon_deg, up_m or amsl_m, radius_m}.",
        ),
    ]
    objects: Annotated[
        list[Name],
        Field(
            description="Names of things that are not places, e.g. [p1, p2] for two parcels. "
            "Facts may contain them, e.g. delivered(p1); the vehicle cannot be at them."
        ),
    ] = []
    sets: Annotated[
        dict[Name, Annotated[list[Name], Field(min_length=1)]],
        Field(
            description="Name: [members]; the values of parameters of skills. Members are "
            "places or objects."
        ),
    ] = {}
    domain: Annotated[
        Text | None,
        BeforeValidator(given, json_schema_input_type=Text),
        Field(
            description="PDDL domain file, relative to this file. Its actions become skills, "
            "its types become sets, and its predicate at(place) says where the vehicle "
            "is. Under skills, each action needs what it does in the world: execute, "
            "and if necessary assumes, cost, tries, timeout_s. In names, upper case is "
            "as in this file, and - becomes _."
        ),
    ] = None
    problem: Annotated[
        Text | None,
        BeforeValidator(given, json_schema_input_type=Text),
        Field(
            description="PDDL problem file, relative to this file: objects (an object with the "
            "name of a place is that place), facts that hold at the start, and the "
            "goal, if this file has neither goal nor task."
        ),
    ] = None
    components: Annotated[
        dict[Name, Annotated[int, Field(ge=1, le=255)]],
        Field(description="Name: MAVLink component id (1 to 255) to which commands are sent."),
    ] = {}
    events: Annotated[
        dict[Name, EventEntry],
        Field(description="Name of a fact: the condition on MAVLink messages that sets it."),
    ] = {}
    skills: Annotated[
        dict[Name, SkillEntry],
        Field(min_length=1, description="Name: what the vehicle can do."),
    ]
    initially: Annotated[
        list[Text],
        Field(
            description="Facts that hold at the start, with the place of the vehicle, e.g. "
            "[at(Home)]. All other facts are false, except beliefs.",
        ),
    ] = []
    task: TaskKey = {}
    ready: Annotated[
        list[Name],
        Field(
            description="Lines of the task, such as G (alarm -> F[<=90s] at(X)), that shall "
            "hold whenever the event comes: the vehicle always stays near enough to X "
            "to reach it in time, and keeps the charge for that."
        ),
    ] = []
    goal: Annotated[
        Text | None,
        BeforeValidator(given, json_schema_input_type=Text),
        Field(
            description="Facts that have to hold together once, joined by &, ! for not, e.g. "
            "delivered(p1) & delivered(p2): a task without temporal logic. If there is "
            "also a task, both must be fulfilled."
        ),
    ] = None
    tree: Annotated[
        list[Any] | None,
        BeforeValidator(given, json_schema_input_type=list[Any]),
        Field(
            min_length=1,
            description="A behaviour tree written by hand, instead of a planner. It is a list "
            "of actions such as move(Home, A) (or move(*, A), from wherever the vehicle "
            "is), of facts to check, of wait(seconds), and of {fallback: [...]}, "
            "{parallel: [...]}, {inverter: [...]}, {repeat: [...], times: n}, {retry: "
            "[...], times: n}, {timeout: [...], duration_s: s}, {watch: FACTS, do: "
            "[...]}, {subtree: NAME}.",
        ),
    ] = None
    subtrees: Annotated[
        dict[Name, list[Any]],
        Field(description="Name: a list of nodes, which the tree uses as {subtree: NAME}."),
    ] = {}
    otherwise: Annotated[
        Literal["return_home", "land", "hold"] | LandAtEntry,
        Field(
            description="What to do when no plan exists: return_home, land, hold, or "
            "{land_at: [places]}."
        ),
    ] = "return_home"
    patience_s: Annotated[float, Field(ge=0, le=3600, description=PATIENCE)] = PATIENCE_S


def json_schema() -> dict[str, Any]:
    """Returns the JSON Schema (draft 2020-12) of a mission file."""
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        **MissionFile.model_json_schema(),
        "anyOf": [{"required": [key]} for key in ("task", "goal", "problem", "tree")],
    }
