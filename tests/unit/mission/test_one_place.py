"""An effect after which the vehicle is at two places, or at none, is refused with its remedy."""

from __future__ import annotations

import itertools
from collections.abc import Callable

import pytest
from drawn import drawn
from hypothesis import given
from hypothesis import strategies as st

from companion.documents.document import TextDocument
from companion.errors import Location, MissionError
from companion.mission.facts import at
from companion.mission.literals import parse_effect, parse_literals
from companion.mission.model import Mission
from companion.mission.one_place import check_one_place
from companion.mission.skills import Skill
from companion.mission.steps import Wait

Load = Callable[[str], Mission]
MOVED = "at(to) & !at(from)"


def test_a_forgotten_departure_is_refused_with_its_line(load: Load, good: str) -> None:
    with pytest.raises(MissionError) as caught:
        load(good.replace(MOVED, "at(to)"))
    assert "move brings the vehicle to to, and leaves it at from too" in str(caught.value)
    assert "add !at(from) to its effect" in str(caught.value)
    where = caught.value.where
    assert isinstance(where, Location)
    assert good.splitlines()[where.line - 1].strip() == f"effect: {MOVED}"


@pytest.mark.parametrize(
    ("precondition", "effect", "complaint"),
    [
        ("at(from)", "at(to) & at(from)", "to from and to to"),
        ("at(from)", "!at(from)", "away from from, and to no place"),
        ("at(from)", "!at(to)", "away from to, and to no place"),
        ("ready", "at(to)", "whatever place it leaves"),
        ("at(from)", "(ready -> at(to)) & !at(from)", "away from from"),
        ("at(from)", "(ready -> at(to) & !at(from)) & (late -> at(Home))", "leaves it at from"),
        ("at(from)", "(ready -> at(to)) & (late -> at(Home)) & !at(from)", "away from from"),
    ],
)
def test_other_effects_that_are_refused(precondition: str, effect: str, complaint: str) -> None:
    with pytest.raises(MissionError, match=complaint):
        check(skill(precondition, effect))


@pytest.mark.parametrize(
    ("precondition", "effect"),
    [
        ("at(from)", MOVED),
        ("at(from) & at(to)", "at(to)"),
        ("ready", "done"),
        ("ready", "at(Home) & !at(A) & !at(B)"),
        ("at(from)", "(ready -> at(to) & !at(from)) & done"),
        ("at(from)", "(at(A) -> at(B) & !at(A)) & (at(B) -> at(A) & !at(B))"),
    ],
)
def test_effects_that_are_right(precondition: str, effect: str) -> None:
    check(skill(precondition, effect))


NAMES = ["from", "to", "Home", "A"]
LITERALS = [f"{sign}at({name})" for sign in ("", "!") for name in NAMES]


@drawn(300)
@given(
    st.sets(st.sampled_from(LITERALS), max_size=2),
    st.sets(st.sampled_from(LITERALS), min_size=1, max_size=3),
    st.booleans(),
)
def test_what_is_accepted_leaves_the_vehicle_at_one_place(
    precondition: set[str], effect: set[str], is_distinct: bool
) -> None:
    """Held against all instances: no template that is accepted has one that breaks it."""
    told = skill(" & ".join(sorted(precondition)), " & ".join(sorted(effect)), is_distinct)
    try:
        check(told)
    except MissionError:
        return
    for start, goal, place in itertools.product(PLACES, repeat=3):
        if is_distinct and start == goal:
            continue
        binding = {"from": start, "to": goal}
        held = {x.atom.instantiate(binding) for x in told.precondition if x.is_positive}
        barred = {x.atom.instantiate(binding) for x in told.precondition if not x.is_positive}
        if not held <= {at(place)} or at(place) in barred:
            continue
        facts = {at(place)}
        facts -= {x.atom.instantiate(binding) for x in told.effect if not x.is_positive}
        facts |= {x.atom.instantiate(binding) for x in told.effect if x.is_positive}
        assert len(facts) == 1, (binding, place)


PLACES = ("Home", "A", "B")


def skill(precondition: str, effect: str, is_distinct: bool = False) -> Skill:
    plain, conditional = parse_effect(effect)
    return Skill(
        "go",
        (("from", "Place"), ("to", "Place")),
        parse_literals(precondition) if precondition else (),
        (),
        plain,
        1.0,
        (Wait(1.0),),
        1,
        None,
        conditional,
        (("from", "to"),) if is_distinct else (),
    )


def check(told: Skill) -> None:
    document = TextDocument("skills: {go: {effect: here}}\n", "mission.yaml")
    check_one_place({told.name: told}, PLACES, document)
