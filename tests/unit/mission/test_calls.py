"""Calls are read as they are written, and a text that is none says where and why."""

from __future__ import annotations

import pytest

from companion.errors import FormulaError
from companion.mission.calls import read_call
from companion.mission.execution import FORMS, parse_execution
from companion.mission.steps import Charge, Do, Fly, Wait


@pytest.mark.parametrize(
    ("text", "kinds"),
    [
        ("land()", []),
        (" fly ( to ) ", ["NAME"]),
        ("f(-2, +1.5e3, .5, 1.)", ["INTEGER", "DECIMAL", "DECIMAL", "DECIMAL"]),
        ("f(1234567890123456)", ["DECIMAL"]),  # more digits than a whole number is held by
        ("f(a.b, a-b.c_2, *)", ["DOTTED", "DOTTED", "WORD"]),
        ("""f("a, (b", 'c"d',)""", ["TEXT", "TEXT"]),
        ("f(5 min, 80%, 2.5kg, 90°)", ["QUANTITY"] * 4),
    ],
)
def test_arguments_have_kinds(text: str, kinds: list[str]) -> None:
    call = read_call(text, "not a call", {})
    assert [argument.value.type for argument in call.arguments] == kinds


def test_arguments_may_have_names() -> None:
    call = read_call("f(a, b = 2)", "not a call", {})
    assert [(a.name, a.value) for a in call.arguments] == [(None, "a"), ("b", "2")]
    with pytest.raises(FormulaError, match="f takes no argument by name"):
        call.refuse_names("f(argument, ...)")


@pytest.mark.parametrize(
    ("text", "what", "advice"),
    [
        ("§fly to", "not something to execute", "write fly(parameter)"),
        ("§photo.py", "not something to execute", "python(name, arguments)"),
        (
            "§fly(to",
            "not something to execute",
            'not closed; inside { } and [ ] put quotes around "fly',
        ),
        ("fly(to)§, land()", "not something to execute", "write a list: [fly(to), land()]"),
        ("fly(to) §& land()", "not something to execute", "as a list: [fly(to), ...]"),
        ("fly(to)§)", "not something to execute", "a call ends at its parenthesis"),
        ("wait(5 §6)", "not an argument", "with commas between"),
        ("command(payload,§, 3)", "not an argument", "with commas between"),
        ('say(§"a)', "not an argument", "ends with the same quote"),
        ("wait(§5 min)", "5 min is not a number", "write seconds: 300"),
        ("wait(§5s)", "5s is not a number", "write the number alone: 5"),
        ("charge(§80 %)", "80 % is not a number", "write the number alone: 80"),
        ("charge(§1 h)", "1 h is not a number", "write a number of percent"),
        ("wait(§soon)", "soon is not a number", "write e.g. 1.5"),
        ("wait(§1_000)", "1_000 is not a number", "write e.g. 1.5"),
        ("wait(§seconds=5)", "wait takes no argument by name", "write wait(seconds)"),
        ("move(§to=A)", "move takes no argument by name", "move(argument, ...)"),
        ("§rtl()", "unknown primitive rtl", "F G at(Home)"),
        ("§goto(to)", "unknown primitive goto", "Did you mean fly?"),
    ],
)
def test_what_is_no_step_says_where_and_what_to_write(text: str, what: str, advice: str) -> None:
    offset = text.index("§")
    with pytest.raises(FormulaError) as refused:
        parse_execution(text.replace("§", ""), ("to",), {"payload": 100}, ("move",))
    assert what in refused.value.what
    assert advice in refused.value.advice
    assert refused.value.offset == offset


def test_a_comma_may_follow_the_last_argument() -> None:
    assert parse_execution("fly(to,)", ("to",), {}) == Fly("to")
    assert parse_execution("move(a, b, )", (), {}, ("move",)) == Do("move", ("a", "b"))


def test_a_number_may_be_written_as_in_python() -> None:
    assert [parse_execution(f"wait({text})", (), {}) for text in ("5", "5.", ".5", "5e1")] == [
        Wait(5.0),
        Wait(5.0),
        Wait(0.5),
        Wait(50.0),
    ]
    assert parse_execution("charge( auto )", (), {}) == Charge(None)
    assert set(FORMS) >= {"fly", "python"}
