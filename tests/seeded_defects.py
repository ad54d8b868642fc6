"""Defects that are put into the companion for a test: subtle, and each shows in few worlds.

A defect is one patch of one place, with a short mission, and a scenario in which it seldom matters.
None of the worlds makes the mission fail without the defect.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import pytest

from companion.api.simulating import varied_world_of
from companion.campaigns.kit import Kit
from companion.mission.loader import load_mission
from companion.vehicle_profile import VehicleProfile

LIMIT_S = 90.0
AROUND_A_CORNER = """
version: 1
name: around_a_corner
map: {east_m: [-3, 14], north_m: [-6, 6], walls: [{east_m: [4, 5], north_m: [-6, 2]}]}
limits: {speed_mps: 8, up_m: [0.5, 4], fence: [[-2, -5], [13, -5], [13, 5], [-2, 5]]}
places:
  Home: {east_m: 0, north_m: 0, up_m: 1}
  Far: {east_m: 9, north_m: 0, up_m: 1}
sets: {Place: [Home, Far]}
skills:
  move: {parameters: {from: Place, to: Place}, precondition: at(from),
         assumes: "trans_ok(from, to)", effect: at(to) & !at(from), execute: fly(to)}
initially: [at(Home)]
goal: at(Far)
"""


@dataclass(frozen=True)
class Defect:
    """A defect.

    Attributes:
        name: what is wrong.
        mission: in which it may matter, as YAML.
        scenario: what varies, as YAML.
        put_in: patches the companion.
    """

    name: str
    mission: str
    scenario: str
    put_in: Callable[[pytest.MonkeyPatch], None]

    def kit(self) -> Kit:
        """What is flown."""
        mission = load_mission(self.mission)
        return Kit.of(mission, varied_world_of(mission, self.scenario), LIMIT_S)


def _keep_the_radius_alone(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(VehicleProfile, "clearance_m", property(lambda vehicle: vehicle.radius_m))


DEFECTS = (
    Defect(
        "routes keep the vehicle's radius alone, and nothing for its deviation",
        AROUND_A_CORNER,
        """
version: 1
wind: {east_mps: 0, north_mps: 0, turbulence_mps: 0}
vary:
  wind.east_mps: [-9, 9]
  wind.north_mps: [-9, 9]
  wind.turbulence_mps: [0, 0.4]
  start.heading_deg: [0, 360]
  battery.charge: [0.5, 1]
""",
        _keep_the_radius_alone,
    ),
)
