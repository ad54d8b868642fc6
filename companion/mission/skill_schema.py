"""The model of a skill as a mission file writes it."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field

from companion.drawn_maps import DrawnModel
from companion.mission.battery_schema import Points
from companion.mission.keys import DAY_S, Duration, Name, Text, given
from companion.mission.world_schema import LookAtEntry


def _listed(value: Any) -> Any:
    """Makes a list from a single fact."""
    return [value] if isinstance(value, str) else value


class SkillEntry(DrawnModel):
    """A skill: the planner uses it with every choice of its arguments."""

    parameters: Annotated[
        dict[Name, Name],
        Field(description="Parameter name: the set of its values, e.g. {to: Place}."),
    ] = {}
    distinct: Annotated[
        list[Annotated[list[Name], Field(min_length=2)]],
        Field(
            description="Groups of parameters, places or objects; no two in a group may be the "
            "same, e.g. [[from, to]] or [[to, Home]]."
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
        Field(
            description="Beliefs: facts that are assumed to be true until the skill fails; "
            "one or a list."
        ),
    ] = []
    effect: Annotated[
        Text | None,
        BeforeValidator(given, json_schema_input_type=Text),
        Field(
            description="Facts that hold afterwards (!: no longer hold), e.g. at(to) & "
            "!at(from). Write an effect with a condition in parentheses: free & (has(p) "
            "& lit -> seen(p)); the condition is about the facts before the skill. A "
            "skill of a PDDL domain has its effect there."
        ),
    ] = None
    cost: Annotated[
        Literal["flight_time"] | float | None,
        BeforeValidator(given, json_schema_input_type=Literal["flight_time"] | float),
        Field(
            description="Seconds, or flight_time: the time of the flight and of the waits. "
            "flight_time is the default of a skill that flies. The default of other "
            "skills is the time of their waits, and 1 s for what else they do."
        ),
    ] = None
    execute: Annotated[
        list[Text],
        BeforeValidator(_listed, json_schema_input_type=Text | list[Text]),
        Field(
            min_length=1,
            description="What the vehicle does: one step, or a list of steps, one after the "
            "other. A step is fly(parameter), command(component, MAV_CMD_NAME[, param1, "
            "...]), photo(camera), gimbal(component, pitch_deg, yaw_deg), "
            "grip(component), release(component), wait(seconds), land(), "
            "land_on(parameter), charge(percent or auto), take_off(), python(name, "
            "arguments) for a function of an installed package, or another skill with "
            "its arguments.",
        ),
    ]
    planned: Annotated[
        bool,
        Field(
            description="false: the planner does not use the skill; it is only a step of "
            "other skills."
        ),
    ] = True
    retry_after_s: Annotated[
        float | None,
        BeforeValidator(given, json_schema_input_type=Duration),
        Field(
            gt=0,
            le=DAY_S,
            description="Seconds after a failure until the beliefs of the skill are restored; "
            "without this key, only an event restores them.",
        ),
    ] = None
    repeatable: Annotated[
        bool,
        Field(
            description="For a companion that was cut off during the skill, and does not know "
            "whether its commands and functions took effect. true: they may be sent and "
            "called again. Without this key, the skill then counts as failed, and is "
            "not done again in this flight."
        ),
    ] = False
    energy_wh: Annotated[
        float,
        Field(
            ge=0,
            le=10_000,
            description="Energy that the skill takes beside flying or hovering, Wh.",
        ),
    ] = 0.0
    charge_rate: Annotated[
        Points | None,
        BeforeValidator(given, json_schema_input_type=Points),
        Field(
            description="[[0, 2.0], [80, 2.0], [100, 0.1]]: percent of charge, and the percent "
            "that are added each second there; for charge(auto), which charges as far "
            "as the plan says."
        ),
    ] = None
    tries: Annotated[
        int,
        Field(
            ge=1,
            le=100,
            description="How often all steps of the skill are tried before it has failed.",
        ),
    ] = 1
    timeout_s: Annotated[
        float | None,
        BeforeValidator(given, json_schema_input_type=Duration),
        Field(
            gt=0,
            le=DAY_S,
            description="Longest time of one try, seconds; without this key, no limit.",
        ),
    ] = None
    confirmed_by: Annotated[
        Text | None,
        BeforeValidator(given, json_schema_input_type=Text),
        Field(
            description="Condition on the messages after the last step, e.g. "
            "NAMED_VALUE_INT[load].value > 0. If they do not meet it within timeout_s, "
            "or 10 s, the skill has failed."
        ),
    ] = None
    look_at: Annotated[
        Name | LookAtEntry | None,
        BeforeValidator(given, json_schema_input_type=Name | LookAtEntry),
        Field(
            description="What the vehicle looks at during the skill: a parameter, a place, or a "
            "point {east_m, north_m}; with frame: wgs84 {lat_deg, lon_deg}."
        ),
    ] = None
    gimbal: Annotated[
        Name | None,
        BeforeValidator(given, json_schema_input_type=Name),
        Field(
            description="Component of a gimbal that looks there as well while the vehicle holds."
        ),
    ] = None
