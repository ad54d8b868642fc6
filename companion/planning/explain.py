"""The reason why there is no plan: conjuncts that conflict, facts out of reach, lost beliefs.

A smallest conflicting set is found by deletion: drop one conjunct after the other for as long
as the rest still has no plan. Facts that these conjuncts mention, that some skill makes true, and
that no sequence of skills can reach are named with what their skills lack. If one withdrawn
belief alone would make the task possible again, it is named.

That takes a search per conjunct and per belief, so in flight it is done in parts (`explaining`).
What a search cannot answer within its limit leaves the conjunct in the set, and the belief out.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

from companion.errors import NoPlanError
from companion.mission.facts import Fact
from companion.planning.domain import Action
from companion.planning.lasso import Conjunct, Problem

IsSolvable = Callable[[Problem], bool | None]
"""Whether a problem has a plan; None if the search for one reaches its limit."""

_MAX_SHOWN = 6  # alternatives that are listed in words


@dataclass(frozen=True, slots=True)
class Unreachable:
    """A fact that no skill can make true from here.

    Attributes:
        needs: for each skill that makes it true the facts that are missing.
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
        conflict: a smallest set of conjuncts that cannot hold together.
        unreachable: facts mentioned in them that cannot be made true.
        withdrawn: the beliefs that were withdrawn.
        restoring: those of them that would each make a plan possible again.
    """

    conflict: tuple[Conjunct, ...]
    unreachable: tuple[Unreachable, ...]
    withdrawn: tuple[Fact, ...]
    restoring: tuple[Fact, ...]

    def __str__(self) -> str:
        names = list(dict.fromkeys(conjunct.name for conjunct in self.conflict))
        together = " together" if len(self.conflict) > 1 else ""
        lines = [f"no plan: {', '.join(names)} cannot hold{together} from here."]
        lines += [f"  {conjunct.name}: {conjunct.formula}" for conjunct in self.conflict]
        lines += [f"  {unreachable}" for unreachable in self.unreachable]
        if self.withdrawn:
            lines.append(f"  withdrawn: {', '.join(self.withdrawn)}")
        if self.restoring:
            lines.append(f"  with {' or '.join(self.restoring)} there would be a plan")
        return "\n".join(lines)

    def as_json(self) -> dict[str, object]:
        """The explanation as JSON values."""
        return {
            "conflict": [{"name": c.name, "formula": str(c.formula)} for c in self.conflict],
            "unreachable": [
                {"fact": u.fact, "needs": [sorted(needed) for needed in u.needs]}
                for u in self.unreachable
            ],
            "withdrawn": list(self.withdrawn),
            "restoring": list(self.restoring),
        }


class NoPlan(NoPlanError):
    """There is no plan, with the explanation."""

    def __init__(self, explanation: Explanation) -> None:
        self.explanation = explanation
        super().__init__(str(explanation))


def why_no_plan(problem: Problem, is_solvable: IsSolvable) -> Explanation:
    """The reason why a problem has no plan."""
    return next(filter(None, explaining(problem, is_solvable)))


def explaining(problem: Problem, is_solvable: IsSolvable) -> Iterator[Explanation | None]:
    """Finds the reason in parts of one search each: None until it is found."""
    core = list(range(len(problem.conjuncts)))  # indices of a conflicting set
    for i in tuple(core):
        rest = [j for j in core if j != i]
        if is_solvable(_only(problem, rest)) is False:
            core = rest
        yield None
    withdrawn, restoring = tuple(sorted(problem.withdrawn)), []
    for belief in withdrawn:
        if is_solvable(_with(problem, belief)):
            restoring.append(belief)
        yield None
    conflict = tuple(problem.conjuncts[i] for i in core)
    unreachable = _unreachable(problem, conflict)
    yield Explanation(conflict, unreachable, withdrawn, tuple(restoring))


def _only(problem: Problem, indices: list[int]) -> Problem:
    return replace(
        problem,
        conjuncts=tuple(problem.conjuncts[i] for i in indices),
        automaton_states=tuple(problem.automaton_states[i] for i in indices),
    )


def _with(problem: Problem, belief: Fact) -> Problem:
    return replace(problem, facts=problem.facts | {belief})


def _unreachable(problem: Problem, conflict: tuple[Conjunct, ...]) -> tuple[Unreachable, ...]:
    """Facts of some conjuncts that skills make true in principle, but not from here."""
    reached = _relaxed_reach(problem)
    mentioned = frozenset[Fact]().union(*(conjunct.facts for conjunct in conflict))
    found = []
    for fact in sorted(mentioned - reached):
        makers = [action for action in problem.actions if fact in _added(action)]
        needs = tuple(dict.fromkeys(action.requires - reached for action in makers))
        if makers:
            found.append(Unreachable(fact, needs))
    return tuple(found)


def _relaxed_reach(problem: Problem) -> frozenset[Fact]:
    """Every fact that might hold at some time: actions without what they delete and forbid."""
    reached = problem.facts
    while True:
        grown = reached.union(*(_added(a) for a in problem.actions if a.requires <= reached))
        if grown == reached:
            return reached
        reached = grown


def _added(action: Action) -> frozenset[Fact]:
    return action.adds.union(*(effect.adds for effect in action.conditional))
