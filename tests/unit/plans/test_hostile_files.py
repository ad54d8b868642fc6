"""Files of strangers: whatever is in them, they become a mission or are refused; nothing else."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from plan_files import TAKE_OFF, circle, imported, item, plan, polygon, square, waypoint

from companion.errors import MissionError
from companion.plans.draft_places import Given
from companion.plans.files import MAX_BYTES, READERS

UP = Given(up_m=20.0, payload=100)
WHOLE = plan(
    TAKE_OFF,
    waypoint(30, 0, hold_s=3),
    item(178, 1, 4, frame=2),
    item(2000, 0, 0, 1, frame=2),
    waypoint(30, 40, 500.0, frame=0),
    item(177, 2, -1, frame=2),
    polygons=[polygon(square(90)), polygon(square(4, north_m=-30), inclusion=False)],
    circles=[circle(square(1)[0], 80)],
    rally=[[*square(20)[0], 9]],
)
ODD = st.sampled_from(
    [None, True, -1, 0, 1, 3.7, 91, 1e300, 10**400, "", "x", "\x1b[2J", [], [None], {}, {"a": 1}]
)


def paths(data: Any, keys: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    """Where something stands in a tree."""
    found = [keys] if keys else []
    if isinstance(data, dict | list):
        for key, value in data.items() if isinstance(data, dict) else enumerate(data):
            found += paths(value, (*keys, key))
    return found


def changed(data: Any, keys: tuple[Any, ...], value: Any) -> Any:
    """The same tree with another value there, or without the key if that is an Ellipsis."""
    if not keys:
        return value
    copy = dict(data) if isinstance(data, dict) else list(data)
    if len(keys) == 1 and value is ...:
        del copy[keys[0]]
    else:
        copy[keys[0]] = changed(copy[keys[0]], keys[1:], value)
    return copy


@settings(max_examples=80, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(where=st.sampled_from(paths(WHOLE)), value=st.one_of(st.just(...), ODD))
def test_a_plan_with_anything_anywhere_is_read_or_refused(
    where: tuple[Any, ...], value: Any, tmp_path: Path
) -> None:
    try:
        text, _ = imported(tmp_path, changed(WHOLE, where, value), "field.plan", UP)
    except MissionError as refused:
        assert str(refused).startswith(f"{tmp_path}/field.plan: ") and "\x1b" not in str(refused)
    else:
        assert "\x1b" not in text


def test_the_whole_plan_is_read(tmp_path: Path) -> None:
    assert imported(tmp_path, WHOLE, "field.plan", UP)


@settings(max_examples=60, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(ending=st.sampled_from(sorted(READERS)), data=st.binary(max_size=60))
def test_bytes_are_read_or_refused(ending: str, data: bytes, tmp_path: Path) -> None:
    with pytest.raises(MissionError):
        imported(tmp_path, data, f"field{ending}", UP)


@pytest.mark.parametrize("ending", sorted(READERS))
def test_a_file_that_is_too_large_is_not_read(ending: str, tmp_path: Path) -> None:
    with pytest.raises(MissionError, match=f"larger than {MAX_BYTES} bytes"):
        imported(tmp_path, b" " * (MAX_BYTES + 1), f"field{ending}")
