"""The model of a skill as a mission file writes it."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field

from companion.drawn_maps import DrawnModel
from companion.mission.battery_schema import Points
from companion.mission.keys import DAY_S, Duration, Name, Text, given
from companion.mission.world_schema import LookAtEntry


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
            description="Seconds, or flight_time, with what it waits: the default of a skill that "
            "flies. The default of all others is what they wait, and 1 for what else they do."
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
            "wait(seconds), land(), land_on(parameter), charge(percent or auto), take_off(), "
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
    energy_wh: Annotated[
        float,
        Field(ge=0, le=10_000, description="What it takes beside flying or hovering, Wh."),
    ] = 0.0
    charge_rate: Annotated[
        Points | None,
        BeforeValidator(given, json_schema_input_type=Points),
        Field(
            description="[[0, 2.0], [80, 2.0], [100, 0.1]]: percent of charge, and how many "
            "a second are added there; for charge(auto), which charges as far as the plan says."
        ),
    ] = None
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
