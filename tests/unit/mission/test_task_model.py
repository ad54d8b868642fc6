"""What a mission can say besides places and formulas: objects, conditions on effects, a goal."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from synthetic import facts_of

from companion.errors import Location, MissionError
from companion.ltl.parser import parse
from companion.mission.model import Mission
from companion.planning.domain import Action
from companion.planning.instances import instantiate

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
    return {action.name: action for action in instantiate(mission, lambda a, b: 3.0).actions}


def test_parameters_range_over_objects(load: Load, parcels: str) -> None:
    mission = load(parcels)
    assert mission.sets["Parcel"] == ("p1", "p2")
    assert mission.task == {"goal": parse("F (has(p1) & !low)")}


def test_an_effect_under_a_condition(load: Load, parcels: str) -> None:
    action = actions(load(parcels))["load(p1, A)"]
    before = facts_of("at(A)", "in(p1, A)", "fragile(p1)")
    assert action.apply(before) == {"at(A)", "has(p1)", "shaken(p1)"}
    assert action.apply(before | facts_of("low")) == {"at(A)", "has(p1)", "fragile(p1)", "low"}
    assert action.apply(before - {"fragile(p1)"}) == {"at(A)", "has(p1)"}


def test_parameters_that_differ(load: Load, parcels: str) -> None:
    text = parcels.replace("  load:\n", "  load:\n    distinct: [[x, y]]\n")
    text = text.replace("{x: Parcel, r: Site}", "{x: Parcel, y: Parcel, r: Site}")
    text = text.replace("at(r) & in(x, r)", "at(r) & in(x, r) & !has(y)")
    loads = [name for name in actions(load(text)) if name.startswith("load")]
    assert sorted(loads) == [
        f"load({x}, {y}, {r})" for x, y in (("p1", "p2"), ("p2", "p1")) for r in ("A", "no")
    ]


def test_a_skill_and_a_place_that_differ(load: Load, parcels: str) -> None:
    text = parcels.replace("  load:\n", "  load:\n    distinct: [[r, no]]\n")
    loads = [name for name in actions(load(text)) if name.startswith("load")]
    assert loads == ["load(p1, A)", "load(p2, A)"]


def test_a_condition_may_wait_for_an_effect_under_a_condition(load: Load, parcels: str) -> None:
    """Nothing but the conditional effect of `load` makes `shaken` true."""
    mission = load(parcels.replace("at(r) & in(x, r)", "at(r) & in(x, r) & !shaken(x)"))
    assert actions(mission)["load(p1, A)"].forbids == {"shaken(p1)"}


def test_an_event_may_restart_the_goal(load: Load, parcels: str) -> None:
    mission = load(parcels.replace("    latch: true\n", "    latch: true\n    restarts: [goal]\n"))
    assert mission.events["found"].restarts == {"goal"}


def test_instances_and_their_conditional_effects_are_counted_first(
    load: Load, parcels: str
) -> None:
    """Before anything is instantiated: 200^3 instances would not fit into memory."""
    many = ", ".join(f"q{i}" for i in range(200))
    text = parcels.replace("objects: [p1, p2]", f"objects: [p1, p2, {many}]")
    text = text.replace("Parcel: [p1, p2]", f"Parcel: [p1, p2, {many}]")
    effects = " & ".join(f"(has(q{i}) -> shaken(x))" for i in range(130))
    with pytest.raises(MissionError, match="have 52924 conditional effects, at most 50000"):
        load(text.replace("has(x) & !in(x, r) &", f"has(x) & !in(x, r) & {effects} &"))
    text = text.replace("{x: Parcel, r: Site}", "{x: Parcel, y: Parcel, z: Parcel, r: Site}")
    with pytest.raises(MissionError, match="have 16484827 instances, at most 50000"):
        load(text.replace("at(r) & in(x, r)", "at(r) & in(x, r) & !has(y) & !has(z)"))


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
    ("(fragile(x) & !low", "§(fragil(x) & !low", "nothing ever makes fragil true"),
    ("{x: Parcel, r: Site}", "{x: Parcel, r: Site, §p1: Site}", "p1 has the name of an object"),
    ("    latch: true", "    latch: true\n    restarts: [§gaol]", "found restarts gaol"),
    ("    execute: wait(2)", "    execute: §fly(x)", "load cannot fly to p1, which is not a place"),
    ("at(r) & in(x, r)", "§at(x) & in(x, r)", "at(x) speaks of p1, which is not a place"),
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
    where = caught.value.where
    if "§" in new and where is not None:
        assert isinstance(where, Location)
        before = parcels[: parcels.index(old)] + new[: new.index("§")]
        assert where.line == before.count("\n") + 1
