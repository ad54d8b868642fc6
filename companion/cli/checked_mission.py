"""The results of `companion check` for a mission that can be flown."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from companion.acting.preparation import anticipate_events
from companion.geometry import horizontal_distance
from companion.mission.files import files_of
from companion.mission.loader import load_mission
from companion.mission.model import Mission
from companion.mission.otherwise import LandAtSafePlace
from companion.mission.pddl_domain import DomainReader, with_domain
from companion.planning.lasso import Solution
from companion.planning.notices import not_heard, notices
from companion.planning.planner import Planner
from companion.planning.time_check import waits
from companion.skills.installed import InstalledReader, read_installed


@dataclass(frozen=True)
class CheckedMission:
    """The results for a mission that can be flown.

    Attributes:
        earth: origin and extent, for a mission in latitude and longitude.
        map: its size and its cells.
        events: when each of them holds, in words.
        states: the number of states of each conjunct's automaton.
        priorities: the priorities of the lines of the task that may be dropped.
        energy: how far the plan charges, and what remains; None without a battery.
        waits: the longest wait of each line with a time bound.
        land_at: where the vehicle lands without a plan, if the mission names places.
        dropped: lines of the task that the plan does not keep, and why.
        notices: what is allowed, but probably a mistake.
    """

    mission: str
    earth: str | None
    map: str
    places: tuple[str, ...]
    events: dict[str, str]
    states: dict[str, int]
    priorities: Mapping[str, int]
    plan: str
    energy: str | None
    waits: tuple[str, ...]
    land_at: LandAtSafePlace | None
    dropped: tuple[str, ...]
    notices: tuple[str, ...]

    def as_json(self) -> dict[str, Any]:
        """The results in JSON values."""
        return {
            "mission": self.mission,
            "earth": self.earth,
            "map": self.map,
            "automata": self.states,
            "plan": self.plan,
            "energy": self.energy,
            "waits": list(self.waits),
            "land_at": list(self.land_at.places) if self.land_at else [],
            "dropped": list(self.dropped),
            "notices": list(self.notices),
        }


def check_mission(
    path: Path,
    within: Path | None,
    tell: Callable[[str], None] = lambda doing: None,
    domain_of: DomainReader = with_domain,
    installed: InstalledReader = read_installed,
    hears_reports: bool = True,
) -> CheckedMission:
    """Reads and plans a mission, and does all else that precedes a flight.

    Args:
        path: the path of the mission.
        within: a folder that must contain all its files.
        tell: called with each step that begins, in words.
        domain_of: reads its PDDL files.
        installed: returns the installed functions.
        hears_reports: whether reports of other programs are received in flight; if not, a mission
            that needs them gets a notice.

    Raises:
        CompanionError: it cannot be flown; the text says why.
    """
    tell("reading it")
    if within is not None:
        files_of(path, within)
    mission = load_mission(path, None, domain_of, installed)
    tell("its routes, actions and automata")
    planner = Planner(mission, clock=time.perf_counter)
    found = None
    if mission.tree is not None:
        planner.actions.of_tree(mission.tree)
    else:
        tell("its first plan")
        found = planner.plan()
        tell("plans for its events")
        anticipate_events(planner)
    unheard = () if hears_reports else not_heard(mission)
    return CheckedMission(
        mission.name,
        _earth_in_words(mission),
        _map_in_words(mission),
        tuple(mission.places),
        {name: event.duration for name, event in mission.events.items()},
        {c.name: c.automaton.states for c in planner.conjuncts},
        mission.priorities,
        str(found or "a tree of its own"),
        _energy_in_words(planner, found) if found else None,
        tuple(map(str, waits(planner.initial_problem()[0], found))) if found else (),
        mission.otherwise if isinstance(mission.otherwise, LandAtSafePlace) else None,
        tuple(map(str, found.dropped)) if found else (),
        tuple(map(str, (*notices(planner, found), *unheard))),
    )


def _earth_in_words(mission: Mission) -> str | None:
    """Origin and extent of a mission in latitude and longitude, in words."""
    anchor, home = mission.anchor, mission.home
    if anchor is None:
        return None
    norths, easts = zip(*mission.limits.fence, strict=True)
    away_m = max(horizontal_distance(p.position, home.position) for p in mission.places.values())
    about = (
        f"metres from {home.name} at {anchor.latitude_deg:.7f}, {anchor.longitude_deg:.7f}; "
        f"places up to {away_m:.0f} m away, fence {max(norths) - min(norths):.0f} m north to south "
        f"and {max(easts) - min(easts):.0f} m west to east"
    )
    if mission.is_above_sea:
        about += (
            f"; {home.name} is taken for {anchor.altitude_m:.0f} m above the sea until it flies"
        )
    return about


def _energy_in_words(planner: Planner, found: Solution) -> str | None:
    """How far a plan charges, what a lap takes, and the least that remains, in words."""
    problem = planner.solver.kept(*planner.initial_problem())[0]
    taken = planner.ledger(problem, found.lasso)
    if taken is None:
        return None
    steps = zip((*found.prefix, *found.loop), (*taken.prefix, *taken.loop), strict=True)
    told = [f"{a.name} to {e.charge_to_percent} %" for a, e in steps if e.charge_to_percent]
    if taken.lap_wh:
        told.insert(0, f"a lap takes {taken.lap_wh:.1f} Wh")
    return "; ".join([*told, str(taken)])


def _map_in_words(mission: Mission) -> str:
    grid = mission.grid
    rows, cols = grid.occupied.shape
    size = f"{cols * grid.cell_m:g} m x {rows * grid.cell_m:g} m in cells of {grid.cell_m:g} m"
    return f"{size}, open: what lies outside is free" if grid.is_open else size
