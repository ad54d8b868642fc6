"""Rules that no linter has: small files and functions, docstrings that say something."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import pytest

ROOT = Path(__file__).parents[1]
MAX_FILE_LINES, MAX_FUNCTION_LINES = 350, 60  # these are too many
PROGRAMS = sorted(
    [path for folder in ("companion", "sitl", "scripts") for path in (ROOT / folder).rglob("*.py")]
)
TESTS = sorted((ROOT / "tests").rglob("*.py"))
QUESTION = re.compile(r"\?(\s|$)")
POINTER = re.compile(r"^See `[^`]+`( above| below)?\.?$")


class Documented(NamedTuple):
    """A docstring and whose it is."""

    owner: str
    text: str


def docstrings(node: ast.AST) -> Iterator[Documented]:
    """Those of a module, its classes and functions; no expression has any."""
    if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
        text = ast.get_docstring(node)
        if text:
            yield Documented(getattr(node, "name", "the module"), text)
    for child in ast.iter_child_nodes(node):
        if not isinstance(child, ast.expr):
            yield from docstrings(child)


def name_of(path: Path) -> str:
    """The path in the repository, for the names of tests."""
    return str(path.relative_to(ROOT))


@pytest.mark.parametrize("path", PROGRAMS, ids=name_of)
def test_files_and_functions_are_small(path: Path) -> None:
    source = path.read_text(encoding="utf-8")
    assert len(source.splitlines()) < MAX_FILE_LINES
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            lines = (node.end_lineno or node.lineno) - node.lineno + 1
            assert lines < MAX_FUNCTION_LINES, f"{node.name} has {lines} lines"


@pytest.mark.parametrize("path", PROGRAMS + TESTS, ids=name_of)
def test_a_docstring_says_something_and_neither_asks_nor_points(path: Path) -> None:
    found = list(docstrings(ast.parse(path.read_text(encoding="utf-8"))))
    asking = [d.owner for d in found if QUESTION.search(d.text.partition("\n\n")[0])]
    pointing = [d.owner for d in found if POINTER.match(d.text)]
    assert not asking
    assert not pointing
