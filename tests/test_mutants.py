"""What scripts/mutate makes and lists, without running it: that takes minutes."""

from __future__ import annotations

import ast
import tomllib
from pathlib import Path

import pytest
from mutants import mutants, names

ROOT = Path(__file__).parents[1]


@pytest.mark.parametrize(
    ("source", "made"),
    [
        ("a <= b", ["a <= b -> a < b", "a <= b -> a >= b"]),
        ("a is b", ["a is b -> a is not b"]),
        ("a and b", ["a and b -> a or b"]),
        ("not a", ["not a -> a and a"]),
        ("a - b", ["a - b -> a + b"]),
        ("-a", ["-a -> +a"]),
        ("True", ["True -> False"]),
        ("0.5", ["0.5 -> 5.0"]),
        ("0", ["0 -> 1"]),
        ("(a, b)", ["(a, b) -> (b, a)"]),
        ("(a, a)", []),
        ("(a, b, c)", ["(a, b, c) -> (b, c)", "(a, b, c) -> (a, c)", "(a, b, c) -> (a, b)"]),
        ("f()", ["f() -> pass"]),
        ("'a text'", []),
        ("a: Literal[1] = b", []),
        ("A = tuple[int, str]", []),
        ("a.b[0, c]", ["(0, c) -> (c, 0)", "0 -> 1"]),
        ("(a, b) = c", []),
    ],
)
def test_one_mistake_each(source: str, made: list[str]) -> None:
    assert names(source) == [f"module: {change}" for change in made]


def test_a_mutant_differs_in_one_place_and_the_source_is_left_alone() -> None:
    source = "def f(a):\n    return a < 1 and a < 2"
    texts = {ast.unparse(mutant.tree) for mutant in mutants(source)}
    assert "def f(a):\n    return a <= 1 and a < 2" in texts
    assert "def f(a):\n    return a < 1 and a <= 2" in texts
    assert len(texts) == len(mutants(source)) and source not in texts
    assert [mutant.name for mutant in mutants(source)] == names(source)


def test_two_of_a_kind_have_two_names() -> None:
    assert names("a + a\na + a") == ["module: a + a -> a - a", "module: a + a -> a - a #2"]


def test_each_listed_survivor_is_a_mutant_with_a_reason() -> None:
    listed = tomllib.loads((ROOT / "tests/survivors.toml").read_text(encoding="utf-8"))
    survivors = listed.get("survivor", [])
    sources = {e["file"]: (ROOT / e["file"]).read_text(encoding="utf-8") for e in survivors}
    made = {file: set(names(source)) for file, source in sources.items()}
    for entry in survivors:
        assert entry["mutant"] in made[entry["file"]], entry
        assert len(entry["why"]) > 20


def test_the_tests_that_it_runs_exist() -> None:
    """A module whose tests are not found has no mutant killed, and none counted."""
    source = (ROOT / "scripts/mutate").read_text(encoding="utf-8")
    named = {
        node.value
        for node in ast.walk(ast.parse(source))
        if isinstance(node, ast.Constant)
        and isinstance(node.value, str)
        and node.value.startswith("unit/")
    }
    assert len(named) > 5
    assert [name for name in sorted(named) if not (ROOT / "tests" / name).is_file()] == []
