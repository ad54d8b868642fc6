"""The options that choose another planner than the built-in search."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from companion.planning.objective import Encoding

if TYPE_CHECKING:
    from companion.mission.model import Mission
    from companion.planning.engine_port import Engine

BUILT_IN = "built-in"
EngineOption = Annotated[
    str,
    typer.Option(
        metavar="NAME",
        help="The planner: built-in, or an engine of unified-planning such as fast-downward, or "
        "pyperplan (with --encoding v5).",
    ),
]
EncodingOption = Annotated[
    Encoding,
    typer.Option(
        help="How the task is written for an engine or --pddl. v1: one automaton, as in the "
        "paper; v4: one automaton for each conjunct; v5: as v4, without conditional effects."
    ),
]
EngineTimeout = Annotated[
    float,
    typer.Option(
        help="Let an engine plan for this many real seconds. After that, the built-in search "
        "plans. In lockstep (sim --speed max) the run ends as a failure instead.",
        min=0.1,
    ),
]
EngineDuration = Annotated[
    float,
    typer.Option(
        help="In lockstep (--speed max): simulated seconds that each plan of an engine takes.",
        min=0.0,
    ),
]
ENGINE_TIMEOUT_S = 10.0


def engine_of(
    name: str,
    encoding: Encoding,
    timeout_s: float,
    duration_s: float | None,
    mission: Mission | None,
) -> Engine | None:
    """The engine that plans a mission, if the mission is known; None for the built-in search.

    Raises:
        EngineError: there is no engine of this name here, or it cannot plan this mission.
    """
    if name == BUILT_IN:
        return None
    from companion.planning.engine_jobs import EngineJobs
    from companion.planning.engines import require

    require(name, encoding, mission)
    return EngineJobs(name, encoding, timeout_s, duration_s)
