"""docs/glossary.md and the names in the code agree: one word means one thing."""

from __future__ import annotations

import ast
import re
from collections import defaultdict
from collections.abc import Iterator
from fnmatch import fnmatchcase
from pathlib import Path
from typing import NamedTuple

import pytest

ROOT = Path(__file__).parents[1]
GLOSSARY = ROOT / "docs" / "glossary.md"
HEAD_OF_TERMS = ["word", "meaning", "source", "in the code"]
HEAD_OF_UNUSED = ["word", "instead", "names"]


class Name(NamedTuple):
    """A name in the code."""

    text: str
    kind: str
    path: Path

    def __str__(self) -> str:
        return f"{self.kind} {self.text} in {self.path.relative_to(ROOT)}"


def tables(head: list[str]) -> Iterator[list[str]]:
    """The rows of all tables of the glossary with a head."""
    is_wanted = False
    for line in GLOSSARY.read_text(encoding="utf-8").splitlines():
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        if not line.startswith("|"):
            is_wanted = False
        elif cells == head:
            is_wanted = True
        elif is_wanted and set(line) - set("|-"):
            yield cells


def names() -> Iterator[Name]:
    """The modules, public classes and functions, and module-level variables of our packages."""
    for package in ("companion", "sitl"):
        for path in sorted((ROOT / package).rglob("*.py")):
            module = path.parent.name if path.stem == "__init__" else path.stem
            yield Name(module, "module", path)
            tree = ast.parse(path.read_text(encoding="utf-8"))
            yield from defined(tree.body, path)
            for statement in tree.body:
                for target in targets_of(statement):
                    if isinstance(target, ast.Name):
                        yield Name(target.id, "variable", path)


def defined(statements: list[ast.stmt], path: Path) -> Iterator[Name]:
    """Public classes and functions, and those of public classes."""
    for node in statements:
        if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
            yield Name(node.name, "class", path)
            yield from defined(node.body, path)
        elif isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            if not node.name.startswith("_"):
                yield Name(node.name, "function", path)
        elif isinstance(node, ast.If):  # for type checkers
            yield from defined(node.body, path)


def targets_of(statement: ast.stmt) -> list[ast.expr]:
    """What a statement assigns to."""
    if isinstance(statement, ast.Assign):
        return statement.targets
    return [statement.target] if isinstance(statement, ast.AnnAssign) else []


def in_snake_case(name: str) -> str:
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", name).lower()


def is_meant(pattern: str, name: Name) -> bool:
    """Whether a name is one of those that a pattern of the glossary stands for.

    A pattern may begin with a package, outside of which the word is used: symbols are grounded.
    """
    package, _, pattern = pattern.rpartition("/")
    return (
        name.kind != "variable"
        and fnmatchcase(in_snake_case(name.text), pattern)
        and (not package or package in name.path.parts)
    )


NAMES = list(names())
TERMS = list(tables(HEAD_OF_TERMS))
UNUSED = list(tables(HEAD_OF_UNUSED))


def test_the_glossary_is_read() -> None:
    assert 40 <= len(TERMS) <= 110
    assert len(UNUSED) >= 18
    words = [word for word, *_ in TERMS]
    assert len(set(words)) == len(words)
    for word, meaning, source, where in TERMS:
        assert re.fullmatch(r"[^.]+(\.py)?[^.]*\.", meaning), f"{word}: one sentence"
        assert source and where, word


@pytest.mark.parametrize(("word", "where"), [(word, where) for word, _, _, where in TERMS])
def test_a_term_is_where_it_is_said_to_be(word: str, where: str) -> None:
    name = where.strip("`")
    if name.endswith(".py"):
        found = [n for n in NAMES if n.kind == "module" and n.path.name == name]
    else:
        found = [n for n in NAMES if n.text == name]
    assert found, f"{word}: there is no {name}"


@pytest.mark.parametrize(("word", "patterns"), [(word, names) for word, _, names in UNUSED])
def test_a_word_that_is_not_used_is_in_no_name(word: str, patterns: str) -> None:
    found = [n for p in re.findall(r"`(.+?)`", patterns) for n in NAMES if is_meant(p, n)]
    assert not found, f"{word}: " + "; ".join(map(str, found))


@pytest.mark.parametrize(("word", "instead"), [(word, instead) for word, instead, _ in UNUSED])
def test_what_is_said_instead_is_explained(word: str, instead: str) -> None:
    words = {term for term, *_ in TERMS}
    for part in instead.split(", "):
        assert any(term in part for term in words) or part == "instantiated", f"{word}: {part}"


def test_a_public_class_has_a_name_of_its_own() -> None:
    places = defaultdict(list)
    for name in NAMES:
        if name.kind == "class":
            places[name.text].append(str(name.path.relative_to(ROOT)))
    twice = {name: paths for name, paths in places.items() if len(paths) > 1}
    assert not twice, twice
