"""The paper's compilation of a task and its Büchi automaton into classical planning (v1).

Figs. 2-4 of the paper in its own names: fluents currBA, nxtBA, reqLp, req, nreq, end, mv1Done,
BAturn, LpS, inLp, endBA, endDone; actions mvBA1 and mvBA2 (Fig. 2), actLoop and actEnd (Fig. 3),
and the actions of the task (Fig. 4). The vehicle and the automaton take turns. All states that the
automaton may be in are tracked at once; actLoop(z) keeps only one accepting state z and remembers
it together with the facts, and actEnd compares. The part of the plan between them is the loop.

Deviations from the figures, and what would go wrong otherwise:

- mvBA1 needs *not* mv1Done (Fig. 2 has it positive): otherwise no action could ever be applied.
- mvBA1 adds the successors of a state, not the state itself: otherwise the automaton would never
  move.
- Only the states after the history are current at first (Fig. 2 has all): otherwise words would be
  accepted that the formula rejects. The history includes the present position, so the vehicle has
  the turn.
- actLoop(z) deletes the other states (Fig. 3 adds them): otherwise a run that does not pass z could
  close. It exists only for accepting states, so acptBA is not needed.
- req, nreq and end are over every fact that can change, not over the formula's propositions:
  otherwise the loop could close at another place with the same label.
- actNop (Fig. 4), only once and at the end of a plan, cannot express a task whose loop is rest:
  `wait` is an ordinary action, and nopDone is gone.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from companion.ltl.automaton import BuchiAutomaton, Label
from companion.planning.compilation.classical import ClassicalAction, ClassicalProblem, Fluent
from companion.planning.compilation.reduced_task import (
    ReducedTask,
    accepting_states,
    is_state_based,
    reduced_task,
)
from companion.planning.domain import ConditionalEffect
from companion.planning.lasso import Problem
from companion.planning.objective import Encoding, Objective

MV1_DONE, BA_TURN, LP_S, IN_LP = "mv1Done", "BAturn", "LpS", "inLp"
END_BA, END_DONE = "endBA", "endDone"
NOTHING: frozenset[Fluent] = frozenset()


def curr_ba(z: int) -> Fluent:
    """The automaton may be in state z."""
    return f"currBA({z})"


def nxt_ba(z: int) -> Fluent:
    """In the middle of a move of the automaton: it will be in state z."""
    return f"nxtBA({z})"


def req_lp(z: int) -> Fluent:
    """The loop begins in state z."""
    return f"reqLp({z})"


def encode_paper(problem: Problem, objective: Objective) -> ClassicalProblem:
    """The paper's encoding of a problem with one state-based automaton.

    Raises:
        ValueError: the problem has several automata or one of another kind; `monolithic` makes one.
    """
    if len(problem.conjuncts) != 1 or not is_state_based(problem.conjuncts[0]):
        raise ValueError("encoding v1 takes one state-based automaton; monolithic() makes it")
    task = reduced_task(problem)
    automaton = problem.conjuncts[0].automaton
    states = range(automaton.states)
    accepting = sorted(accepting_states(automaton))
    facts = task.changing
    loops = [_act_loop(task, states, z) for z in accepting]
    fluents = (
        *facts,
        *(name(z) for name in (curr_ba, nxt_ba) for z in states),
        *map(req_lp, accepting),
        *(f"{name}({fact})" for name in ("req", "nreq", "end") for fact in facts),
        *(MV1_DONE, BA_TURN, LP_S, IN_LP, END_BA, END_DONE),
    )
    return ClassicalProblem(
        encoding=Encoding.V1,
        fluents=fluents,
        init=task.init | {curr_ba(z) for z in problem.automaton_states[0]},
        goal=frozenset({LP_S, IN_LP, END_BA, *(f"end({fact})" for fact in facts)}),
        actions=(
            *_performing(task, automaton, objective),
            _mv_ba1(task, automaton),
            _mv_ba2(states),
            *loops,
            _act_end(task, accepting),
        ),
        loops=frozenset(action.name for action in loops),
    )


def _mv_ba1(task: ReducedTask, automaton: BuchiAutomaton) -> ClassicalAction:
    """Fig. 2: the automaton reads the facts; the states where it may go are stored."""
    return ClassicalAction(
        "mvBA1",
        requires=frozenset({BA_TURN}),
        forbids=frozenset({MV1_DONE, END_DONE}),
        adds=frozenset({MV1_DONE}),
        deletes=frozenset(map(curr_ba, range(automaton.states))),
        conditional=tuple(
            ConditionalEffect(
                label.positive | {curr_ba(t.source)},
                label.negative,
                frozenset({nxt_ba(t.target)}),
                NOTHING,
            )
            for t in automaton.transitions
            if (label := _possible(task, t.label)) is not None
        ),
    )


def _possible(task: ReducedTask, label: Label) -> Label | None:
    """The part of a label about facts that change; None if constants contradict the label."""
    constants = task.constants(label.positive | label.negative)
    if not all(value == (p in label.positive) for p, value in constants.items()):
        return None
    fixed = frozenset(constants)
    return Label(label.positive - fixed, label.negative - fixed)


def _mv_ba2(states: range) -> ClassicalAction:
    """Fig. 2: the automaton enters the stored states, and the vehicle has the turn."""
    return ClassicalAction(
        "mvBA2",
        requires=frozenset({MV1_DONE}),
        deletes=frozenset({MV1_DONE, BA_TURN, *map(nxt_ba, states)}),
        conditional=tuple(
            ConditionalEffect(frozenset({nxt_ba(z)}), NOTHING, frozenset({curr_ba(z)}), NOTHING)
            for z in states
        ),
    )


def _act_loop(task: ReducedTask, states: range, z: int) -> ClassicalAction:
    """Fig. 3: the loop begins here, in the accepting state z and in no other."""
    return ClassicalAction(
        f"actLoop({z})",
        requires=frozenset({curr_ba(z)}),
        forbids=frozenset({BA_TURN, LP_S, END_DONE}),
        adds=frozenset({LP_S, req_lp(z)}),
        deletes=frozenset(curr_ba(other) for other in states if other != z),
        conditional=tuple(_remember(task)),
    )


def _remember(task: ReducedTask) -> Iterator[ConditionalEffect[Fluent]]:
    for fact in task.changing:
        this = frozenset({fact})
        yield ConditionalEffect(this, NOTHING, frozenset({f"req({fact})"}), NOTHING)
        yield ConditionalEffect(NOTHING, this, frozenset({f"nreq({fact})"}), NOTHING)


def _act_end(task: ReducedTask, accepting: list[int]) -> ClassicalAction:
    """Fig. 3: the loop ends here; facts and automaton must be as they were where it began."""
    closes = [
        ConditionalEffect(frozenset({curr_ba(z), req_lp(z)}), NOTHING, frozenset({END_BA}), NOTHING)
        for z in accepting
    ]
    for fact in task.changing:
        end = frozenset({f"end({fact})"})
        closes += [
            ConditionalEffect(frozenset({f"req({fact})", fact}), NOTHING, end, NOTHING),
            ConditionalEffect(frozenset({f"nreq({fact})"}), frozenset({fact}), end, NOTHING),
        ]
    return ClassicalAction(
        "actEnd",
        requires=frozenset({IN_LP}),
        forbids=frozenset({BA_TURN, END_DONE}),
        adds=frozenset({END_DONE}),
        conditional=tuple(closes),
    )


def _performing(
    task: ReducedTask, automaton: BuchiAutomaton, objective: Objective
) -> Iterator[ClassicalAction]:
    """Fig. 4: the actions of the task. To put the lap first, each has a costlier copy for it."""
    weight = task.lap_weight([automaton])
    for action, origin in zip(task.actions, task.origins, strict=True):
        plain = ClassicalAction(
            action.name,
            requires=action.requires,
            forbids=action.forbids | {BA_TURN, END_DONE},
            adds=action.adds | {BA_TURN},
            deletes=action.deletes,
            conditional=action.conditional,
            cost=task.cost(action),
            stands_for=origin,
        )
        if objective is Objective.LAP:
            yield replace(plain, forbids=plain.forbids | {LP_S})
            yield replace(
                plain,
                name=f"loop {action.name}",
                requires=plain.requires | {LP_S},
                adds=plain.adds | {IN_LP},
                cost=plain.cost * weight,
            )
        else:
            in_loop = ConditionalEffect(frozenset({LP_S}), NOTHING, frozenset({IN_LP}), NOTHING)
            yield replace(plain, conditional=(*plain.conditional, in_loop))
