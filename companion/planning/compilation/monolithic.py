"""Makes one automaton for a whole task, as the paper's compilation needs it.

The paper translates the whole formula. That requires a single history. If an event has restarted
some conjuncts but not others, the product of the conjuncts' automata is used instead, which accepts
the same words. What cannot change is removed from the automaton before its marks move to states.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import reduce

from companion.ltl.automaton import BuchiAutomaton, Label, Transition, successors
from companion.ltl.budget import TranslationLimit
from companion.ltl.first_letter import with_first_letter
from companion.ltl.formula import Formula, Operator
from companion.ltl.restriction import restricted
from companion.ltl.translate import state_based, translate
from companion.planning.compilation.reduced_task import ReducedTask, reduced_task
from companion.planning.lasso import Conjunct, Letter, Problem

MAX_STATES = 10_000


def monolithic(
    problem: Problem,
    histories: Sequence[Sequence[Letter]],
    translation: Callable[[Formula], BuchiAutomaton] = translate,
) -> Problem:
    """The problem with one state-based automaton, valid while its constants keep their values.

    Args:
        problem: a problem with the automata of its conjuncts.
        histories: for each conjunct, the letters that it has read, including that of the present
            position.
        translation: makes the automaton of the whole formula.

    Raises:
        TranslationLimit: the automaton would be too large.
    """
    task = reduced_task(problem)
    formulas = tuple(conjunct.formula for conjunct in problem.conjuncts)
    whole = Formula(Operator.AND, formulas) if len(formulas) > 1 else formulas[0]
    if all(list(history) == list(histories[0]) for history in histories):
        automaton = translation(whole)
        states = automaton.initial
        for letter in histories[0]:
            states = successors(automaton, states, letter)
        if problem.unread:
            automaton = with_first_letter(automaton, states, problem.unread)
            states = automaton.initial
        automaton = _rest(task, automaton, states)
    else:
        pairs = zip(problem.conjuncts, problem.automaton_states, strict=True)
        automaton = reduce(_product, (_rest(task, c.automaton, states) for c, states in pairs))
    automaton = state_based(automaton)
    name = " & ".join(conjunct.name for conjunct in problem.conjuncts)
    return replace(
        problem,
        conjuncts=(Conjunct(name, whole, automaton),),
        automaton_states=(automaton.initial,),
        waiting_since_ms=(),
    )


def _rest(task: ReducedTask, automaton: BuchiAutomaton, states: frozenset[int]) -> BuchiAutomaton:
    """The automaton under the constants; its initial states are those that it may be in now."""
    rest = restricted(automaton, task.constants(automaton.propositions))
    return replace(rest.automaton, initial=frozenset(rest.states(states)))


def _product(left: BuchiAutomaton, right: BuchiAutomaton) -> BuchiAutomaton:
    """An automaton that accepts what both accept; the marks of the right one come last."""
    pending = [(a, b) for a in sorted(left.initial) for b in sorted(right.initial)]
    number_of = {pair: number for number, pair in enumerate(pending)}
    initial = frozenset(number_of.values())
    transitions = []
    for a, b in pending:  # grows while it is read
        for t in left.outgoing[a]:
            for u in right.outgoing[b]:
                label = Label(
                    t.label.positive | u.label.positive, t.label.negative | u.label.negative
                )
                if label.positive & label.negative:
                    continue
                target = (t.target, u.target)
                if target not in number_of:
                    number_of[target] = len(pending)
                    pending.append(target)
                marks = t.marks.union(left.marks + mark for mark in u.marks)
                transitions.append(Transition(number_of[a, b], label, number_of[target], marks))
        if max(len(pending), len(transitions)) > 10 * MAX_STATES or len(pending) > MAX_STATES:
            limit, advice = f"{MAX_STATES:,} states for the whole task", "use --encoding v4 or v5"
            raise TranslationLimit(limit, advice=advice)
    name = f"({left.name}) & ({right.name})"
    marks_count = left.marks + right.marks
    return BuchiAutomaton(len(pending), initial, tuple(transitions), marks_count, name)
