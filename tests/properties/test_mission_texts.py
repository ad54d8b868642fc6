"""Whatever a text of a mission says, its reader understands it or refuses it at a place in it."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from hypothesis import given
from hypothesis import strategies as st

from companion.errors import FormulaError
from companion.mission.calls import read_call
from companion.mission.conditions import parse_condition
from companion.mission.execution import parse_execution
from companion.mission.literals import parse_effect, parse_fact, parse_literals
from companion.mission.mavlink_names import COMMANDS
from companion.mission.python_call import parse_python
from companion.mission.signals import COMMAND, COMPARISONS, REPORT, Condition, Signal
from companion.skills.authoring import FunctionKind

WORDS = [
    *"()[]{},.=!<>&|-+\"'%°#*:; \t\n0159_Aaé٣",
    *("fly", "to", "python", "true", "nan", "1e5", "1e999", "is silent", "and", "or", "MAV_CMD_"),
    *("EVENT", "COMMAND", "BATTERY_STATUS", "battery_remaining", "NAMED_VALUE_INT", "[target]"),
    *("at(A)", "->", "==", "km/h", "x=", "payload", "MAV_CMD_USER_1", "\u2028", "\x00"),
]
TEXTS = st.one_of(st.lists(st.sampled_from(WORDS), max_size=14).map("".join), st.text(max_size=30))
BEGUN = st.sampled_from(
    [
        *("fly(to)", "python(f, a, x=2)", "command(payload, MAV_CMD_USER_1, 1)", "wait(5 min)"),
        *("NAMED_VALUE_INT[target].value > 0", "EVENT[a] is silent", "COMMAND.MAV_CMD_USER_1"),
        *("at(to) & !at(from)", "a & (b -> c(x))"),
    ]
)


@st.composite
def spoilt(draw: st.DrawFn) -> str:
    """A good text in which something is replaced."""
    text: str = draw(BEGUN)
    word: str = draw(st.sampled_from(["", *WORDS]))
    begin = draw(st.integers(0, len(text)))
    return text[:begin] + word + text[begin + draw(st.integers(0, 6)) :]


READERS: dict[str, Callable[[str], object]] = {
    "step": lambda text: parse_execution(text, ("to",), {"payload": 100}, ("move",)),
    "call": lambda text: read_call(text, "not a call", {"f": "f(x)"}),
    "function": lambda text: parse_python(text, FunctionKind.SKILL),
    "condition": parse_condition,
    "literals": parse_literals,
    "effect": parse_effect,
    "fact": parse_fact,
}


@pytest.mark.parametrize("reader", READERS)
@given(text=st.one_of(TEXTS, spoilt()))
def test_a_text_is_read_or_refused_at_a_place_in_it(reader: str, text: str) -> None:
    try:
        READERS[reader](text)
    except FormulaError as refused:
        assert refused.text == text
        assert 0 <= refused.offset <= len(text)
        assert refused.what and refused.advice


NAMES = st.from_regex(r"\A[A-Za-z_][A-Za-z0-9_]{0,9}\Z")
INSTANCES = st.from_regex(r"\A[!-Z^-~]([ !-Z^-~]{0,8}[!-Z^-~])?\Z")  # no brackets, no outer blanks
SIGNALS = st.one_of(
    st.builds(Signal, st.just(REPORT), NAMES, st.just("")),
    st.builds(Signal, st.just("NAMED_VALUE_FLOAT"), INSTANCES, st.just("value")),
    st.builds(Signal, st.just("VFR_HUD"), st.just(""), st.sampled_from(["alt", "climb"])),
)


@given(
    signal=SIGNALS,
    comparison=st.sampled_from(list(COMPARISONS)),
    threshold=st.integers(-10_000, 10_000).map(lambda n: n / 8),
)
def test_a_condition_is_read_as_it_is_shown(
    signal: Signal, comparison: str, threshold: float
) -> None:
    condition = Condition(signal, comparison, float(f"{threshold:g}"))
    assert parse_condition(str(condition)) == condition


@given(command=st.sampled_from(sorted(COMMANDS)))
def test_a_command_is_read_as_it_is_shown(command: str) -> None:
    condition = Condition(Signal(COMMAND, "", command), "!=", 0.0)
    assert parse_condition(str(condition)) == condition
