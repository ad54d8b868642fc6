"""What all models of a scenario file share: they refuse unknown keys and limit values."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field

from companion.geometry import FAR_M


class Strict(BaseModel):
    """A mapping; unknown keys are refused."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


def described(description: str, **limits: Any) -> Any:
    """A field with its description, which serves as a hint in messages."""
    return Field(description=description, **limits)


East = Annotated[float, described("metres east of home", ge=-FAR_M, le=FAR_M)]
North = Annotated[float, described("metres north of home", ge=-FAR_M, le=FAR_M)]
EastSpeed = Annotated[float, described("m/s towards east", ge=-30, le=30)]
NorthSpeed = Annotated[float, described("m/s towards north", ge=-30, le=30)]
Component = Annotated[int, described("its MAVLink component id", ge=2, le=255)]
