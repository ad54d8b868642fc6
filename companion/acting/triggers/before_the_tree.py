"""The reasons to plan again that are looked at before the plan's tree is ticked.

They are what the map, the charge, the beliefs and the clocks say, which the tree acts on.
"""

from __future__ import annotations

from companion.acting.charge.energy_watch import EnergyWatch
from companion.acting.flight import Flight
from companion.acting.plan_under_way import PlanUnderWay
from companion.acting.replanning.assumptions import BELIEF_CAME_BACK, Assumptions
from companion.acting.replanning.replanner import Replanner
from companion.acting.triggers.trigger import ReplanTrigger, SlicedTrigger
from companion.planning.lasso import Lasso
from companion.slices import Question


class CutOffByMap(SlicedTrigger[str | None]):
    """A belief that the plan needs was given up, once the routes on the map are known.

    Args:
        flight: knows the progress of the plan.
        replanner: knows the map.
        outdated: the question that is dropped when this trigger takes over the map.
    """

    def __init__(
        self, flight: Flight, replanner: Replanner, outdated: Question[str | None]
    ) -> None:
        super().__init__()
        self._flight, self._replanner, self._outdated = flight, replanner, outdated

    def guard(self, plan: PlanUnderWay) -> bool:
        """The map has changed, and what it has changed is not known yet."""
        is_news = self._replanner.reachability.has_changed or self.is_thinking
        return is_news and not self._flight.progress.is_landed_by_plan

    def reason(self, plan: PlanUnderWay) -> str | None:
        """The beliefs that were given up, unless the plan is still the best one."""
        self._outdated.abandon()
        reachability = self._replanner.reachability
        reachability.search()
        if not reachability.is_known:
            return None

        def reason() -> str | None:
            cut_off = self._replanner.follow_map()
            if cut_off is None or plan.is_leaving or self._replanner.search_confirms(plan.lasso):
                return None
            return cut_off.text

        answered = self._question.ask("the map", reason)
        return answered.answer if answered else None


class ChargeShort(ReplanTrigger):
    """The charge is not enough for the rest of the plan.

    Args:
        flight: knows the progress of the plan.
        energy: checks the charge.
    """

    def __init__(self, flight: Flight, energy: EnergyWatch) -> None:
        self._flight, self._energy = flight, energy

    def guard(self, plan: PlanUnderWay) -> bool:
        """It is time for a check, in the air."""
        may_look = self._energy.is_due and not plan.is_leaving
        return may_look and not self._flight.progress.is_landed_by_plan

    def reason(self, plan: PlanUnderWay) -> str | None:
        """What is missing."""
        return self._energy.shortage()


class EnergyFigureWrong(SlicedTrigger[str | None]):
    """Flights take another energy than plans assume.

    If they take less, the charge lasts for the plan: it is kept if there is no other one.

    Args:
        flight: knows the progress of the plan.
        energy: measures the energy of flights.
        replanner: plans with the new figure.
    """

    def __init__(self, flight: Flight, energy: EnergyWatch, replanner: Replanner) -> None:
        super().__init__()
        self._flight, self._energy, self._replanner = flight, energy, replanner

    def guard(self, plan: PlanUnderWay) -> bool:
        """The figure is wrong."""
        if plan.is_leaving or self._flight.progress.is_landed_by_plan:
            return False
        return self.is_thinking or self._energy.is_figure_wrong

    def reason(self, plan: PlanUnderWay) -> str | None:
        """The new figure, which plans use from now on."""
        energy = self._energy

        def reason() -> str | None:
            does_last, figure = not energy.takes_more, energy.take_factor()
            return None if does_last and self._replanner.plan_now() is None else figure

        answered = self._question.ask(plan.lasso, reason)
        return answered.answer if answered else None


class TaskPossibleAgain(SlicedTrigger[bool]):
    """The task has a plan again, while the vehicle flies to a safe place without one.

    The flight continues during the search.

    Args:
        flight: knows the task.
        assumptions: know which beliefs have come back, and which events have changed.
        replanner: searches for a plan.
    """

    def __init__(self, flight: Flight, assumptions: Assumptions, replanner: Replanner) -> None:
        super().__init__()
        self._flight, self._assumptions, self._replanner = flight, assumptions, replanner

    def guard(self, plan: PlanUnderWay) -> bool:
        """Beliefs have come back, or events have changed."""
        assumptions = self._assumptions
        return plan.is_leaving and (assumptions.may_do_better or bool(assumptions.wrong))

    def reason(self, plan: PlanUnderWay) -> str | None:
        """What has changed, if there is a plan now."""
        task = self._flight.task
        if not task.violated:
            about = tuple(self._assumptions.wrong), task.withdrawn
            answered = self._question.ask(about, lambda: self._replanner.is_possible)
            if answered is None:
                return None
            if answered.answer:
                return self._assumptions.surprise or BELIEF_CAME_BACK
        self._assumptions.forget_restored_beliefs()
        self._assumptions.renew()
        return None


class DroppedLineKept(SlicedTrigger[str | None]):
    """A line of the task that was dropped can be kept; asked once after each completed skill.

    Changes of an event do not ask again. Those that matter to the plan lead to another one, which
    considers all lines.

    Args:
        flight: knows the task.
        replanner: searches for a plan with the line.
    """

    def __init__(self, flight: Flight, replanner: Replanner) -> None:
        super().__init__()
        self._flight, self._replanner = flight, replanner

    def guard(self, plan: PlanUnderWay) -> bool:
        """A skill was completed, and lines are dropped."""
        return self._flight.task.may_take_up and not self._flight.progress.is_landed_by_plan

    def reason(self, plan: PlanUnderWay) -> str | None:
        """The line."""
        task = self._flight.task
        if plan.is_leaving:
            task.keep_dropped()
            return None
        answered = self._question.ask(task.completed, lambda: self._replanner.line_to_take_up)
        if answered is None:
            return None
        task.keep_dropped()
        return None if answered.answer is None else f"{answered.answer} has a plan again"


class BoundLate(SlicedTrigger[str | None]):
    """A time bound will be late, and another plan keeps it; asked once after each completed skill.

    Args:
        flight: knows the progress of the plan.
        replanner: compares the plan with others.
        cut_off: it waits for this trigger, which takes over the map.
        question: its question.
    """

    def __init__(
        self,
        flight: Flight,
        replanner: Replanner,
        cut_off: CutOffByMap,
        question: Question[str | None],
    ) -> None:
        super().__init__(question)
        self._flight, self._replanner, self._cut_off = flight, replanner, cut_off
        self._flown_on_paper: tuple[Lasso, int] | None = None

    def guard(self, plan: PlanUnderWay) -> bool:
        """An action is under way about which it was not asked yet."""
        if not self._replanner.is_timed or plan.is_leaving or self._cut_off.guard(plan):
            return False
        progress, is_flying = self._flight.progress, self._flight.task.running is not None
        is_news = self._flown_on_paper != (plan.lasso, progress.completed)
        return is_flying and is_news and not progress.is_landed_by_plan

    def reason(self, plan: PlanUnderWay) -> str | None:
        """What will be late."""
        about = plan.lasso, self._flight.progress.completed
        answered = self._question.ask(about, lambda: self._replanner.lateness(plan.lasso))
        if answered is None:
            return None
        self._flown_on_paper = about
        return answered.answer
