"""What an autopilot stores is compared with what was written as it lies on the earth."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from companion.mavlink.item_transfer import StoredItem
from companion.vehicle.item_store import ItemStore

WRITTEN = (
    StoredItem(5001, 0, 3.0, 473977329, 85455740),
    StoredItem(5001, 0, 3.0, 473977329, 85458796),
    StoredItem(5001, 0, 3.0, 473978678, 85458796),
)


def store(written: Any, items: Any) -> ItemStore:
    nobody: Any = None
    made = ItemStore(nobody, nobody, 1, nobody, "fence")
    made.written, made.items = written, items
    return made


def test_what_is_read_back_is_what_was_written() -> None:
    assert store(WRITTEN, WRITTEN).is_as_written()


def test_a_centimetre_of_rounding_is_no_difference() -> None:
    rounded = tuple(replace(item, x=item.x + 1, y=item.y - 1) for item in WRITTEN)
    assert store(WRITTEN, rounded).is_as_written()


def test_rounding_across_the_180th_meridian_is_none() -> None:
    east, west = replace(WRITTEN[0], y=1_800_000_000), replace(WRITTEN[0], y=-1_799_999_999)
    assert store((east,), (west,)).is_as_written()
    assert not store((east,), (replace(west, y=-1_799_999_990),)).is_as_written()


@pytest.mark.parametrize(
    "other",
    [
        None,
        (),
        WRITTEN[:2],
        WRITTEN[::-1],
        (replace(WRITTEN[0], x=473977429), *WRITTEN[1:]),
        (replace(WRITTEN[0], y=85455840), *WRITTEN[1:]),
        (replace(WRITTEN[0], command=5002), *WRITTEN[1:]),
        (replace(WRITTEN[0], first=4.0), *WRITTEN[1:]),
        (replace(WRITTEN[0], altitude_m=1.0), *WRITTEN[1:]),
        (replace(WRITTEN[0], frame=3), *WRITTEN[1:]),
    ],
)
def test_anything_else_is_not(other: Any) -> None:
    assert not store(WRITTEN, other).is_as_written()


def test_where_nothing_was_written_nothing_is_like_it() -> None:
    assert not store(None, WRITTEN).is_as_written()
