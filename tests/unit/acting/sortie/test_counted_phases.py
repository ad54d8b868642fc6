"""Time counts for bounds in the same phases in flight and in the audit."""

from __future__ import annotations

from companion.acting.sortie.flown_task import CLOCKED
from companion.flight_events.sortie import Phase
from companion.record.events import ENDS_THE_TASK


def test_a_phase_counts_or_ends_the_task_or_comes_before_it() -> None:
    before_or_after = (Phase.WAITING, Phase.CHECKING, Phase.ENDED)
    sorts = [*CLOCKED, *ENDS_THE_TASK, *before_or_after]
    assert len(sorts) == len(Phase) and set(sorts) == set(Phase)
