"""Builds the behaviour tree of a lasso (Figs. 5 and 6 of the paper).

Sequence (no memory)                        root
+- as predicted?                            leftmost checking branch (Section IV-C, end)
+- Sequence (memory)                        the plan
   +- <action> ...                          prefix
   +- Repeat for ever - Sequence <action>   loop: the decorator L of Fig. 5

<action> = Selector
           +- Sequence: precondition | refinement | effects       green, yellow, blue
           +- Inverter - withdraw what the action assumed         Fig. 6, right branch

refinement of a flight = Retry(tries) - Sequence: update_param | move_cmd    MAX_TRY(m)

In a tree written by hand, a refinement that does not fly is a Sequence (no memory): still there? |
refinement. A plan needs no such check, because it is replaced when the vehicle loses its place.

1. A refinement of several steps is a sequence of them. A step that is itself a skill is refined in
   turn, until all leaves are primitives.
2. A try covers the whole refinement, and each try has the time limit. What is tried only once has
   no decorator.
3. What confirms a skill is waited for after its last step.
4. If a skill looks at something, each leaf that flies, commands or waits becomes a Sequence (no
   memory): LookAt | leaf. A gimbal that also looks there comes between the two.
"""

from __future__ import annotations

from collections.abc import Sequence as Many

from py_trees.behaviour import Behaviour
from py_trees.common import Status
from py_trees.composites import Selector, Sequence
from py_trees.decorators import Inverter, Repeat

from companion.acting.behaviour_tree import landing
from companion.acting.behaviour_tree.call_function import CallFunction
from companion.acting.behaviour_tree.confirmation import Confirm
from companion.acting.behaviour_tree.deadline import Deadline
from companion.acting.behaviour_tree.gimbal import AimGimbal, LookThroughGimbal
from companion.acting.behaviour_tree.intention import Intention
from companion.acting.behaviour_tree.land_on import LandOnMarker
from companion.acting.behaviour_tree.leaf import Leaf, leaves_of
from companion.acting.behaviour_tree.leaves import (
    AssumptionsHold,
    Effects,
    Precondition,
    Rest,
    SendCommand,
    StillThere,
    UpdateParam,
    Withdraw,
)
from companion.acting.behaviour_tree.look_at import LookAt
from companion.acting.behaviour_tree.move import MoveCommand
from companion.acting.behaviour_tree.photo import TakePhoto
from companion.acting.behaviour_tree.tries import RetrySteps
from companion.acting.flight import Flight
from companion.acting.replanning.assumptions import Assumptions
from companion.mission.payload_steps import Photo, PointGimbal
from companion.mission.places import PointOfInterest
from companion.mission.python_call import PythonCall
from companion.mission.steps import Charge, Command, Fly, Land, LandOn, TakeOff, Wait
from companion.planning.domain import Refinement, Step
from companion.planning.lasso import Lasso

FOR_EVER = -1


class ActionNode(Selector):
    """The selector of one action; the task learns if it is left before its end."""

    def __init__(self, flight: Flight, intention: Intention) -> None:
        super().__init__(intention.name, memory=True)
        self._flight = flight
        self.intention = intention

    def terminate(self, new_status: Status) -> None:
        """Called on failure, or when something above interrupts."""
        flight, retry = self._flight, self.intention.tries.next
        if new_status is not Status.SUCCESS and flight.task.running is self.intention.action:
            flight.task.interrupt()
            if retry is None or not retry.began_on_ground:
                flight.progress.strand()


def build(flight: Flight, lasso: Lasso, assumptions: Assumptions | None) -> Behaviour:
    """The tree of a lasso.

    Args:
        flight: what the leaves act on.
        lasso: the plan.
        assumptions: the values of events on which the plan relies; None for a flight to a place for
            lack of a plan, which only a new plan ends.
    """
    planned = [Intention(action.name, (action,)) for action in (*lasso.prefix, *lasso.loop)]
    trees = [action_tree(flight, each, assumptions, each is planned[-1]) for each in planned]
    cut = len(lasso.prefix)
    prefix, lap = trees[:cut], trees[cut:]
    loop = Repeat("L", _sequence("lap", lap), num_success=FOR_EVER)
    root = Sequence("root", memory=False)
    checks = [AssumptionsHold(flight, assumptions)] if assumptions is not None else []
    root.add_children([*checks, _sequence("plan", [*prefix, loop])])
    return root


def action_tree(
    flight: Flight,
    intention: Intention,
    assumptions: Assumptions | None,
    ends_lap: bool = False,
    is_by_hand: bool = False,
) -> Behaviour:
    """The tree of one action (Fig. 6).

    Args:
        flight: what the leaves act on.
        intention: what is done.
        assumptions: those of the plan; None if it has none.
        ends_lap: whether the action is the last one of the loop.
        is_by_hand: whether it belongs to a tree written by hand.
    """
    action = intention.action
    steps = Refinement(
        "steps",
        action.execute,
        tries=action.tries,
        timeout_s=action.timeout_s,
        look_at=action.look_at,
        confirmed_by=action.confirmed_by,
    )
    refinement = _refinement(flight, steps)
    if is_by_hand and action.destination is None:
        at_place = Sequence("at its place", memory=False)
        at_place.add_children([StillThere(flight, intention), refinement])
        refinement = at_place
    triple = _sequence(
        "triple",
        [
            Precondition(flight, intention, assumptions),
            refinement,
            Effects(flight, intention, ends_lap),
        ],
    )
    selector = ActionNode(flight, intention)
    for nth, leaf in enumerate(leaves_of(refinement)):
        leaf.nth = nth
    selector.add_children([triple, Inverter("not", Withdraw(flight, intention, triple))])
    return selector


def move_tree(flight: Flight, place: str, tries: int, timeout_s: float | None) -> Behaviour:
    """The tree of a flight to a place: MAX_TRY(m) of Fig. 6."""
    return _tried(flight, _flight_to(flight, place, timeout_s, None), tries)


def _tried(flight: Flight, child: Behaviour, tries: int) -> Behaviour:
    return RetrySteps(flight, child, tries) if tries > 1 else child


def _refinement(
    flight: Flight,
    skill: Refinement,
    within_s: float | None = None,
    look_at: PointOfInterest | None = None,
) -> Behaviour:
    """The steps of a skill, tried as often as the skill says.

    Args:
        flight: what the leaves act on.
        skill: what is done.
        within_s: the time limit of the skill that it refines.
        look_at: what that skill looks at; the skill's own `look_at` takes precedence.
    """
    limit_s = within_s if skill.timeout_s is None else skill.timeout_s
    once = _one_try(flight, skill, limit_s, skill.look_at or look_at)
    if skill.tries > 1 and _touches_ground(skill.steps):
        once = _sequence("another try", [landing.BeginAgain(flight), once])
    return _tried(flight, once, skill.tries)


def _one_try(
    flight: Flight, skill: Refinement, limit_s: float | None, look_at: PointOfInterest | None
) -> Behaviour:
    """One try: a single step, or a sequence of several, within one time limit.

    A command or a function may take all of that time.
    """
    match skill.steps if skill.confirmed_by is None else ():
        case (Fly(place),):
            return _flight_to(flight, place, skill.timeout_s, look_at)
        case (Command() | PointGimbal() | Photo() | PythonCall() as step,):
            return _step(flight, step, limit_s, look_at)
    steps = [_step(flight, step, limit_s, look_at) for step in skill.steps]
    if skill.confirmed_by is not None:
        steps.append(Confirm(flight, skill.confirmed_by, limit_s))
    once = steps[0] if len(steps) == 1 else _sequence(skill.name, steps)
    if skill.enough_percent is not None:
        charge = Selector(skill.name, memory=True)
        charge.add_children([landing.EnoughCharge(flight, skill.enough_percent), once])
        once = charge
    return Deadline(flight, once, skill.timeout_s) if skill.timeout_s is not None else once


def _touches_ground(steps: Many[Step]) -> bool:
    """Whether they land or take off, so that another try may begin in another state."""
    return any(
        isinstance(step, Land | LandOn | TakeOff)
        or (isinstance(step, Refinement) and _touches_ground(step.steps))
        for step in steps
    )


def _flight_to(
    flight: Flight, place: str, timeout_s: float | None, look_at: PointOfInterest | None
) -> Behaviour:
    move = MoveCommand(flight, place, timeout_s, look_at.position if look_at else None)
    return _sequence("move", [UpdateParam(flight, place, move), _looking(flight, move, look_at)])


def _looking(flight: Flight, leaf: Leaf, look_at: PointOfInterest | None) -> Behaviour:
    if look_at is None:
        return leaf
    looking = Sequence("looking", memory=False)
    looking.add_child(LookAt(flight, look_at, leaf))
    if look_at.gimbal is not None and not isinstance(leaf, MoveCommand):
        looking.add_child(LookThroughGimbal(flight, look_at, leaf))
    looking.add_child(leaf)
    return looking


def _step(
    flight: Flight, step: Step, limit_s: float | None, look_at: PointOfInterest | None
) -> Behaviour:
    match step:
        case Fly(place):
            return _flight_to(flight, place, None, look_at)
        case Command():
            return _looking(flight, SendCommand(flight, step, limit_s), look_at)
        case PointGimbal():
            return AimGimbal(flight, step, limit_s)
        case Photo():
            return _looking(flight, TakePhoto(flight, step, limit_s), look_at)
        case PythonCall():
            return _looking(flight, CallFunction(flight, step, limit_s), look_at)
        case Wait(duration_s):
            return _looking(flight, Rest(flight, "rest", duration_s), look_at)
        case Land():
            return landing.LandVehicle(flight, "land")
        case LandOn(place):
            return LandOnMarker(flight, place)
        case TakeOff():
            return landing.TakeOffVehicle(flight, "take off")
        case Charge(percent, called):
            return landing.ChargeBattery(flight, 100.0 if percent is None else percent, called)
        case Refinement():
            return _refinement(flight, step, limit_s, look_at)


def _sequence(name: str, children: Many[Behaviour]) -> Behaviour:
    sequence = Sequence(name, memory=True)
    sequence.add_children(list(children))
    return sequence
