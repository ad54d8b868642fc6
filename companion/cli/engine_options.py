"""The options by which another planner than the built-in search is chosen."""

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
        help="Who plans: built-in, or an engine of unified-planning such as fast-downward "
        "or pyperplan (with --encoding v5).",
    ),
]
EncodingOption = Annotated[
    Encoding,
    typer.Option(
        help="How engines and --pddl are told: v1 as in the paper, one automaton; v4 one "
        "automaton for each conjunct; v5 the same without conditional effects."
    ),
]
EngineTimeout = Annotated[
    float,
    typer.Option(
        help="Real seconds that an engine may take for a plan; then the built-in search plans. "
        "In lockstep (sim --speed max) the run ends as a failure.",
        min=0.1,
    ),
]
EngineDuration = Annotated[
    float,
    typer.Option(
        help="Simulated seconds that an engine takes for a plan in lockstep (--speed max).",
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
    """Who plans a mission, if that is known; None for the built-in search.

    Raises:
        EngineError: there is no engine of this name here, or it cannot plan that.
    """
    if name == BUILT_IN:
        return None
    from companion.planning.engine_jobs import EngineJobs
    from companion.planning.engines import require

    require(name, encoding, mission)
    return EngineJobs(name, encoding, timeout_s, duration_s)
