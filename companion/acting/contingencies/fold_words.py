"""Folded contingencies in words, for the lines of a table that people read."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby

from companion.acting.contingencies.answers import LandsAt, Replans, StaysWhereItIs, short_of
from companion.acting.contingencies.table import FoldedContingencies

SHOWN_LABELS = 8
"""The most changes with the same answer that are named."""
SHOWN_ACTIONS = 5
"""The most actions of a plan that are named."""


def labels_in_words(fold: FoldedContingencies) -> str:
    """The changes, in words."""
    more = len(fold.labels) - SHOWN_LABELS
    shown = "; ".join(fold.labels[:SHOWN_LABELS])
    return f"{shown}; and {more} more" if more > 0 else shown


def positions_in_words(positions: Sequence[int]) -> str:
    """Positions by number, in words.

    >>> positions_in_words([0, 1, 2, 3, 5, 7, 8])
    '0-3, 5, 7, 8'
    """
    runs = groupby(enumerate(positions), key=lambda pair: pair[1] - pair[0])
    found = [[number for _, number in run] for _, run in runs]
    return ", ".join(
        f"{run[0]}-{run[-1]}" if len(run) > 2 else ", ".join(map(str, run)) for run in found
    )


def answers_in_words(fold: FoldedContingencies) -> str:
    """What the flight does, in words."""
    answers = fold.answers
    match answers[0]:
        case Replans():
            return _plans_in_words([a for a in answers if isinstance(a, Replans)])
        case LandsAt() as lands:
            worst = max((a for a in answers if isinstance(a, LandsAt)), key=lambda a: a.missing_wh)
            return f"{worst}{_why(lands.why, lands.waits_for)}"
        case StaysWhereItIs() as stays:
            return f"{stays}{_why(stays.why, stays.waits_for)}"
    return str(answers[0])


def _why(why: str, waits_for: tuple[str, ...]) -> str:
    waits = f", after waiting for {' or '.join(waits_for)}" if waits_for else ""
    return f"{waits} ({why.removeprefix('no plan: ').rstrip('.')})"


def _plans_in_words(answers: Sequence[Replans]) -> str:
    plan, dropped = answers[0].plan, answers[0].dropped
    waited = [a.waited_s for a in answers if a.waited_s]
    ways_s = [a.plan.prefix_cost_s for a in answers]
    way = _span_s(ways_s)
    if len(plan.loop) == 1 and plan.loop[0].skill == "wait":
        text = f"{_some([step.action for step in plan.prefix])}, then rest: {way}"
    else:
        laps = _span_s([a.plan.lap_cost_s for a in answers])
        text = f"lap of {laps}: {_some([step.action for step in plan.loop])}; the way there {way}"
    if waited:
        text = f"after {_span_s(waited)} of waiting: {text}"
    text += f"; without {', '.join(dropped)}" if dropped else ""
    return text + short_of(max(a.reserve_wh for a in answers), 0.0)


def _some(actions: Sequence[str]) -> str:
    if len(actions) <= SHOWN_ACTIONS:
        return ", ".join(actions) or "nothing"
    return f"{', '.join(actions[:SHOWN_ACTIONS])} and {len(actions) - SHOWN_ACTIONS} more"


def _span_s(seconds: Sequence[float]) -> str:
    least, most = f"{min(seconds):.1f}", f"{max(seconds):.1f}"
    return f"{least} s" if least == most else f"{least} to {most} s"
