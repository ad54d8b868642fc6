"""Every contingency of surveillance that the world can make happen ends as its table says."""

from __future__ import annotations

import pytest
from contingency_flights import ContingencyFlight, name_of, table, why_not_flown

from companion.acting.contingencies.table import Contingency

FEW = ("2 targetFound comes, then canUpload(r1) withdrawn",)
"""Flown each time: another plan and then a failure of that plan."""


def rows() -> list[Contingency]:
    """Those that can be flown."""
    return [row for row in table().contingencies if why_not_flown(row) is None]


def flown(row: Contingency) -> None:
    flight = ContingencyFlight(row)
    assert flight.fly().differs() is None, "\n".join(event.text for event in flight.events)


@pytest.mark.parametrize("name", FEW)
def test_it_ends_as_the_table_says(name: str) -> None:
    flown(next(row for row in rows() if name_of(row) == name))


@pytest.mark.long
def test_every_contingency_that_can_be_flown_ends_as_the_table_says() -> None:
    """All but 12 of 60: a way that is not being flown is lost with its place alone."""
    asked = rows()
    assert (len(asked), len(table().contingencies)) == (48, 60)
    for row in asked:
        flown(row)
