"""The shipped missions and their worlds, to be flown in lockstep."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from benches import ROOT
from companion import load_mission
from companion.app import Companion
from companion.flights.simulated_world import lockstep, world_of
from companion.mission.model import Mission
from companion.mission_run import Recorder
from companion.run_sources.only_run import OnlyRun
from sitl.harness import LockstepFlight

MISSIONS = ROOT / "missions"
SCENARIO = ".sim.yaml"


@dataclass(frozen=True, slots=True)
class Shipped:
    """A mission with a world.

    Attributes:
        name: the name of the scenario, or of a mission without one.
    """

    name: str
    mission: Path
    scenario: Path | None

    def load(self) -> Mission:
        """Reads the mission."""
        return load_mission(self.mission)

    def flight(self, mission: Mission, recorder: Recorder) -> LockstepFlight:
        """The flight with seed 0, before its first tick."""
        return lockstep(Companion(OnlyRun(mission, recorder)), world_of(mission, self.scenario))


def shipped() -> list[Shipped]:
    """All, by name. A scenario without its own mission has the one whose name begins its own."""
    names = [path.name.removesuffix(SCENARIO) for path in sorted(MISSIONS.glob(f"*{SCENARIO}"))]
    missions = [name for name in names if (MISSIONS / f"{name}.yaml").exists()]
    with_scenario = [
        Shipped(
            name,
            MISSIONS / f"{max((m for m in missions if name.startswith(m)), key=len)}.yaml",
            MISSIONS / f"{name}{SCENARIO}",
        )
        for name in names
    ]
    alone = [
        path for path in MISSIONS.glob("*.yaml") if path.stem.removesuffix(".sim") not in names
    ]
    return sorted(
        [*with_scenario, *(Shipped(path.stem, path, None) for path in alone)],
        key=lambda each: each.name,
    )
