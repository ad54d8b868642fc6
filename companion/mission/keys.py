"""Types that the keys of a mission file share: names, texts, required values."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import Field
from pydantic_core import PydanticCustomError

Name = Annotated[str, Field(pattern=r"^[A-Za-z_][A-Za-z0-9_]*$", max_length=40)]
"""The name of a place, set, event, skill, parameter, component or conjunct."""

Text = Annotated[str, Field(min_length=1)]

DAY_S = 86_400
"""The longest time in a mission; a longer one was probably meant in another unit."""
Duration = Annotated[float, Field(gt=0, le=DAY_S)]


def given(value: Any) -> Any:
    """Refuses an optional key without a value, which somebody forgot to fill in."""
    if value is None:
        raise PydanticCustomError("empty", "has no value; write one, or remove the key")
    return value
