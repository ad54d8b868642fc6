"""No site starves: whatever interrupts, and however often, each is visited again in time.

Legs and answers are shorter than the time between two interruptions. A site's gap is the time
between two visits, without the time in which the vehicle answers.
"""

from __future__ import annotations

import pytest
from rig import Rig
from synthetic import event, mission, reading

from companion.flight_events.skills import PlaceReached
from companion.tick import TICK_S

SITES = "ABC"


def gaps_s(task: dict[str, str], every_s: float, minutes: float) -> tuple[dict[str, float], float]:
    """The longest gap of each site, and the lap, in a flight that is interrupted so often."""
    rig = Rig(mission(task, places="HABC", events=[event("asked")])).begin()
    lap_s = rig.plans[0].lap_cost_ms / 1000
    flown_s, answering, last = 0.0, False, dict.fromkeys(SITES, 0.0)
    longest = dict.fromkeys(SITES, 0.0)
    told = 0
    for tick in range(1, round(60 * minutes / TICK_S)):
        if tick % round(every_s / TICK_S) == 0:
            rig.tick(reading("asked"), reading("asked", 0.0))
            answering = True
        else:
            rig.tick()
        flown_s += 0.0 if answering else TICK_S
        reached = rig.of(PlaceReached)[told:]
        told += len(reached)
        for place in (each.place for each in reached):
            answering = answering and place != "H"
            if place in SITES:
                longest[place] = max(longest[place], flown_s - last[place])
                last[place] = flown_s
    return {site: max(longest[site], flown_s - last[site]) for site in SITES}, lap_s


COME = {"come": "G (asked -> F at(H))"}
PATROLS = {
    "lines": {site: f"G F at({site})" for site in SITES} | COME,
    "one line": {"patrol": "patrolling(A, B, C)"} | COME,
}


@pytest.mark.parametrize(
    ("name", "every_s", "minutes"),
    [
        ("lines", 14.0, 3.0),
        ("one line", 16.0, 3.0),
        *(
            pytest.param(name, every_s, 30.0, marks=pytest.mark.long)
            for name in PATROLS
            for every_s in (14.0, 16.0, 18.0, 20.0)
        ),
    ],
)
def test_no_gap_is_longer_than_two_laps(name: str, every_s: float, minutes: float) -> None:
    longest, lap_s = gaps_s(PATROLS[name], every_s, minutes)
    assert max(longest.values()) <= 2 * lap_s, longest


@pytest.mark.long
def test_others_do_not_wait_for_what_cannot_be_reached() -> None:
    """To answer and then to fly to B takes longer than the next request does to come."""
    longest, lap_s = gaps_s(PATROLS["lines"], 12.0, 4.0)
    assert longest["B"] > 5 * lap_s
    assert max(longest["A"], longest["C"]) <= 3 * lap_s
