"""Which missions are shipped, and in which worlds? Each is flown in lockstep from here."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from benches import ROOT
from companion.app import Companion
from companion.mission.loader import load_mission
from companion.mission.model import Mission
from companion.mission_run import Recorder
from sitl.harness import fly_in_lockstep
from sitl.link.routing import LinkName
from sitl.simulation import Simulation
from sitl.world.scenario import read_scenario

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

    def fly(
        self,
        mission: Mission,
        recorder: Callable[[Simulation], Recorder],
        seed: int = 0,
        companion: Callable[[Mission, Recorder], Companion] = Companion,
    ) -> Recorder:
        """Flies it to its end, however it ends; the recorder is made for the simulation."""
        scenario, grid = read_scenario(self.scenario)
        simulation = Simulation(scenario, grid, seed=seed, links=frozenset({LinkName.OFFBOARD}))
        witness = recorder(simulation)
        fly_in_lockstep(companion(mission, witness), simulation)
        return witness


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
