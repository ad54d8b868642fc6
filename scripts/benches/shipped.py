"""The shipped missions and their worlds; each is flown in lockstep from here."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from benches import ROOT
from companion import load_mission
from companion.api.simulating import lockstep, world_of
from companion.mission.model import Mission
from companion.mission_run import Recorder
from sitl.harness import LockstepFlight

MISSIONS = ROOT / "missions"
SCENARIO = ".sim.yaml"


@dataclass(frozen=True, slots=True)
class Shipped:
    """A mission and a world for it.

    Attributes:
        name: of the scenario.
    """

    name: str
    mission: Path
    scenario: Path

    def load(self) -> Mission:
        """Reads the mission."""
        return load_mission(self.mission)

    def flight(self, mission: Mission, recorder: Recorder) -> LockstepFlight:
        """The flight, seed 0, that is still to be flown."""
        return lockstep(mission, world_of(mission, self.scenario), recorder)


def shipped() -> list[Shipped]:
    """All, by name. A scenario without a mission of its name belongs to the one it begins with."""
    names = [path.name.removesuffix(SCENARIO) for path in sorted(MISSIONS.glob(f"*{SCENARIO}"))]
    missions = [name for name in names if (MISSIONS / f"{name}.yaml").exists()]
    return [
        Shipped(
            name,
            MISSIONS / f"{max((m for m in missions if name.startswith(m)), key=len)}.yaml",
            MISSIONS / f"{name}{SCENARIO}",
        )
        for name in names
    ]
