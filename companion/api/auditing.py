"""Judges recorded flights by their task."""

from __future__ import annotations

from pathlib import Path

from companion.api.results import FlightResult
from companion.arguments import path_of
from companion.record import audit as auditing
from companion.record.audit import Audit
from companion.record.events import read_events, record_of


def audit(run: Path | str | FlightResult) -> Audit:
    """Judges a flight by its task, conjunct by conjunct.

    >>> from companion import audit, load_mission, simulate
    >>> verdicts = audit(simulate(load_mission("missions/surveillance.yaml")))
    >>> [(finding.name, finding.outcome.value) for finding in verdicts.findings][-2:]
    [('upload', 'satisfied'), ('return', 'satisfied')]
    >>> verdicts.is_failure
    False

    Args:
        run: a run folder, or what `simulate` or `run` returned.

    Raises:
        MissionError: it is no run folder, a line of it is damaged, or the run has no plan.
        TranslationLimit: the monitor of a conjunct would be too large.
        CompanionError: `run` is of another type.
    """
    if isinstance(run, FlightResult):
        return auditing.audit(record_of(run.events))
    return auditing.audit(read_events(path_of(run, "a flight, or a run folder")))
