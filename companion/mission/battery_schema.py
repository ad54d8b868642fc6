"""The model of the key `battery` of a mission file."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import BeforeValidator, Field

from companion.drawn_maps import DrawnModel
from companion.mission.keys import given


def _pair(value: Any) -> Any:
    """Makes a tuple of a list, since strict validation of an optional key wants a tuple."""
    return tuple(value) if isinstance(value, list) else value


Pair = Annotated[
    tuple[float, float], BeforeValidator(_pair, json_schema_input_type=tuple[float, float])
]
Points = Annotated[list[Pair], Field(min_length=2, max_length=50)]


class PowerEntry(DrawnModel):
    """The power that flying takes."""

    level: Annotated[
        Points,
        Field(
            description="[[0, 190], [5, 192], ...]: airspeed in m/s, from 0, and watts in level "
            "flight."
        ),
    ]
    climb: Annotated[
        Points | None,
        BeforeValidator(given, json_schema_input_type=Points),
        Field(
            description="[[-1, 180], [0, 190], [2, 212]]: m/s upwards and watts; without this "
            "key, the power of level flight."
        ),
    ] = None


class AirEntry(DrawnModel):
    """The expected wind: the direction in which the air moves."""

    east_mps: Annotated[float, Field(ge=-30, le=30, description="m/s towards east.")] = 0.0
    north_mps: Annotated[float, Field(ge=-30, le=30, description="m/s towards north.")] = 0.0


class BatteryEntry(DrawnModel):
    """The battery. With this key, plans keep enough energy to land at a safe place at any time."""

    reserve: Annotated[
        float,
        Field(ge=0, le=90, description="Percent of the energy that is kept for the unforeseen."),
    ]
    capacity_wh: Annotated[
        float | None,
        BeforeValidator(given, json_schema_input_type=float),
        Field(
            gt=0,
            le=10_000,
            description="Usable energy of a full battery, Wh; without this key, the default "
            "vehicle's.",
        ),
    ] = None
    curve: Annotated[
        Points | None,
        BeforeValidator(given, json_schema_input_type=Points),
        Field(
            description="[[0, 0], [50, 48], [100, 100]]: percent of charge, and percent of the "
            "energy that is left then. Without this key they are the same, or as the "
            "default vehicle's."
        ),
    ] = None
    power_w: Annotated[
        PowerEntry | None,
        BeforeValidator(given, json_schema_input_type=PowerEntry),
        Field(description="The power that flying takes; without this key, the default vehicle's."),
    ] = None
    wind: Annotated[
        AirEntry, Field(description="The wind that is expected; without this key, none.")
    ] = AirEntry()
