"""Each hazard of the catalogue has a promise and tests that exist; docs/SAFETY.md tells them."""

from __future__ import annotations

import ast
import runpy
from functools import cache
from pathlib import Path
from typing import Any

import pytest

TESTS = Path(__file__).parent
SCRIPT: dict[str, Any] = runpy.run_path(str(TESTS.parent / "scripts" / "make_safety.py"))
GROUPS = SCRIPT["catalogue"]()
HAZARDS = [hazard for hazards in GROUPS.values() for hazard in hazards]


def functions(text: str) -> set[str]:
    """The tests at the top of a file, which are those that pytest collects."""
    return {node.name for node in ast.parse(text).body if isinstance(node, ast.FunctionDef)}


@cache
def collected_from(file: str) -> set[str]:
    path = TESTS / file
    assert path.name.startswith("test_")  # pytest collects no other
    return {f for f in functions(path.read_text(encoding="utf-8")) if f.startswith("test_")}


def test_the_page_is_current() -> None:
    """If this fails: python scripts/make_safety.py."""
    text = SCRIPT["PAGE"].read_text(encoding="utf-8")
    assert text == SCRIPT["page"](text, GROUPS)


def test_all_hazards_are_there_in_their_order() -> None:
    assert [hazard.number for hazard in HAZARDS] == list(range(1, 60))


@pytest.mark.parametrize("hazard", HAZARDS, ids=lambda hazard: str(hazard.number))
def test_each_is_shown_by_tests_that_exist(hazard: Any) -> None:
    assert hazard.promise.endswith(".") and (hazard.outside or ".").endswith(".")
    assert hazard.tests and len(set(hazard.tests)) == len(hazard.tests)
    for test in hazard.tests:
        file, _, function = test.partition("::")
        assert function in collected_from(file), test


def test_a_test_in_a_function_or_in_a_class_is_none() -> None:
    text = "def test_a():\n    def test_b(): ...\nclass C:\n    def test_c(self): ...\n"
    assert functions(text) == {"test_a"}


def test_a_page_without_a_place_for_them_is_an_error() -> None:
    with pytest.raises(ValueError, match="not one place for the hazards"):
        SCRIPT["page"]("no place\n", GROUPS)
