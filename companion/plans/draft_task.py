"""The skills and the task of a drafted mission.

A stop without acts is satisfied by at(X). Where the vehicle waits or commands a payload, there is a
skill, and the stop is satisfied by the fact that this skill makes true. Leaving the place makes the
fact false again, so that it counts only for this stop.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

from companion.plans.route_plan import Act, RoutePlan

HOME = "Home"
MAX_ORDERED = 20
"""From this number on `sequenced_visit`: a tenth of the automaton, and the same plan."""


class RouteStop(NamedTuple):
    """A stop of the route.

    Attributes:
        place: where.
        acts: what is done there.
        name: the name of the stop, for its skill and its fact.
    """

    place: str
    acts: tuple[Act, ...]
    name: str

    @property
    def done(self) -> str:
        """The fact that the acts make true."""
        return f"done_{self.name}"

    @property
    def holds(self) -> str:
        """What is true when the stop has been made."""
        return self.done if self.acts else f"at({self.place})"


def skills_of(stops: Sequence[RouteStop]) -> dict[str, Any]:
    """The skills: `move`, and one for the acts of each stop."""
    working = [stop for stop in stops if stop.acts]
    leaving = "".join(f" & !{stop.done}" for stop in working)
    skills: dict[str, Any] = {
        "move": {
            "parameters": {"from": "Place", "to": "Place"},
            "precondition": "at(from)",
            "assumes": "trans_ok(from, to)",
            "effect": f"at(to) & !at(from){leaving}",
            "cost": "flight_time",
            "execute": "fly(to)",
            "tries": 3,
        }
    }
    for stop in working:
        skills[f"act_{stop.name}"] = {
            "precondition": f"at({stop.place})",
            "effect": stop.done,
            "execute": [act.step for act in stop.acts],
        }
    return skills


def task_of(plan: RoutePlan, stops: Sequence[RouteStop], end: str) -> dict[str, str]:
    """The lines of the task.

    Args:
        plan: the plan of the stops.
        stops: the stops of the plan, after those at home.
        end: the place where the flight ends, if it ends.
    """
    if plan.repeats_from is None:
        rest = {"home" if end == HOME else "end": f"F G at({end})"}
        return {"route": _visited(stops, plan.is_ordered), **rest} if stops else rest
    begun = len(stops) - len(plan.waypoints) + plan.repeats_from
    task = {"first": _visited(stops[:begun], plan.is_ordered)} if begun else {}
    return {**task, "patrol": _patrolled(stops[begun:])}


def _visited(stops: Sequence[RouteStop], is_ordered: bool) -> str:
    """The formula for visiting the stops once."""
    places = [stop.place for stop in stops]
    if not is_ordered:
        return " & ".join(f"F {stop.holds}" for stop in stops)
    if not any(stop.acts for stop in stops) and len(places) > 1:
        is_plain = len(set(places)) == len(places) <= MAX_ORDERED and HOME not in places
        return f"{'ordered' if is_plain else 'sequenced'}_visit({', '.join(places)})"
    *earlier, last = (stop.holds for stop in stops)
    return "".join(f"F ({atom} & " for atom in earlier) + f"F {last}" + ")" * len(earlier)


def _patrolled(stops: Sequence[RouteStop]) -> str:
    """The formula for visiting the stops again and again."""
    places = list(dict.fromkeys(stop.place for stop in stops))
    if any(stop.acts for stop in stops) or len(places) < 2:
        return " & ".join(_always_again(stops))
    return f"patrolling({', '.join(places)})"


def _always_again(stops: Sequence[RouteStop]) -> Iterator[str]:
    for atom in dict.fromkeys(stop.holds for stop in stops):
        yield f"G F {atom}"
