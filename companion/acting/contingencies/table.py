"""The table of contingencies: the outcome of a flight for each change at each position."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from companion.acting.contingencies.answers import (
    Answer,
    ContingencyVerdict,
    LandsAt,
    Replans,
    StaysWhereItIs,
)
from companion.acting.contingencies.changes import Change, EventTurns
from companion.flight_events.writing import json_of


@dataclass(frozen=True, slots=True)
class PlanPosition:
    """A position of the first plan, up to the end of its first lap.

    Attributes:
        number: number of completed actions.
        place: where the vehicle is; "" if at no place.
        ahead: the action that begins there.
        is_in_loop: whether that action belongs to the loop.
        level: the level of the energy, in units, of the lap in which it is lowest; None without a
            battery.
        charge_percent: that level, as a gauge shows it.
    """

    number: int
    place: str
    ahead: str
    is_in_loop: bool
    level: int | None = None
    charge_percent: float | None = None

    def as_json(self) -> dict[str, Any]:
        """The same as JSON data."""
        return {
            "position": self.number,
            "place": self.place,
            "ahead": self.ahead,
            "loop": self.is_in_loop,
            "charge_percent": self.charge_percent,
        }


@dataclass(frozen=True, slots=True)
class Contingency:
    """A change at a position, and what the flight does.

    Attributes:
        position: number of the position.
        change: what changes.
        answer: what the flight does.
        after: an event that came at the position before; then the change is about the plan for that
            event.
    """

    position: int
    change: Change
    answer: Answer
    after: EventTurns | None = None

    @property
    def label(self) -> str:
        """The change, in words."""
        return str(self.change) if self.after is None else f"{self.after}, then {self.change}"

    def as_json(self) -> dict[str, Any]:
        """The same as JSON data."""
        answer, told = self.answer, dict[str, Any]()
        match answer:
            case Replans(plan, dropped, waited_s):
                told = json_of(plan) | {"dropped": list(dropped), "waited_s": waited_s}
                told |= {"of_reserve_wh": round(answer.reserve_wh, 2)}
            case LandsAt():
                told = {
                    "lands_at": answer.place,
                    "of_reserve_wh": round(answer.missing_wh - answer.short_wh, 2),
                    "missing_wh": round(answer.short_wh, 2),
                }
            case StaysWhereItIs():
                told = {"does": answer.does}
        if isinstance(answer, LandsAt | StaysWhereItIs):
            told |= {"why": answer.why, "waits_for": list(answer.waits_for)}
        return {
            "position": self.position,
            "kind": self.change.kind,
            "subject": self.change.subject,
            "after": None if self.after is None else self.after.event,
            "contingency": self.label,
            "verdict": self.answer.verdict.name.lower(),
            **told,
        }


@dataclass(frozen=True, slots=True)
class FoldedContingencies:
    """Contingencies of one kind with equal answers, at equal positions.

    Attributes:
        labels: the changes.
        positions: the positions at which they come.
        answers: one for each contingency; they differ only in the way into the loop.
    """

    kind: str
    labels: tuple[str, ...]
    positions: tuple[int, ...]
    answers: tuple[Answer, ...]


@dataclass(frozen=True)
class ContingencyTable:
    """All contingencies of a mission's first plan, in a fixed order.

    Attributes:
        mission: its name.
        plan: its first plan, as text.
        positions: the positions of that plan.
        contingencies: by position, and at each position in the order of the mission file.
    """

    mission: str
    plan: str
    positions: tuple[PlanPosition, ...]
    contingencies: tuple[Contingency, ...]

    @property
    def unsafe(self) -> tuple[Contingency, ...]:
        """The contingencies after which no safe place can be reached with the charge."""
        unsafe = ContingencyVerdict.UNSAFE
        return tuple(c for c in self.contingencies if c.answer.verdict is unsafe)

    @property
    def labels(self) -> tuple[str, ...]:
        """The possible changes, by kind, in the order of first appearance."""
        kinds = dict.fromkeys(_kind(each) for each in self.contingencies)
        found = (each.label for kind in kinds for each in self.contingencies if _kind(each) == kind)
        return tuple(dict.fromkeys(found))

    @property
    def summary(self) -> str:
        """The whole table in one line."""
        answers = [each.answer for each in self.contingencies]
        verdicts = Counter(answer.verdict for answer in answers)
        kinds = ContingencyVerdict
        dropped = verdicts[kinds.LINES_DROPPED]
        planned = verdicts[kinds.AS_PLANNED] + verdicts[kinds.PLANNED] + dropped
        ends = Counter(a.place for a in answers if isinstance(a, LandsAt) and not a.missing_wh)
        parts = [
            f"{planned} planned" + (f" ({dropped} with lines dropped)" if dropped else ""),
            *(f"{count} end at {place}" for place, count in sorted(ends.items())),
        ]
        if on_reserve := verdicts[kinds.ON_RESERVE]:
            parts.append(f"{on_reserve} land on the reserve")
        if stays := verdicts[kinds.WHERE_IT_IS]:
            parts.append(f"{stays} end where the vehicle is")
        parts.append(f"{verdicts[kinds.UNSAFE]} unsafe")
        return f"{len(answers)} contingencies: {', '.join(parts)}"

    def __str__(self) -> str:
        return self.summary

    def folded(self) -> Iterator[FoldedContingencies]:
        """Contingencies with equal answers, joined so that people can read them."""
        by_label: dict[tuple[str, str, object], list[Contingency]] = {}
        for each in self.contingencies:
            key = _kind(each), each.label, _same(each.answer)
            by_label.setdefault(key, []).append(each)
        folds: dict[object, FoldedContingencies] = {}
        order = {label: number for number, label in enumerate(self.labels)}
        for (kind, label, same), members in sorted(by_label.items(), key=lambda x: order[x[0][1]]):
            positions = tuple(each.position for each in members)
            found = tuple(each.answer for each in members)
            fold = kind, positions, same
            before = folds.get(fold)
            labels = (label,) if before is None else (*before.labels, label)
            answers = found if before is None else (*before.answers, *found)
            folds[fold] = FoldedContingencies(kind, labels, positions, answers)
        yield from folds.values()

    def as_json(self) -> dict[str, Any]:
        """The table as JSON data."""
        verdicts = Counter(each.answer.verdict for each in self.contingencies)
        return {
            "plan": self.plan,
            "positions": [position.as_json() for position in self.positions],
            "contingencies": [each.as_json() for each in self.contingencies],
            "verdicts": {each.name.lower(): verdicts[each] for each in ContingencyVerdict},
            "summary": self.summary,
        }


def _kind(contingency: Contingency) -> str:
    after = contingency.after
    return contingency.change.kind if after is None else f"{after.kind}, then"


def _same(answer: Answer) -> object:
    """What two answers shown as one have in common: the loop, but not the way into it."""
    match answer:
        case Replans(plan, dropped, waited_s):
            loop = [step.action for step in plan.loop]
            first = min(range(len(loop)), key=lambda i: loop[i:] + loop[:i])
            kept = loop[first:] + loop[:first]
            if len(loop) == 1:  # it ends at rest, so all it does is on the way there
                kept = [*(step.action for step in plan.prefix), *loop]
            return answer.verdict, tuple(kept), dropped, waited_s > 0
        case LandsAt():
            return answer.verdict, answer.place, answer.waits_for
        case StaysWhereItIs():
            return answer.verdict, answer.does, answer.waits_for
    return answer.verdict
