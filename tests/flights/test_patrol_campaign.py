"""Four hours of endless_patrol in lockstep: gusts, cells that age, docks that fail now and then.

    scripts/test -m long tests/flights/test_patrol_campaign.py

A flight takes some six minutes of an idle core. The autopilot never acts on its battery, every site
is met again and again, and what a stretch between two charges takes is as expected.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from random import Random
from typing import Any

import numpy as np
import pytest
from lockstep import Lockstep
from ruamel.yaml import YAML

from companion.api.simulating import world_of
from companion.flight_events.energy import EnergyUsed
from companion.flight_events.skills import PlaceReached
from companion.mission.loader import load_mission
from companion.mission.model import Mission

pytestmark = pytest.mark.long

MISSION = Path(__file__).parents[2] / "missions" / "endless_patrol.yaml"
HOURS = 4.0
OFTEN_S = 1800.0
"""Each site is met again within so long, with a dock that fails on the way."""
LONG_S = 60.0
"""Stretches of so much flight and more are compared."""
SITES = ("Barn", "Mill", "Weir", "Ford", "Oak", "Gate", "Well", "Pond", "Hill", "Shed")
PADS = {"west": (50, 35), "east": (280, 155)}
LEAST_PERCENT = 18.0
MOST_ERROR = 0.15
"""Of what a stretch takes; docs/decisions/energy.md has what was measured."""


def mission() -> Mission:
    data = YAML(typ="safe").load(MISSION)
    data["skills"]["recharge"]["retry_after_s"] = 900  # a dock is mended in the end
    return load_mission(data)


def ages(chance: Random, hours: float) -> Iterator[dict[str, Any]]:
    """Each hour a little is lost of what the pack holds, and its resistance rises."""
    capacity, resistance = 0.27, 1.2
    for hour in range(1, int(hours)):
        capacity, resistance = capacity * chance.uniform(0.95, 0.99), resistance * 1.1
        battery = {"capacity": round(capacity, 4), "resistance": round(resistance, 3)}
        yield {"at_s": 3600 * hour, "battery": battery}


def failures(chance: Random, hours: float) -> Iterator[dict[str, Any]]:
    """One dock at a time fails, for less time than it takes until a dock is given up.

    A vehicle arrives at a dock with what it takes to land there: given up, it is where it ends.
    """
    now_s = chance.uniform(900, 2400)
    while now_s < 3600 * hours:
        pad = chance.choice(list(PADS))
        yield {"at_s": round(now_s), "pad": {"name": pad, "works": False}}
        yield {"at_s": round(now_s + 90), "pad": {"name": pad, "works": True}}
        now_s += 90 + chance.uniform(1800, 3600)


def flown(seed: int, hours: float = HOURS) -> tuple[Lockstep, float]:
    """The flight, and the least charge in the air, percent."""
    chance, asked = Random(seed), mission()
    happens = sorted((*ages(chance, hours), *failures(chance, hours)), key=lambda e: e["at_s"])
    wind = {"east_mps": chance.uniform(-3, 3), "north_mps": chance.uniform(-3, 3)}
    scenario = {
        "version": 1,
        "map": {"east_m": [-40, 380], "north_m": [-40, 290], "cell_m": 1},
        "battery": {"charge": 0.84, "capacity": 0.27, "resistance": 1.2},
        "wind": wind | {"turbulence_mps": 0.3},
        "pads": [
            {"name": name, "east_m": east_m, "north_m": north_m, "radius_m": 1, "current_a": 60}
            for name, (east_m, north_m) in PADS.items()
        ],
        "happens": happens,
    }
    flight, least = Lockstep(asked, world_of(asked, scenario), seed=seed), 100.0
    while flight.now_s < 3600 * hours and not flight.companion.has_ended:
        flight.run(2.0)
        if flight.simulation.is_armed:
            least = min(least, 100 * flight.simulation.flight.charge)
    return flight, least


def gaps_s(flight: Lockstep) -> list[float]:
    """The longest time between two visits of each site, beginning and end included."""
    met: dict[str, list[float]] = {site: [0.0] for site in SITES}
    for stamped in flight.reports:
        if isinstance(stamped.event, PlaceReached) and stamped.event.place in met:
            met[stamped.event.place].append(stamped.time_s)
    return [max(b - a for a, b in pairwise([*times, flight.now_s])) for times in met.values()]


def errors(flight: Lockstep) -> list[float]:
    """By how much each stretch was expected to take more or less than it took."""
    used = [event for event in flight.of(EnergyUsed) if event.seconds >= LONG_S]
    return [abs(event.expected_wh / event.used_wh - 1) for event in used]


@pytest.mark.parametrize("seed", range(20))
def test_a_patrol_of_four_hours(seed: int) -> None:
    flight, least = flown(seed)
    assert not flight.companion.has_ended, "\n".join(event.text for event in flight.events[-20:])
    assert least >= LEAST_PERCENT
    assert max(gaps_s(flight)) <= OFTEN_S
    assert np.quantile(errors(flight), 0.95) <= MOST_ERROR
