"""Any formula has an answer, or an error that names the limit: no hang, no crash, 512 MB.

Each formula runs in a process of its own that may take 512 MB and a minute of CPU time, of which
the slowest needs a few seconds; more ends it, and the test fails. Nothing else is timed. Time and
memory are counted (`companion/ltl/budget.py`), so
the answer is the same on every machine.
"""

from __future__ import annotations

import re
import subprocess
import sys

import pytest

from companion.errors import Location
from companion.ltl.budget import Budget, TranslationLimit
from companion.ltl.parser import parse
from companion.ltl.translate import translate

HANGING_S = 900.0  # wall time
DEPTH = 20_000
ATOMS = 5_000


def joined(operator: str, scheme: str, count: int = ATOMS) -> str:
    """The scheme for # = 0, 1, 2, ..., joined by an operator."""
    return operator.join(f"({scheme.replace('#', str(i))})" for i in range(count))


def nested(operators: str, count: int) -> str:
    """((p0 U p1) R p2) ... with the operators in turn."""
    parts = [f" {operators[i % len(operators)]} p{i + 1})" for i in range(count)]
    return "(" * count + "p0" + "".join(parts)


FAMILIES = {
    "X": "X " * DEPTH + "a",
    "X of many": "X " * 3000 + f"F ({joined(' & ', 'a#', 14)})",
    "X of marks": "X " * 3000 + f"({joined(' & ', 'G (a# -> F b#)', 3)})",
    "and of X": joined(" & ", "X " * 400 + "(a# U b#)", 200),
    "F": "F " * DEPTH + "a",
    "G": "G " * DEPTH + "a",
    "negations": "!" * DEPTH + "a",
    "G F": "G F " * (DEPTH // 2) + "a",
    "X F": "X F " * (DEPTH // 2) + "a",
    "brackets": "(" * DEPTH + "a" + ")" * DEPTH,
    "right-deep U": "a U " * DEPTH + "b",
    "right-deep U of three": "a U b U " * (DEPTH // 2) + "c",
    "left-deep U": "(" * DEPTH + "a" + " U b)" * DEPTH,
    "U and R": "a U (b R (" * (DEPTH // 2) + "c" + "))" * (DEPTH // 2),
    "& and |": "a & (b | (" * (DEPTH // 2) + "c" + "))" * (DEPTH // 2),
    "->": "a -> " * DEPTH + "b",
    "<->": "a <-> " * DEPTH + "b",
    "<-> of many": joined(" <-> ", "a#", DEPTH),
    "and": joined(" & ", "a#"),
    "or": joined(" | ", "a#"),
    "and of F": joined(" & ", "F a#"),
    "or of F": joined(" | ", "F a#"),
    "and of U": joined(" & ", "a# U b#", ATOMS // 2),
    "or of U": joined(" | ", "a# U b#", ATOMS // 2),
    "and of G F": joined(" & ", "G F a#"),
    "or of G F": joined(" | ", "G F a#"),
    "or of G": joined(" | ", "G a#"),
    "G of or": f"G ({joined(' | ', 'a#')})",
    "paper": f"G ({joined(' & ', 'F a# | t')})",
    "fairness": joined(" & ", "G F a# -> G F b#", ATOMS // 2),
    "fairness of 40": joined(" & ", "G F a# -> G F b#", 40),
    "patrol": f"ordered_patrolling({', '.join(f'p{i}' for i in range(ATOMS))})",
    "visit": f"strict_ordered_visit({', '.join(f'p{i}' for i in range(ATOMS))})",
    "nested U and R": nested("UR", 200),
    "nested U and R, to the right": "".join(f"p{i} {'UR'[i % 2]} " for i in range(200)) + "q",
    "<-> of F": joined(" <-> ", "F a#", 200),
    "<-> of U": joined(" <-> ", "a# U b#", 100),
    "memory": f"G (a -> {'X ' * 1000}b)",
    "choices": joined(" & ", "a# | b#", 14),
    "binary counter": joined(" & ", f"G (X b# <-> (b# <-> !({joined(' & ', 'c#', 10)})) U d#)", 14),
}
"""Deep, broad and exponential formulas."""


CONJUNCTIONS = (
    "& and |",
    "and",
    "and of X",
    "and of F",
    "and of U",
    "and of G F",
    "paper",
    "fairness",
    "fairness of 40",
    "patrol",
    "visit",
    "choices",
    "binary counter",
)
"""Formulas with several conjuncts."""


SPLIT, WHOLE = (), ("--monolithic", "--state-based")
QUICK = {
    ("negations", WHOLE),
    ("and", SPLIT),
    ("fairness of 40", SPLIT),
    ("memory", WHOLE),
    ("choices", WHOLE),
    ("choices", SPLIT),
}
"""Those of every run; together they meet every limit but that of memory, and have answers."""


def cases() -> list[object]:
    """Every formula as one automaton, and conjunctions by their conjuncts too."""
    named = [(name, WHOLE) for name in FAMILIES] + [(name, SPLIT) for name in CONJUNCTIONS]
    return [
        pytest.param(
            name,
            options,
            id=f"{name}, {'whole' if options else 'split'}",
            marks=[] if (name, options) in QUICK else [pytest.mark.long],
        )
        for name, options in named
    ]


CHILD = """
import resource, sys
resource.setrlimit(resource.RLIMIT_AS, (512 << 20, 512 << 20))
resource.setrlimit(resource.RLIMIT_CPU, (60, 60))
from companion.cli import main
sys.argv = ["companion", "ltl", "--batch", "-", *sys.argv[1:]]
main()
"""


@pytest.mark.slow
@pytest.mark.parametrize(("family", "options"), cases())
def test_an_answer_or_a_limit(family: str, options: tuple[str, ...]) -> None:
    done = subprocess.run(
        [sys.executable, "-c", CHILD, *options],
        input=FAMILIES[family],
        capture_output=True,
        text=True,
        timeout=HANGING_S,
        check=False,
    )
    assert done.returncode in (0, 2), f"ended by {done.returncode}: {done.stderr[-500:]}"
    if done.returncode == 0:
        assert done.stdout.endswith("--END--\n")
    else:
        limits = r"<stdin>:1:1: the automaton .* more than [\d,]+ (states|transitions|steps|MB)"
        assert re.match(limits, done.stderr)


@pytest.mark.parametrize(
    ("text", "is_split"),
    [
        ("F a & F b & F c", False),
        ("G (F a & F b)", False),
        ("F (a & X b)", True),
        ("a | G b", True),
        ("X (G a & F b)", True),
    ],
)
def test_only_what_can_be_split_is_advised_to_be(text: str, is_split: bool) -> None:
    with pytest.raises(TranslationLimit) as limit:
        translate(parse(text), max_states=1)
    assert ("split" in str(limit.value)) is not is_split
    located = str(limit.value.located(Location("mission.yaml", 3, 5)))
    assert located == f"mission.yaml:3:5: {limit.value}"


def test_what_need_not_be_done_takes_from_spare_steps() -> None:
    """They are one store for all conjuncts: a thousand of them take no longer than one."""
    budget = Budget(spare_steps=100)
    for left in (40, 0):
        with budget.spared(60) as spare, pytest.raises(TranslationLimit):
            spare.spend(1000)
        assert budget.spare_steps == left
    automaton = translate(parse("X X X a & F b"), budget=Budget(spare_steps=0))
    assert automaton.states >= translate(parse("X X X a & F b")).states


def test_the_budget_is_spent_to_the_last_step() -> None:
    budget = Budget(steps=10)
    budget.spend(4)
    budget.spend(3, width=1024)
    with pytest.raises(TranslationLimit, match="more than 10 steps of work") as limit:
        budget.spend(1)
    assert limit.value.exit_code == 2


def test_wide_sets_take_more_memory() -> None:
    """A set of 7,500 bits is an int of 1,028 bytes."""
    Budget(kept_bytes=1_000_000).keep(1_000)
    with pytest.raises(TranslationLimit, match="more than 1 MB of memory"):
        Budget(kept_bytes=1_000_000).keep(1_000, width=7_500)
    assert sys.getsizeof(1 << 7_500) < 7_500 // 7 + 128
