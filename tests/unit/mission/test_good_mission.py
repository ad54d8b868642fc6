"""A good mission means what it says."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import pytest

from companion.errors import Location, MissionError
from companion.ltl.parser import parse
from companion.mission.facts import Atom
from companion.mission.model import Mission
from companion.mission.otherwise import Otherwise
from companion.mission.signals import Condition, Signal
from companion.mission.skills import Literal
from companion.mission.steps import Charge, Command, Do, Fly, Land, TakeOff, Wait

Load = Callable[[str | bytes], Mission]


def test_good_mission_means_what_it_says(load: Load, good: str, room: Path) -> None:
    mission = load(good)
    assert mission.text == good
    assert mission.path == str(room / "mission.yaml")
    assert mission.places["A"].position == (7.0, 5.0, -1.5)
    assert (mission.places["A"].inner_m, mission.places["no"].inner_m) == (0.6, 0.4)
    assert mission.limits.fence == ((0, 0), (0, 10), (8.5, 10), (8.5, 0))
    assert mission.sets == {"Place": ("Home", "A", "no"), "Site": ("A", "no")}
    assert mission.grid.occupied.shape == (20, 20)
    assert mission.otherwise is Otherwise.LAND


def test_events(load: Load, good: str) -> None:
    found, low = load(good).events.values()
    assert found.when == Condition(Signal("NAMED_VALUE_INT", "target", "value"), ">", 0)
    assert (found.latch, found.until, found.for_s) == (True, None, 0)
    assert low.until == Condition(Signal("BATTERY_STATUS", "", "battery_remaining"), ">", 80)
    assert (low.latch, low.for_s) == (False, 2)


CALLED = ("NAMED_VALUE_INT[target].value > 0\n    latch: true", "COMMAND.MAV_CMD_USER_1")


def test_when_events_hold_in_words(load: Load, good: str) -> None:
    found, low = load(good).events.values()
    assert found.duration == "for ever, once NAMED_VALUE_INT[target].value > 0"
    level = "BATTERY_STATUS.battery_remaining"
    assert low.duration == f"from {level} < 30 until {level} > 80; a change counts after 2 s"
    again = good.replace(*CALLED).replace("at(r) & found &", "at(r) &")
    called = load(again).events["found"]
    assert called.is_pulse
    assert called.duration == "at the moment of COMMAND.MAV_CMD_USER_1, once in the word for each"


def test_a_moment_cannot_hold_for_a_time(load: Load, good: str) -> None:
    for more in ("", "\n    latch: true", f"\n    until: {CALLED[1]}"):
        with pytest.raises(MissionError, match="a command to hold for 2 s") as caught:
            load(good.replace(CALLED[0], f"{CALLED[1]}\n    for_s: 2{more}"))
        where = caught.value.where
        assert isinstance(where, Location) and where.line == 20
        assert "remove for_s" in str(caught.value)
    level = "BATTERY_STATUS.battery_remaining > 80"
    load(good.replace(CALLED[0], f"{CALLED[1]}\n    for_s: 2\n    until: {level}"))


@pytest.mark.parametrize("more", ["", "\n    latch: true", f"\n    until: {CALLED[1]}"])
def test_a_precondition_cannot_wait_for_a_moment(load: Load, good: str, more: str) -> None:
    text = good.replace(CALLED[0], CALLED[1] + more)
    if more:
        load(text)
        return
    with pytest.raises(MissionError, match="upload waits for found, which never lasts") as caught:
        load(text)
    assert "give found latch: true, or until:" in str(caught.value)
    load(text.replace("at(r) & found &", "at(r) & !found &"))


def test_skills(load: Load, good: str) -> None:
    move, upload = load(good).skills.values()
    assert move.parameters == (("from", "Place"), ("to", "Place"))
    assert move.precondition == (Literal(Atom("at", ("from",)), True),)
    assert move.assumes == (Atom("trans_ok", ("from", "to")),)
    assert move.effect == (
        Literal(Atom("at", ("to",)), True),
        Literal(Atom("at", ("from",)), False),
    )
    assert (move.cost_s, move.execute, move.tries, move.timeout_s) == (None, (Fly("to"),), 3, None)
    assert upload.precondition[1:] == (
        Literal(Atom("found", ()), True),
        Literal(Atom("low", ()), False),
    )
    assert upload.execute == (Command(25, 31010, "MAV_CMD_USER_1", (1.5, -2.0)),)
    assert (upload.cost_s, upload.tries, upload.timeout_s) == (10, 1, 15)


def test_by_default_what_a_skill_takes_follows_from_its_steps(load: Load, good: str) -> None:
    text = good.replace("    cost: flight_time\n", "").replace("    cost: 10\n", "")
    assert [skill.cost_s for skill in load(text).skills.values()] == [None, None]


def test_wait_is_something_to_execute(load: Load, good: str) -> None:
    text = good.replace("command(payload, MAV_CMD_USER_1, 1.5, -2)", "wait(2.5)")
    assert load(text).skills["upload"].execute == (Wait(2.5),)


def test_a_skill_may_be_steps_and_other_skills(load: Load, good: str) -> None:
    text = good.replace("fly(to)", "[fly(to), land(), charge(80), take_off(), upload(A)]")
    text = text.replace("    cost: 10\n", "    cost: 10\n    retry_after_s: 60\n")
    text = text.replace("    until:", "    restores: [canUpload]\n    until:")
    mission = load(text)
    assert mission.skills["move"].execute == (
        Fly("to"),
        Land(),
        Charge(80.0),
        TakeOff(),
        Do("upload", ("A",)),
    )
    assert mission.skills["upload"].retry_after_s == 60
    assert mission.events["low"].restores == {"canUpload"}


def test_beliefs_are_not_facts_of_the_start(load: Load, good: str) -> None:
    assert load(good).initially == {"at(Home)"}


def test_task_is_read_alike_from_every_kind_of_scalar(load: Load, good: str) -> None:
    task = load(good).task
    assert list(task) == ["search", "upload", "avoid"]
    assert task["upload"] is parse("G (found -> F reported)")
    literal = good.replace("upload: >", "upload: |-").replace(
        "'G !(at(no) & low)'", '"G !(at(no) & low)"'
    )
    assert load(literal).task == task


@pytest.mark.parametrize("word", ["yes", "on", "off", "y", "n", "null", "true", "F", "e1"])
def test_places_may_have_names_that_yaml_or_the_formula_language_know(
    load: Load, good: str, word: str
) -> None:
    text = re.sub(r"\bA\b(?=[:,)])", word if word != "null" else "'null'", good)
    text = text.replace("'null')", "null)")
    if word in ("null", "true"):  # values of YAML: quoted in a list, and plain as a key
        text = re.sub(rf"\[(.*?)'?\b{word}\b'?, no\]", rf"[\1'{word}', no]", text)
        text = text.replace("latch: 'true'", "latch: true")
    mission = load(text)
    assert word in mission.places
    assert word in mission.sets["Site"]
