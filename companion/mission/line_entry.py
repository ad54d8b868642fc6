"""The model of the key `task` of a mission file: its lines, required or optional."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import BeforeValidator, Field

from companion.drawn_maps import DrawnModel
from companion.mission.keys import Name, Text, given

Priority = Annotated[int, Field(ge=1, le=1_000_000)]


class LineEntry(DrawnModel):
    """A line of the task. A line with a priority is dropped if no plan keeps it."""

    formula: Annotated[Text, Field(description="What must hold, in linear temporal logic.")]
    priority: Annotated[
        Priority | None,
        BeforeValidator(given, json_schema_input_type=Priority),
        Field(
            description="A positive whole number, for a line that may be dropped. If not all "
            "lines can be kept, those of higher priority are kept first; of equal ones, "
            "the first in the file. Lines without a priority are never dropped.",
        ),
    ] = None


def _by_formula(value: Any) -> Any:
    return value if isinstance(value, dict) else {"formula": value}


TaskKey = Annotated[
    dict[
        Name,
        Annotated[LineEntry, BeforeValidator(_by_formula, json_schema_input_type=Text | LineEntry)],
    ],
    Field(
        description="Name: formula in linear temporal logic, e.g. G F at(A); all of them must "
        "hold. {formula: G F at(A), priority: 1} is dropped if no plan keeps it. May be "
        "left out if there is a goal."
    ),
]
