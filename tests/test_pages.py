"""ARCHITECTURE.md and docs/ speak of what is there: files, packages, libraries, decisions."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
ARCHITECTURE = ROOT / "ARCHITECTURE.md"
DECISIONS = ROOT / "docs" / "decisions"
TOPICS = sorted(set(DECISIONS.glob("*.md")) - {DECISIONS / "README.md"})
PAGES = [ROOT / "README.md", ARCHITECTURE, *sorted((ROOT / "docs").rglob("*.md"))]
PATH = re.compile(r"`((?:companion|docs|missions|scripts|sitl|tests)/[\w./-]*)`")
LINK = re.compile(r"\]\((?!https?:)([^)#]+)")


def requirements() -> list[str]:
    """Names of all libraries in pyproject.toml."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    lists = [project["dependencies"], *project["optional-dependencies"].values()]
    found = {re.split(r"[\[><=;]", line)[0] for lines in lists for line in lines}
    return sorted(found - {project["name"]})


def test_the_architecture_fits_two_pages() -> None:
    lines = ARCHITECTURE.read_text(encoding="utf-8").splitlines()
    assert len(lines) < 150


@pytest.mark.parametrize("package", ["companion", "sitl"])
def test_the_layout_is_that_of_a_package(package: str) -> None:
    """Every module and folder at its top has a line, and nothing else has."""
    text = ARCHITECTURE.read_text(encoding="utf-8")
    block = re.search(rf"^{package}/\n((?:  .*\n)+)", text, re.MULTILINE)
    assert block is not None
    told = set()
    for line in re.findall(r"^  (\S.*)$", block[1], re.MULTILINE):
        told |= set(re.findall(r"(?:^|(?<=  ))(\w+(?:/|\.py))", line.split("   ")[0]))
    there = {
        f"{path.name}/" if path.is_dir() else path.name
        for path in (ROOT / package).iterdir()
        if (path.is_dir() and path.name != "__pycache__") or path.suffix == ".py"
    }
    assert told == there - {"__init__.py", "__main__.py"}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_what_a_page_names_is_there(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    missing = [path for path in PATH.findall(text) if not (ROOT / path).exists()]
    missing += [link for link in LINK.findall(text) if not (page.parent / link).exists()]
    assert not missing


def test_each_decision_page_is_in_the_index() -> None:
    index = (DECISIONS / "README.md").read_text(encoding="utf-8")
    assert re.findall(r"^\| \[[\w-]+\]\(([\w.-]+)\) ", index, re.MULTILINE)
    assert {f"({path.name})" for path in TOPICS} == set(re.findall(r"\([\w-]+\.md\)", index))


@pytest.mark.parametrize("topic", TOPICS, ids=lambda topic: topic.stem)
def test_each_decision_says_what_was_rejected(topic: Path) -> None:
    text = topic.read_text(encoding="utf-8")
    assert not re.search(r"\b20\d\d-\d\d\b", text), "decisions are undated"
    if topic.stem == "dependencies":
        return
    for title, body in re.findall(r"^## (.+)\n([^#]*)", text, re.MULTILINE):
        assert "Rejected" in body, title


@pytest.mark.parametrize("library", requirements())
def test_each_library_has_its_reason(library: str) -> None:
    assert re.search(rf"\b{re.escape(library)}\b", ARCHITECTURE.read_text(encoding="utf-8"))
    reasons = (DECISIONS / "dependencies.md").read_text(encoding="utf-8")
    assert re.search(rf"\*\*[^*]*\b{re.escape(library)}\b|\({library}|{library}\)", reasons)
