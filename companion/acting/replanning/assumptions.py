"""The assumptions of the present plan about events and beliefs, and which have turned out wrong.

A plan assumes that every event keeps its value. A change matters only if the event is mentioned in
the task or in the precondition of an action still to come, or if lines begin anew with it. An event
that was true for a moment matters, too, because the next letter contains it. A plan also assumes
that withdrawn beliefs stay withdrawn; if one comes back, a better plan may be possible.
"""

from __future__ import annotations

import math
from collections.abc import Iterable

from companion.acting.flight import Flight
from companion.flight_events.facts import in_words
from companion.mission.facts import Fact
from companion.planning.lasso import Lasso
from companion.planning.planner import Planner
from companion.planning.situation import unread_events

FLAPPING_S = 1.0
"""Within this time, several changes of one event make only one new plan."""
BELIEF_CAME_BACK = "a belief came back"
"""The reason for a new plan if nothing has gone wrong with the old one."""


class Assumptions:
    """The values of events that the present plan relies on.

    Attributes:
        may_do_better: a belief has come back since the plan was made.
        unread: the events on which no plan depends.

    Args:
        planner: of the mission with the events.
        flight: knows what holds now.
    """

    def __init__(self, planner: Planner, flight: Flight) -> None:
        self._planner = planner
        self._flight = flight
        events = planner.mission.events.values()
        self._always = planner.task_facts.union(each.fact for each in events if each.restarts)
        self.unread = unread_events(planner.mission)
        self._values: dict[Fact, bool] = {}
        self._foreseen = self._noted = frozenset[Fact]()
        self._positions = 0
        self._replanned_s: dict[Fact, float] = {}
        self.may_do_better = False

    def note_restored_beliefs(self) -> None:
        """Beliefs have come back: another plan may be better."""
        self.may_do_better = True

    def forget_restored_beliefs(self) -> None:
        """A plan is made, or was asked for, with the beliefs that have come back."""
        self.may_do_better = False

    def note_wrong(self) -> None:
        """Remembers what is wrong now until the next plan is made, whatever changes meanwhile.

        Needed while a skill on the ground is finished first, before anybody may react.
        """
        self._noted |= frozenset(self.wrong)

    def note_replan(self, events: Iterable[Fact]) -> None:
        """A new plan is due now, for these events among other things."""
        self._replanned_s |= dict.fromkeys(events, self._flight.now_s)

    @property
    def flapping(self) -> frozenset[Fact]:
        """The events that have just led to a new plan; for a second, they lead to no other."""
        return frozenset(filter(self._may_flap, self._replanned_s))

    def renew(self) -> None:
        """Notes the present values of all events, which the plan that is made now assumes.

        On the way home after a violation, only those events count by which all violated lines begin
        anew.
        """
        task = self._flight.task
        violated = set(task.violated)
        self._values = {
            event.fact: event.fact in task.facts
            for event in self._planner.mission.events.values()
            if violated <= event.restarts
        }
        self._foreseen, self._positions = task.word.risen, task.word.positions
        self._noted = frozenset()

    def narrow(self, lasso: Lasso) -> None:
        """Forgets the events that do not matter for the rest of a plan."""
        others = self._values.keys() - self._always
        if not others:
            return
        left = (*lasso.prefix[self._flight.progress.completed :], *lasso.loop)
        for fact in others.difference(*(a.requires | a.forbids for a in left)):
            del self._values[fact]

    @property
    def watched(self) -> frozenset[Fact]:
        """The events whose next change matters, without those that may be flapping."""
        return frozenset(fact for fact in self._values if not self._may_flap(fact))

    @property
    def wrong(self) -> list[Fact]:
        """The events that differ from the assumption now, in the next letter, or did so before.

        An event that has just led to a new plan may be flapping, and is left out for a second.
        """
        task = self._flight.task
        is_still_unread = task.word.positions == self._positions
        news = task.word.risen - self._foreseen if is_still_unread else task.word.risen
        read_next = task.facts | news
        return [
            fact
            for fact, holds in self._values.items()
            if (
                (fact in task.facts) != holds or (fact in read_next) != holds or fact in self._noted
            )
            and not self._may_flap(fact)
        ]

    def _may_flap(self, fact: Fact) -> bool:
        """Whether it has just made a new plan."""
        return self._flight.now_s - self._replanned_s.get(fact, -math.inf) < FLAPPING_S

    @property
    def surprise(self) -> str | None:
        """The wrong assumptions in words; None if there are none."""
        facts = self._flight.task.facts
        changes = (in_words(fact, fact in facts or not self._values[fact]) for fact in self.wrong)
        return "; ".join(changes) or None

    @property
    def news(self) -> str | None:
        """What has changed since the last search for a plan, in words; None if nothing has."""
        changes = self.surprise, BELIEF_CAME_BACK if self.may_do_better else None
        return "; ".join(filter(None, changes)) or None
