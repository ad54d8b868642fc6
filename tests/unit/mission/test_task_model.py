"""What a mission can say besides places and formulas: objects, conditions on effects, a goal."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from companion.errors import MissionError
from companion.ltl.parser import parse
from companion.mission.model import Mission
from companion.planning.domain import Action, ground

Load = Callable[[str], Mission]

PARCELS = """\
objects: [p1, p2]
sets:
  Place: [Home, A, no]
  Site: [A, no]
  Parcel: [p1, p2]
"""
LOADING = """\
  load:
    parameters: {x: Parcel, r: Site}
    precondition: at(r) & in(x, r)
    effect: has(x) & !in(x, r) & (fragile(x) & !low -> shaken(x) & !fragile(x))
    execute: wait(2)
initially: [at(Home), "in(p1, A)", fragile(p1), fragile(p2)]
"""


@pytest.fixture
def parcels(good: str) -> str:
    """The good mission with parcels to fetch and a plain goal."""
    sets = good[good.index("sets:") : good.index("components:")]
    task = good[good.index("task:") : good.index("otherwise:")]
    text = good.replace(sets, PARCELS).replace(task, "goal: has(p1) & !low\n")
    return text.replace("initially: [at(Home)]\n", LOADING)


def actions(mission: Mission) -> dict[str, Action]:
    return {action.name: action for action in ground(mission, lambda a, b: 3.0).actions}


def test_parameters_range_over_objects(load: Load, parcels: str) -> None:
    mission = load(parcels)
    assert mission.sets["Parcel"] == ("p1", "p2")
    assert mission.task == {"goal": parse("F (has(p1) & !low)")}


def test_an_effect_under_a_condition(load: Load, parcels: str) -> None:
    action = actions(load(parcels))["load(p1, A)"]
    before = frozenset({"at(A)", "in(p1, A)", "fragile(p1)"})
    assert action.apply(before) == {"at(A)", "has(p1)", "shaken(p1)"}
    assert action.apply(before | {"low"}) == {"at(A)", "has(p1)", "fragile(p1)", "low"}
    assert action.apply(before - {"fragile(p1)"}) == {"at(A)", "has(p1)"}


def test_parameters_that_differ(load: Load, parcels: str) -> None:
    text = parcels.replace("  load:\n", "  load:\n    distinct: [[x, y]]\n")
    text = text.replace("{x: Parcel, r: Site}", "{x: Parcel, y: Parcel, r: Site}")
    text = text.replace("at(r) & in(x, r)", "at(r) & in(x, r) & !has(y)")
    loads = [name for name in actions(load(text)) if name.startswith("load")]
    assert sorted(loads) == [
        f"load({x}, {y}, {r})" for x, y in (("p1", "p2"), ("p2", "p1")) for r in ("A", "no")
    ]


SPOILT = [
    ("objects: [p1, p2]", "objects: [p1, §p1]", "p1 is twice among the places and objects"),
    ("objects: [p1, p2]", "objects: [p1, §A]", "A is twice among the places and objects"),
    ("Parcel: [p1, p2]", "Parcel: [p1, §p3]", "unknown place or object p3 in the set"),
    ("goal: has(p1) & !low", "goal: §has(A)", "unknown fact has(A)"),
    ("goal: has(p1) & !low", "goal: §F has(p1)", "neither a fact nor the negation"),
    ("goal: has(p1) & !low\n", "", "neither a task nor a goal"),
    ("goal: has(p1)", "task: {§goal: F has(p1)}\ngoal: has(p1)", "a line of the task is called"),
    ("-> shaken(x)", "-> §F shaken(x)", "neither a fact nor the negation"),
    ("-> shaken(x)", "-> low & shaken(x)", "low is an event, so the skill load cannot set it"),
    ("    execute: wait(2)", "    execute: §fly(x)", "load cannot fly to p1, which is no place"),
    ("at(r) & in(x, r)", "§at(x) & in(x, r)", "at(x) speaks of p1, which is no place"),
    ("    execute: wait(2)", "    distinct: [[x, §z]]\n    execute: wait(2)", "no parameter z"),
    ("    effect: has(x)", "    timeout_s: 3  # has(x)", "load has no effect"),
    ("goal: has(p1)", "problem: §x.pddl\ngoal: has(p1)", "a problem without a domain"),
]


@pytest.mark.parametrize(("old", "new", "message"), SPOILT)
def test_a_mistake_is_answered(load: Load, parcels: str, old: str, new: str, message: str) -> None:
    assert parcels.count(old) == 1
    with pytest.raises(MissionError) as caught:
        load(parcels.replace(old, new.replace("§", "")))
    assert message in caught.value.what
    if "§" in new and caught.value.where is not None:
        before = parcels[: parcels.index(old)] + new[: new.index("§")]
        assert caught.value.where.line == before.count("\n") + 1
