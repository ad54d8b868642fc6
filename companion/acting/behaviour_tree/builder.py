"""A lasso as a behaviour tree (Figs. 5 and 6 of the paper).

Sequence (no memory)                        root
+- as predicted?                            leftmost checking branch (Section IV-C, end)
+- Sequence (memory)                        the plan
   +- <action> ...                          prefix
   +- Repeat for ever - Sequence <action>   loop: the decorator L of Fig. 5

<action> = Selector
           +- Sequence: precondition | refinement | effects       green, yellow, blue
           +- Inverter - withdraw what the action assumed         Fig. 6, right branch

refinement of a flight = Retry(tries) - Sequence: update_param | move_cmd    MAX_TRY(m)

A refinement of several steps is a sequence of them; a step that is itself a skill is refined in
turn, until all leaves are primitives.
"""

from __future__ import annotations

from collections.abc import Sequence as Many

from py_trees.behaviour import Behaviour
from py_trees.common import Status
from py_trees.composites import Selector, Sequence
from py_trees.decorators import Inverter, Repeat, Retry

from companion.acting.behaviour_tree import landing
from companion.acting.behaviour_tree.deadline import Deadline
from companion.acting.behaviour_tree.leaves import (
    AssumptionsHold,
    Effects,
    Precondition,
    Rest,
    SendCommand,
    UpdateParam,
    Withdraw,
)
from companion.acting.behaviour_tree.move import MoveCommand
from companion.acting.flight import Flight
from companion.acting.replanning.assumptions import Assumptions
from companion.mission.model import Charge, Command, Fly, Land, TakeOff, Wait
from companion.planning.domain import Action, Refinement, Step
from companion.planning.lasso import Lasso

FOR_EVER = -1


class ActionNode(Selector):
    """The selector of one action; left before its end, the task knows that it was interrupted."""

    def __init__(self, flight: Flight, action: Action) -> None:
        super().__init__(action.name, memory=True)
        self._flight = flight
        self.action = action

    def terminate(self, new_status: Status) -> None:
        """Failed, or stopped from above."""
        if new_status is not Status.SUCCESS and self._flight.task.running is self.action:
            self._flight.task.interrupt()


def build(flight: Flight, lasso: Lasso, assumptions: Assumptions) -> Behaviour:
    """The tree of a lasso.

    Args:
        flight: what the leaves act on.
        lasso: the plan.
        assumptions: the values of events on which the plan relies.
    """
    prefix = [action_tree(flight, a, assumptions) for a in lasso.prefix]
    last = len(lasso.loop) - 1
    lap = [
        action_tree(flight, action, assumptions, ends_lap=i == last)
        for i, action in enumerate(lasso.loop)
    ]
    loop = Repeat("L", _sequence("lap", lap), num_success=FOR_EVER)
    root = Sequence("root", memory=False)
    root.add_children([AssumptionsHold(flight, assumptions), _sequence("plan", [*prefix, loop])])
    return root


def action_tree(
    flight: Flight, action: Action, assumptions: Assumptions | None, ends_lap: bool = False
) -> Behaviour:
    """The tree of one action (Fig. 6).

    Args:
        flight: what the leaves act on.
        action: what is done.
        assumptions: those of the plan; None in a tree written by hand.
        ends_lap: whether the action is the last one of the loop.
    """
    triple = _sequence(
        "triple",
        [
            Precondition(flight, action, assumptions),
            _refinement(
                flight, Refinement("steps", action.execute, action.tries, action.timeout_s)
            ),
            Effects(flight, action, ends_lap),
        ],
    )
    selector = ActionNode(flight, action)
    selector.add_children([triple, Inverter("not", Withdraw(flight, action, triple))])
    return selector


def move_tree(flight: Flight, place: str, tries: int, timeout_s: float | None) -> Behaviour:
    """The tree of a flight to a place: MAX_TRY(m) of Fig. 6."""
    move = MoveCommand(flight, place, timeout_s)
    steps = [UpdateParam(flight, place, move), move]
    return Retry(f"MAX_TRY({tries})", _sequence("move", steps), tries)


def _refinement(flight: Flight, skill: Refinement) -> Behaviour:
    """A single step is itself; several are a sequence, in time together."""
    if len(skill.steps) == 1:
        return _step(flight, skill.steps[0], skill.tries, skill.timeout_s)
    steps = [_step(flight, step, skill.tries, None) for step in skill.steps]
    sequence = _sequence(skill.name, steps)
    return Deadline(flight, sequence, skill.timeout_s) if skill.timeout_s else sequence


def _step(flight: Flight, step: Step, tries: int, timeout_s: float | None) -> Behaviour:
    match step:
        case Fly(place):
            return move_tree(flight, place, tries, timeout_s)
        case Command():
            return SendCommand(flight, step, timeout_s)
        case Wait(duration_s):
            return Rest(flight, duration_s)
        case Land():
            return landing.LandVehicle(flight, "land")
        case TakeOff():
            return landing.TakeOffVehicle(flight, "take off")
        case Charge(percent):
            return landing.ChargeBattery(flight, percent)
        case Refinement():
            return _refinement(flight, step)


def _sequence(name: str, children: Many[Behaviour]) -> Behaviour:
    sequence = Sequence(name, memory=True)
    sequence.add_children(list(children))
    return sequence
