"""Missions in linear temporal logic: planned, flown on PX4-style vehicles, simulated, audited.

    from companion import load_mission, simulate
    simulate(load_mission("missions/surveillance.yaml"), seed=7).events

These are the public names; docs/python.md shows their use. Each is imported on first use (PEP 562),
so `import companion` is fast.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from companion.api.auditing import audit as audit
    from companion.api.contingency_answers import contingencies as contingencies
    from companion.api.flying import run as run
    from companion.api.formulas import parse_formula as parse_formula
    from companion.api.formulas import translate as translate
    from companion.api.results import FlightResult as FlightResult
    from companion.api.results import FlownTrajectory as FlownTrajectory
    from companion.api.simulating import SimulationResult as SimulationResult
    from companion.api.simulating import simulate as simulate
    from companion.api.trees import BehaviourTree as BehaviourTree
    from companion.api.trees import behaviour_tree as behaviour_tree
    from companion.errors import CompanionError as CompanionError
    from companion.errors import FormulaError as FormulaError
    from companion.errors import LinkError as LinkError
    from companion.errors import MissionError as MissionError
    from companion.errors import NoPlanError as NoPlanError
    from companion.errors import SearchLimit as SearchLimit
    from companion.ltl.automaton import BuchiAutomaton as BuchiAutomaton
    from companion.ltl.dot import to_dot as to_dot
    from companion.ltl.formula import Formula as Formula
    from companion.ltl.hoa import to_hoa as to_hoa
    from companion.mission.loader import load_mission as load_mission
    from companion.mission.model import Mission as Mission
    from companion.planning.domain import Action as Action
    from companion.planning.explain import Explanation as Explanation
    from companion.planning.explain import NoPlan as NoPlan
    from companion.planning.lasso import Lasso as Lasso
    from companion.planning.lasso import Solution as Solution
    from companion.planning.objective import Objective as Objective
    from companion.planning.planner import Planner as Planner
    from companion.record.audit import Audit as Audit

_EXPORTS = {
    "companion.api.auditing": "audit",
    "companion.api.contingency_answers": "contingencies",
    "companion.api.flying": "run",
    "companion.api.formulas": "parse_formula translate",
    "companion.api.results": "FlightResult FlownTrajectory",
    "companion.api.simulating": "SimulationResult simulate",
    "companion.api.trees": "BehaviourTree behaviour_tree",
    "companion.errors": "CompanionError FormulaError LinkError MissionError NoPlanError "
    "SearchLimit",
    "companion.ltl.automaton": "BuchiAutomaton",
    "companion.ltl.dot": "to_dot",
    "companion.ltl.formula": "Formula",
    "companion.ltl.hoa": "to_hoa",
    "companion.mission.loader": "load_mission",
    "companion.mission.model": "Mission",
    "companion.planning.domain": "Action",
    "companion.planning.explain": "Explanation NoPlan",
    "companion.planning.lasso": "Lasso Solution",
    "companion.planning.objective": "Objective",
    "companion.planning.planner": "Planner",
    "companion.record.audit": "Audit",
}
_MODULES = {name: module for module, names in _EXPORTS.items() for name in names.split()}
__all__ = [*_MODULES]

if not TYPE_CHECKING:

    def __getattr__(name):
        if name not in _MODULES:
            raise AttributeError(f"module 'companion' has no attribute {name!r}")
        return getattr(import_module(_MODULES[name]), name)

    def __dir__():
        return __all__
