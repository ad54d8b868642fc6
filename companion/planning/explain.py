"""Explains why there is no plan: conflicting conjuncts, unreachable facts, withdrawn beliefs.

1. A minimal conflicting set is found by deletion: conjuncts are dropped one after the other, as
   long as the rest still has no plan. A violated conjunct is a reason by itself, and is dropped
   last.
2. A fact is named if these conjuncts mention it, some skill makes it true, and no sequence of
   skills reaches it. The explanation says what its skills lack. Places to which no route leads are
   named likewise.
3. A withdrawn belief is named if it alone would make the task possible again.

Planning assumes that every event keeps its value. The values of events are reported if nothing else
explains why a fact is unreachable or why lines of the task cannot hold.

This takes one search for each conjunct and belief. If a search reaches its limit, the conjunct
stays in the set, and the belief is not named.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace

from companion.errors import NoPlanError
from companion.mission.facts import AT, Fact, at
from companion.mission.model import Mission
from companion.mission.places import Place
from companion.planning.domain import Action
from companion.planning.instances import departures, instantiate
from companion.planning.lasso import Conjunct, Problem
from companion.planning.remarks import remarks_on
from companion.slices import spent

_ACTION_US = 1


@dataclass(frozen=True, slots=True)
class WorldModel:
    """What is known about a mission but is not part of a problem.

    Attributes:
        events: the facts that the vehicle cannot choose.
        closed_moves: moves of the mission for which the map has no route.
        enclosed: a line of text for each place that lies in the region of another one.
    """

    events: frozenset[Fact] = frozenset()
    enclosed: Callable[[frozenset[str]], tuple[str, ...]] = lambda places: ()
    closed_moves: Callable[[frozenset[str]], Iterable[Action]] = lambda places: ()


NOTHING_MORE = WorldModel()
"""Neither events nor places without a route."""


def world_of(
    mission: Mission, problem: Problem, left_out: Collection[str] = frozenset()
) -> WorldModel:
    """The world model of a mission, for one of its problems.

    Args:
        mission: the mission of the problem.
        problem: the problem.
        left_out: names of moves that have a route, but that the problem lacks for another reason.
    """

    def closed_moves(places: frozenset[str]) -> Iterator[Action]:
        def flight_time(origin: str, goal: str) -> float:
            return 0.0 if goal in places else math.inf

        known = {action.name for action in problem.actions}.union(left_out)
        described = instantiate(mission, flight_time).actions
        anywhere = departures(mission, flight_time)
        return (action for action in (*described, *anywhere) if action.name not in known)

    def enclosed(places: frozenset[str]) -> tuple[str, ...]:
        task = mission.task_facts
        others = [p for p in mission.places.values() if at(p.name) in task and not p.found_by]
        pairs = [(mission.places[name], other) for name in sorted(places) for other in others]
        return tuple(
            f"{place.name} lies in the region of {other.name}, seen from above, which no way "
            "enters, at any height"
            for place, other in pairs
            if place is not other and _is_over(place, other)
        )

    events = frozenset(event.fact for event in mission.events.values())
    return WorldModel(events, enclosed, closed_moves)


def _is_over(place: Place, other: Place) -> bool:
    """Whether a place lies in the region of another one, seen from above."""
    level = (*place.position[:2], other.position[2])
    return other.region.away_m(other.position, level) <= 0


IsSolvable = Callable[[Problem], bool | None]
"""Whether a problem has a plan; None if the search reaches its limit."""

Reasons = Callable[[Problem], tuple[str, ...]]
"""Reasons why a problem has no plan, one line each."""

_MAX_SHOWN = 6  # alternatives that are listed in words


@dataclass(frozen=True, slots=True)
class Unreachable:
    """A fact that no skill can make true from here.

    Attributes:
        needs: for each skill that makes it true, the facts that are missing.
    """

    fact: Fact
    needs: tuple[frozenset[Fact], ...]

    def __str__(self) -> str:
        options = [" and ".join(sorted(needed)) for needed in self.needs]
        more = " or ..." if len(options) > _MAX_SHOWN else ""
        listed = " or ".join(options[:_MAX_SHOWN]) + more
        return f"{self.fact} can never become true: that needs {listed}"


@dataclass(frozen=True, slots=True)
class Explanation:
    """Why a problem has no plan.

    Attributes:
        conflict: a minimal set of conjuncts that cannot hold together.
        unreachable: facts of these conjuncts that cannot be made true.
        no_route: places that they need, and to which the map has no route.
        events: the present values of events, kept in every plan, if these may be the reason.
        withdrawn: the beliefs that were withdrawn.
        restoring: those withdrawn beliefs each of which would make a plan possible again.
        shortages: why the battery does not last, in words.
        late: which time bounds cannot be kept, and from which limit on they could, in words.
        remarks: hints on lines that are often written this way and never hold.
        violated: the lines of the conflict that no continuation of the word can satisfy.
        barred: skills that are not done again, because it is not known whether they were done.
    """

    conflict: tuple[Conjunct, ...]
    unreachable: tuple[Unreachable, ...]
    no_route: tuple[str, ...]
    events: Mapping[Fact, bool]
    withdrawn: tuple[Fact, ...]
    restoring: tuple[Fact, ...]
    shortages: tuple[str, ...] = ()
    late: tuple[str, ...] = ()
    remarks: tuple[str, ...] = ()
    violated: tuple[str, ...] = ()
    barred: tuple[str, ...] = ()

    def __str__(self) -> str:
        return self.in_words({})

    def in_words(self, lines: Mapping[str, int]) -> str:
        """The explanation in words; `lines` gives the line numbers of parts, by their names."""
        names = list(dict.fromkeys(conjunct.name for conjunct in self.conflict))
        together = " together" if len(self.conflict) > 1 else ""
        words = [f"no plan: {', '.join(names)} cannot hold{together} from here."]
        if not names:  # rest is always possible, except for the energy that it takes
            words = ["no plan: nothing that begins here ends safely, the reserve left."]
        for conjunct in self.conflict:
            place = f"  (line {lines[conjunct.name]})" if conjunct.name in lines else ""
            words.append(f"  {conjunct.name}: {conjunct.text}{place}")
        words += [f"  {name} is violated, whatever is done now" for name in self.violated]
        words += [f"  {unreachable}" for unreachable in self.unreachable]
        words += [f"  no route leads to {place} on the map" for place in self.no_route]
        words += [f"  {reason}" for reason in (*self.shortages, *self.late, *self.remarks)]
        if self.barred:
            known = "it is not known whether that was done"
            words.append(f"  not done again: {', '.join(self.barred)}, as {known}")
        if self.events:
            values = ", ".join(f"{e} is {str(holds).lower()}" for e, holds in self.events.items())
            words.append(f"  a plan takes events as they are now: {values}")
        if self.withdrawn:
            words.append(f"  withdrawn: {', '.join(self.withdrawn)}")
        if self.restoring:
            words.append(f"  with {' or '.join(self.restoring)} there would be a plan")
        return "\n".join(words)

    def as_json(self) -> dict[str, object]:
        """The explanation as JSON values."""
        return {
            "conflict": [{"name": c.name, "formula": c.text} for c in self.conflict],
            "unreachable": [
                {"fact": u.fact, "needs": [sorted(needed) for needed in u.needs]}
                for u in self.unreachable
            ],
            "no_route": list(self.no_route),
            "events": dict(self.events),
            "withdrawn": list(self.withdrawn),
            "restoring": list(self.restoring),
            "shortages": list(self.shortages),
            "late": list(self.late),
            "barred": list(self.barred),
        }


class NoPlan(NoPlanError):
    """There is no plan; carries the explanation, with line numbers of the mission file if given."""

    def __init__(self, explanation: Explanation, lines: Mapping[str, int] | None = None) -> None:
        self.explanation = explanation
        super().__init__(explanation.in_words(lines or {}))


def why_no_plan(
    problem: Problem,
    is_solvable: IsSolvable,
    world: WorldModel = NOTHING_MORE,
    shortages: Reasons = lambda problem: (),
    late: Reasons = lambda problem: (),
) -> Explanation:
    """The reason why a problem has no plan.

    Args:
        problem: the problem.
        is_solvable: the search.
        world: what is known beside the problem.
        shortages: says why the battery does not last, for a problem without a plan.
        late: says which time bounds cannot be kept in it.
    """
    if problem.energy is not None and is_solvable(replace(problem, energy=None)) is False:
        problem = replace(problem, energy=None)  # the battery is not the reason
    core = list(range(len(problem.conjuncts)))  # indices of a conflicting set
    for i in sorted(core, key=lambda i: not problem.automaton_states[i]):
        rest = [j for j in core if j != i]
        if is_solvable(problem.only(rest)) is False:
            core = rest
    withdrawn, restoring = tuple(sorted(problem.withdrawn)), []
    for belief in withdrawn:
        if is_solvable(_with(problem, belief)):
            restoring.append(belief)
    conflict = tuple(problem.conjuncts[i] for i in core)
    mentioned = frozenset[Fact]().union(*(conjunct.facts for conjunct in conflict))
    reached = _relaxed_reach(problem)
    unreachable = _unreachable(problem, mentioned, reached)
    needed = frozenset[Fact]().union(*(lack for fact in unreachable for lack in fact.needs))
    no_route = _without_route(problem, mentioned | needed, reached, world)
    concerned = needed if unreachable or no_route else mentioned | _in_the_way(problem)
    short = shortages(problem.only(core)) if problem.energy is not None else ()
    too_late = late(problem.only(core))
    named = frozenset(fact.arguments[0] for fact in mentioned if fact.predicate == AT)
    lost = [problem.conjuncts[i] for i in core if not problem.automaton_states[i]]
    violated = tuple(conjunct.name for conjunct in lost)
    is_known = bool(short or too_late) or any(conjunct.bound for conjunct in lost)
    told = () if is_known else sorted(concerned & world.events)
    events = {event: event in problem.facts for event in told}
    return Explanation(
        conflict=conflict,
        unreachable=unreachable,
        no_route=no_route,
        events=events,
        withdrawn=withdrawn,
        restoring=tuple(restoring),
        shortages=short,
        late=too_late,
        remarks=(*remarks_on(conflict, problem.facts), *world.enclosed(named)),
        violated=violated,
        barred=tuple(sorted(problem.barred)),
    )


def _with(problem: Problem, belief: Fact) -> Problem:
    return replace(problem, facts=problem.facts | {belief})


def _unreachable(
    problem: Problem, mentioned: frozenset[Fact], reached: frozenset[Fact]
) -> tuple[Unreachable, ...]:
    """Facts that some skill makes true, but that cannot be reached from here."""
    found = []
    for fact in sorted(mentioned - reached):
        spent(_ACTION_US * len(problem.actions))
        makers = [action for action in problem.actions if fact in _added(action)]
        needs = tuple(dict.fromkeys(action.requires - reached for action in makers))
        if makers:
            found.append(Unreachable(fact, needs))
    return tuple(found)


def _without_route(
    problem: Problem, facts: frozenset[Fact], reached: frozenset[Fact], world: WorldModel
) -> tuple[str, ...]:
    """Places that are unreachable because of a missing route, not a belief or another fact."""
    sought = {fact for fact in facts - reached if fact.predicate == AT}
    if not sought:
        return ()
    begun = (a for a in problem.actions if a.requires - a.assumes <= reached)
    sought -= frozenset[Fact]().union(*map(_added, begun))
    places = frozenset(fact.arguments[0] for fact in sought)
    could_begin = (m for m in world.closed_moves(places) if m.requires - m.assumes <= reached)
    closed = frozenset[Fact]().union(*map(_added, could_begin))
    return tuple(sorted(fact.arguments[0] for fact in sought & closed))


def _in_the_way(problem: Problem) -> frozenset[Fact]:
    """Facts that hold and that some skill forbids."""
    return problem.facts & frozenset[Fact]().union(*(a.forbids for a in problem.actions))


def _relaxed_reach(problem: Problem) -> frozenset[Fact]:
    """All facts that may ever hold, if actions neither delete nor forbid anything."""
    reached = problem.facts
    while True:
        spent(_ACTION_US * len(problem.actions))
        grown = reached.union(*(_added(a) for a in problem.actions if a.requires <= reached))
        if grown == reached:
            return reached
        reached = grown


def _added(action: Action) -> frozenset[Fact]:
    return action.adds.union(*(effect.adds for effect in action.conditional))
