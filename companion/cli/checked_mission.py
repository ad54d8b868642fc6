"""What `companion check` finds out about a mission that can be flown."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from companion.acting.preparation import anticipate_events
from companion.mission.files import files_of
from companion.mission.loader import load_mission
from companion.mission.pddl_domain import DomainReader, with_domain
from companion.planning.notices import notices
from companion.planning.planner import Planner


@dataclass(frozen=True)
class CheckedMission:
    """What is told of a mission that can be flown.

    Attributes:
        events: when each of them holds, in words.
        states: of each conjunct's automaton.
        priorities: of the lines of the task that may be dropped.
        dropped: lines of the task that the plan does not keep, and why.
        notices: what is allowed, and hardly meant.
    """

    mission: str
    places: tuple[str, ...]
    events: dict[str, str]
    states: dict[str, int]
    priorities: Mapping[str, int]
    plan: str
    dropped: tuple[str, ...]
    notices: tuple[str, ...]

    def as_json(self) -> dict[str, Any]:
        """The same for programs."""
        return {
            "mission": self.mission,
            "automata": self.states,
            "plan": self.plan,
            "dropped": list(self.dropped),
            "notices": list(self.notices),
        }


def check_mission(
    path: Path,
    within: Path | None,
    tell: Callable[[str], None] = lambda doing: None,
    domain_of: DomainReader = with_domain,
) -> CheckedMission:
    """Reads and plans a mission, and does all else that is done before it flies.

    Args:
        path: of the mission.
        within: a folder that all its files have to be in.
        tell: told what is begun, in words.
        domain_of: reads its PDDL files.

    Raises:
        CompanionError: it cannot be flown, and why.
    """
    tell("reading it")
    if within is not None:
        files_of(path, within)
    mission = load_mission(path, domain_of=domain_of)
    tell("its routes, actions and automata")
    planner = Planner(mission, clock=time.perf_counter)
    found = None
    if mission.tree is not None:
        planner.actions_of(mission.tree)
    else:
        tell("its first plan")
        found = planner.plan()
        tell("plans for its events")
        anticipate_events(planner)
    return CheckedMission(
        mission.name,
        tuple(mission.places),
        {name: event.duration for name, event in mission.events.items()},
        {c.name: c.automaton.states for c in planner.conjuncts},
        mission.priorities,
        str(found or "a tree of its own"),
        tuple(map(str, found.dropped)) if found else (),
        tuple(map(str, notices(planner, found))),
    )
