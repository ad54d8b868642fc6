"""The model of a mission file's YAML, key by key.

This is the written form, in people's units (east, north, up; seconds). loader.py makes the
checked `Mission` of model.py from it. The descriptions become the JSON Schema
(missions/mission.schema.json, by scripts/make_schema.py) that editors complete from, and the
hints of error messages; so they are written for the author of a mission. Limits and places are in
world_schema.py, drawn maps in companion/drawn_maps.py.

Small languages inside texts are not parsed here: formulas and facts (companion/ltl/formula.py),
conditions (conditions.py), `execute` (execution.py).
"""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, ConfigDict, Field

from companion.drawn_maps import DrawnModel, MapEntry
from companion.mission.keys import Name, Text, given
from companion.mission.line_entry import TaskKey
from companion.mission.model import PATIENCE_S
from companion.mission.world_schema import LandAtEntry, LimitsEntry, LookAtEntry, PlaceEntry
from companion.vehicle_files import VehicleEntry, VehicleKey

DAY_S = 86_400
"""No time of a mission is longer: what is is written in another unit."""
Duration = Annotated[float, Field(gt=0, le=DAY_S)]
PATIENCE = "Seconds to hold without a plan, where one may come back, before `otherwise`."


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
        Field(description="Condition that makes it false again; without it, not `when`."),
    ] = None
    latch: Annotated[bool, Field(description="Once true, true for ever.")] = False
    for_s: Annotated[
        float,
        Field(
            ge=0,
            le=DAY_S,
            description="Seconds a condition must hold before it counts; a command counts at once.",
        ),
    ] = 0.0
    stale_s: Annotated[
        float | None,
        BeforeValidator(given, json_schema_input_type=float),
        Field(
            gt=0,
            le=DAY_S,
            description="Seconds after which what was not heard is not known: the fact stays as "
            "it was, which is told, and `is silent` is true.",
        ),
    ] = None
    restarts: Annotated[
        list[Name],
        Field(
            description="Lines of the task that begin anew when the fact becomes true: what "
            "they still demanded from before is dropped."
        ),
    ] = []
    restores: Annotated[
        list[Name],
        Field(
            description="Beliefs that are held again when the fact becomes true, by the name of "
            "their predicate, e.g. [canUpload]: how an operator gives a skill another chance."
        ),
    ] = []


def _listed(value: Any) -> Any:
    """Makes a list of a single fact."""
    return [value] if isinstance(value, str) else value


class SkillEntry(DrawnModel):
    """An action template: the planner uses it with every binding of its parameters."""

    parameters: Annotated[
        dict[Name, Name],
        Field(description="Parameter name: the set that it ranges over, e.g. {to: Place}."),
    ] = {}
    distinct: Annotated[
        list[Annotated[list[Name], Field(min_length=2)]],
        Field(
            description="Groups of which no two are the same: parameters, places or objects, e.g. "
            "[[from, to]] or [[to, Home]]."
        ),
    ] = []
    precondition: Annotated[
        Text | None,
        BeforeValidator(given, json_schema_input_type=Text),
        Field(description="Facts joined by &, ! for not, e.g. at(r) & targetFound."),
    ] = None
    assumes: Annotated[
        list[Text],
        BeforeValidator(_listed, json_schema_input_type=Text | list[Text]),
        Field(description="Beliefs: facts taken for true until the skill fails, one or a list."),
    ] = []
    effect: Annotated[
        Text | None,
        BeforeValidator(given, json_schema_input_type=Text),
        Field(
            description="Facts that hold afterwards (! no longer), e.g. at(to) & !at(from). An "
            "effect with a condition stands in parentheses: free & (has(p) & lit -> seen(p)); the "
            "condition is about the facts before. A skill of a PDDL domain has its effect there."
        ),
    ] = None
    cost: Annotated[
        Literal["flight_time"] | float | None,
        BeforeValidator(given, json_schema_input_type=Literal["flight_time"] | float),
        Field(
            description="flight_time (the default of a skill that flies) or seconds "
            "(default of all others: 1)."
        ),
    ] = None
    execute: Annotated[
        list[Text],
        BeforeValidator(_listed, json_schema_input_type=Text | list[Text]),
        Field(
            min_length=1,
            description="What the vehicle does, one thing or a list, one after the other: "
            "fly(parameter), command(component, MAV_CMD_NAME[, param1, ...]), photo(camera), "
            "gimbal(component, pitch_deg, yaw_deg), grip(component), release(component), "
            "wait(seconds), land(), land_on(parameter), charge(percent), take_off(), "
            "python(name, arguments) for a function of an installed package, or another skill "
            "with its arguments.",
        ),
    ]
    planned: Annotated[
        bool,
        Field(description="false: the planner does not use it; it only refines other skills."),
    ] = True
    retry_after_s: Annotated[
        float | None,
        BeforeValidator(given, json_schema_input_type=Duration),
        Field(
            gt=0,
            le=DAY_S,
            description="Seconds after which what the skill assumes is believed again after a "
            "failure; without it not before an event restores it.",
        ),
    ] = None
    repeatable: Annotated[
        bool,
        Field(
            description="true: its commands may be sent, and its functions called, again after "
            "the companion was cut off "
            "while it was done, and nobody knows whether they took effect. Without it, the skill "
            "counts as failed then, and is not done again in this flight."
        ),
    ] = False
    tries: Annotated[
        int,
        Field(
            ge=1,
            le=100,
            description="How often all that the skill executes is tried before it has failed.",
        ),
    ] = 1
    timeout_s: Annotated[
        float | None,
        BeforeValidator(given, json_schema_input_type=Duration),
        Field(gt=0, le=DAY_S, description="Longest time of one try, seconds; without it no limit."),
    ] = None
    confirmed_by: Annotated[
        Text | None,
        BeforeValidator(given, json_schema_input_type=Text),
        Field(
            description="Condition that what is heard after the last step has to meet, or the "
            "skill has failed, e.g. NAMED_VALUE_INT[load].value > 0; within timeout_s, or 10 s."
        ),
    ] = None
    look_at: Annotated[
        Name | LookAtEntry | None,
        BeforeValidator(given, json_schema_input_type=Name | LookAtEntry),
        Field(
            description="What the vehicle looks at meanwhile: a parameter, a place, or a point "
            "{east_m, north_m}; with frame: wgs84 {lat_deg, lon_deg}."
        ),
    ] = None
    gimbal: Annotated[
        Name | None,
        BeforeValidator(given, json_schema_input_type=Name),
        Field(description="Component of a gimbal that looks there too, while the vehicle holds."),
    ] = None


class MissionFile(DrawnModel):
    """A mission: what must hold, not where to fly next."""

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
            description="What coordinates are. enu: metres east, north and up of home. wgs84: "
            "places have lat_deg, lon_deg and either up_m or amsl_m, corners are [lat, lon]; a map "
            "stays in metres, from the place where the mission begins."
        ),
    ] = "enu"
    map: Annotated[
        Text | MapEntry | None,
        BeforeValidator(given, json_schema_input_type=Text | MapEntry),
        Field(
            description="What the vehicle is told of the world beforehand: a map file (ROS "
            "map_server YAML), relative to this file, or an area with walls: {east_m: [-2, 12], "
            "north_m: [-2, 12], walls: [{east_m: [4, 5], north_m: [0, 6]}]}. Without it, an open "
            "field: the area of the fence."
        ),
    ] = None
    vehicle: VehicleKey = VehicleEntry()
    limits: Annotated[
        LimitsEntry, Field(description="Speed, altitudes and fence that no setpoint leaves.")
    ]
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
            description="Names of things that are no places, e.g. [p1, p2] for two parcels. Facts "
            "may speak of them, e.g. delivered(p1); the vehicle cannot be at them."
        ),
    ] = []
    sets: Annotated[
        dict[Name, Annotated[list[Name], Field(min_length=1)]],
        Field(
            description="Name: [members]; what the parameters of skills range over. Members are "
            "places or objects."
        ),
    ] = {}
    domain: Annotated[
        Text | None,
        BeforeValidator(given, json_schema_input_type=Text),
        Field(
            description="PDDL domain file, relative to this file: its actions are skills, its "
            "types sets, its predicate at(place) is where the vehicle is. Under skills stands for "
            "each action what it does in the world: execute, and if need be assumes, cost, tries, "
            "timeout_s. In names, upper case is as here, and - becomes _."
        ),
    ] = None
    problem: Annotated[
        Text | None,
        BeforeValidator(given, json_schema_input_type=Text),
        Field(
            description="PDDL problem file, relative to this file: objects (those with the name "
            "of a place are that place), facts that hold at the start, and the goal, if neither "
            "goal nor task stands here."
        ),
    ] = None
    components: Annotated[
        dict[Name, Annotated[int, Field(ge=1, le=255)]],
        Field(description="Name: MAVLink component id (1 to 255) that commands are sent to."),
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
            description="Facts that hold at the start, the place of the vehicle among them, "
            "e.g. [at(Home)]; all others are false, but for beliefs.",
        ),
    ] = []
    task: TaskKey = {}
    goal: Annotated[
        Text | None,
        BeforeValidator(given, json_schema_input_type=Text),
        Field(
            description="Facts that have to hold together once, joined by &, ! for not, e.g. "
            "delivered(p1) & delivered(p2): a task that needs no temporal logic. With a task both "
            "must be fulfilled."
        ),
    ] = None
    tree: Annotated[
        list[Any] | None,
        BeforeValidator(given, json_schema_input_type=list[Any]),
        Field(
            min_length=1,
            description="A behaviour tree written by hand, in place of a planner: a list of "
            "actions such as move(Home, A) or move(*, A) from wherever the vehicle is, of facts to "
            "check, of wait(seconds), and of {fallback: [...]}, {parallel: [...]}, "
            "{inverter: [...]}, {repeat: [...], times: n}, {retry: [...], times: n}, "
            "{timeout: [...], duration_s: s}, {watch: FACTS, do: [...]}, {subtree: NAME}.",
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
