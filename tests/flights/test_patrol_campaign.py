"""Four hours of endless_patrol in lockstep: gusts, cells that age, docks that fail now and then.

    scripts/test -m long -n 2 -rP tests/flights/test_patrol_campaign.py

A flight takes some six minutes of an idle core. The autopilot never acts on its battery, every site
is met again and again, and what a stretch between two charges takes is what the plan says when it
begins. Figures are printed; a flight that fails names the command that repeats it alone.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path
from random import Random
from typing import Any

import numpy as np
import pytest
from lockstep import Lockstep
from ruamel.yaml import YAML

from companion.acting.executive import Executive
from companion.flight_events.energy import EnergyUsed
from companion.flight_events.event import FlightEvent, Stamped
from companion.flight_events.plans import PlanReplaced
from companion.flight_events.skills import PlaceReached
from companion.flight_events.sortie import (
    BatteryCharged,
    ChargeAwaited,
    ChargeSufficient,
    VehicleLanded,
)
from companion.mission.loader import load_mission
from companion.mission.model import Mission
from companion.planning.charger import UNITS_PER_WH
from companion.planning.domain import Action
from sitl.link.routing import LinkName
from sitl.world.scenario import read_scenario

pytestmark = pytest.mark.long

MISSION = Path(__file__).parents[2] / "missions" / "endless_patrol.yaml"
HOURS = 4.0
OFTEN_S = 1800.0
"""Each site is met again within so long, with a dock that fails for ten minutes on the way."""
LONG_S = 60.0
"""Stretches of so much flight and more are compared."""
SITES = ("Barn", "Mill", "Weir", "Ford", "Oak", "Gate", "Well", "Pond", "Hill", "Shed")
PADS = {"west": (50, 35), "east": (280, 155)}
LEAST_PERCENT = 18.0
MOST_ERROR = 0.05
"""Of what a stretch takes, at the 95th percentile."""


class LongFlight(Lockstep):
    """A flight that keeps nothing of what it sends: that would be gigabytes."""

    def transmit(self, now_s: float, sent: list[bytes]) -> None:
        """It arrives in the next tick."""
        self._to_vehicle += [(LinkName.OFFBOARD, datagram) for datagram in sent]

    def report(self, stamped: Stamped) -> None:
        """What people are told is kept."""
        if stamped.event.is_told:
            self.reports.append(stamped)


@dataclass
class Stretches:
    """What plans say of the stretches between two charges, against what these truly take.

    A stretch goes from the end of a charge to the landing for the next one, take-off and landing
    included. What the plan says is its mean, and with the margin that it keeps. Where another plan
    is made on the way, or a charge is left out, it does not count.

    Attributes:
        means, margins: by how much more, as a share, for each stretch.
        left_out: stretches of which the plan has not said it all.
    """

    flight: Lockstep
    means: list[float] = field(default_factory=list)
    margins: list[float] = field(default_factory=list)
    left_out: int = 0
    _said_wh: tuple[float, float] | None = None
    _begun_s: float = 0.0
    _begun_wh: float = 0.0
    _seen: int = 0

    def look(self) -> None:
        """After each tick."""
        reports = self.flight.reports
        for stamped in reports[self._seen :]:
            self._take(stamped.time_s, stamped.event)
        self._seen = len(reports)

    def _take(self, time_s: float, event: FlightEvent) -> None:
        if isinstance(event, BatteryCharged):
            self._said_wh, self._begun_s, self._begun_wh = self._said(), time_s, self._used_wh
        elif isinstance(event, PlanReplaced | ChargeSufficient) and self._said_wh is not None:
            self._said_wh, self.left_out = None, self.left_out + 1
        elif isinstance(event, VehicleLanded) and self._said_wh is not None:
            used_wh = self._used_wh - self._begun_wh
            if time_s - self._begun_s >= LONG_S:
                for errors, said_wh in zip((self.means, self.margins), self._said_wh, strict=True):
                    errors.append(said_wh / used_wh - 1)
            self._said_wh = None

    @property
    def _used_wh(self) -> float:
        """At the battery's terminals."""
        return self.flight.simulation._physics.battery.gauge().consumed_j / 3600

    def _said(self) -> tuple[float, float]:
        executive = _executive(self.flight)
        energy, lasso = executive.planner.energy, executive.lasso
        assert energy is not None and lasso is not None
        ahead = _actions(lasso.prefix, lasso.loop, executive._flight.progress.completed)
        charged = next(ahead).charger
        assert charged is not None
        units = charged.take_off
        for action in ahead:
            if action.charger is not None:
                units += action.charger.landing
                break
            units += action.drain
        with_margin_wh = units / UNITS_PER_WH / energy.known.gauge.mean
        return with_margin_wh * energy.known.mean / energy.model.factor, with_margin_wh


def _executive(flight: Lockstep) -> Executive:
    run = flight.companion._run
    assert run is not None
    return run.executive


def _actions(prefix: tuple[Action, ...], loop: tuple[Action, ...], first: int) -> Iterator[Action]:
    """Those of a plan from one on, for ever."""
    yield from prefix[first:]
    begin = max(0, first - len(prefix)) % len(loop)
    yield from loop[begin:]
    while True:
        yield from loop


def mission() -> Mission:
    data = YAML(typ="safe").load(MISSION)
    data["skills"]["recharge"]["retry_after_s"] = 900  # a dock is mended in the end
    return load_mission(data)


def ages(chance: Random, hours: float) -> Iterator[dict[str, Any]]:
    """Each hour a little is lost of what the pack holds, and its resistance rises."""
    capacity, resistance = 0.27, 1.2
    for hour in range(1, math.ceil(hours)):
        capacity, resistance = capacity * chance.uniform(0.95, 0.99), resistance * 1.1
        battery = {"capacity": round(capacity, 4), "resistance": round(resistance, 3)}
        yield {"at_s": 3600 * hour, "battery": battery}


def failures(chance: Random, hours: float) -> Iterator[dict[str, Any]]:
    """Each dock fails now and then, for one to ten minutes."""
    for pad in PADS:
        now_s = chance.uniform(900, 3600)
        while now_s < 3600 * hours:
            yield {"at_s": round(now_s), "pad": {"name": pad, "works": False}}
            now_s += chance.uniform(60, 600)
            yield {"at_s": round(now_s), "pad": {"name": pad, "works": True}}
            now_s += chance.uniform(1800, 5400)


def world(seed: int, hours: float) -> dict[str, Any]:
    """The scenario of a seed: 3 to 5 m/s of wind from anywhere, with gusts; no lidar, for speed."""
    chance = Random(seed)
    happens = sorted((*ages(chance, hours), *failures(chance, hours)), key=lambda e: e["at_s"])
    speed_mps, heading_rad = chance.uniform(3, 5), chance.uniform(-math.pi, math.pi)
    east_mps, north_mps = speed_mps * math.sin(heading_rad), speed_mps * math.cos(heading_rad)
    return {
        "version": 1,
        "battery": {"charge": 0.84, "capacity": 0.27, "resistance": 1.2},
        "wind": {"east_mps": east_mps, "north_mps": north_mps, "turbulence_mps": 0.5},
        "pads": [
            {"name": name, "east_m": east_m, "north_m": north_m, "radius_m": 1, "current_a": 60}
            for name, (east_m, north_m) in PADS.items()
        ],
        "happens": happens,
    }


@dataclass(frozen=True)
class Flown:
    """A flight of the campaign.

    Attributes:
        least: charge in the air, percent.
        stretches: what plans have said of them.
    """

    flight: Lockstep
    least: float
    stretches: Stretches

    @property
    def gap_s(self) -> float:
        """The longest time between two visits of a site, beginning and end included."""
        met: dict[str, list[float]] = {site: [0.0] for site in SITES}
        for stamped in self.flight.reports:
            if isinstance(stamped.event, PlaceReached) and stamped.event.place in met:
                met[stamped.event.place].append(stamped.time_s)
        end_s = self.flight.now_s
        return max(b - a for times in met.values() for a, b in pairwise([*times, end_s]))

    @property
    def legs(self) -> list[float]:
        """By how much more each stretch was expected to take, all of them, by the companion."""
        used = [event for event in self.flight.of(EnergyUsed) if event.seconds >= LONG_S]
        return [event.expected_wh / event.used_wh - 1 for event in used]

    def __str__(self) -> str:
        told = self.stretches
        columns = (
            f"{self.flight.now_s / 3600:.2f} h, {self.least:.1f} % at least",
            f"met again within {self.gap_s:.0f} s",
            f"{len(self.flight.of(PlanReplaced))} plans anew",
            f"{len(self.flight.of(ChargeAwaited))} docks waited on",
            f"{len(told.means)} stretches as planned, {told.left_out} not",
            f"their error {_figures(told.means)}",
            f"with margin {_figures(told.margins)}",
            f"{len(self.legs)} stretches by the companion {_figures(self.legs)}",
        )
        return "; ".join(columns)


def _figures(errors: list[float]) -> str:
    """Median and 95th percentile of the size."""
    if not errors:
        return "unknown"
    sizes = np.abs(errors)
    return f"{100 * np.median(sizes):.1f} / {100 * np.quantile(sizes, 0.95):.1f} %"


def flown(seed: int, hours: float = HOURS) -> Flown:
    """The flight of a seed."""
    asked, least = mission(), 100.0
    flight = LongFlight(asked, read_scenario(world(seed, hours)), seed=seed)
    stretches = Stretches(flight)
    while flight.now_s < 3600 * hours and not flight.companion.has_ended:
        flight.tick()
        stretches.look()
        if flight.simulation.is_armed:
            least = min(least, 100 * flight.simulation.flight.charge)
    return Flown(flight, least, stretches)


@pytest.mark.parametrize("seed", range(20))
def test_a_patrol_of_four_hours(seed: int) -> None:
    found = flown(seed)
    print(f"seed {seed}: {found}")
    name = f"{Path(__file__).name}::{test_a_patrol_of_four_hours.__name__}[{seed}]"
    again = f"scripts/test -m long -rP 'tests/flights/{name}'"
    last = "\n".join(event.text for event in found.flight.events[-20:])
    about = f"{found}\n{last}\n{again}"
    assert not found.flight.companion.has_ended, about
    assert found.least >= LEAST_PERCENT, about
    assert found.gap_s <= OFTEN_S, about
    assert np.quantile(np.abs(found.stretches.means), 0.95) <= MOST_ERROR, about
    assert np.quantile(np.abs(found.legs), 0.95) <= MOST_ERROR, about
