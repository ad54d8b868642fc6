"""The documentation as a site: every page has its place, and what leads nowhere fails the build."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import pytest
from make_site import (
    CONFIGURATION,
    ROOT,
    STYLE,
    SiteError,
    as_zensical_reads_it,
    build,
    collect,
    links,
    pages,
    with_pictures,
)

HOME = "# Home\n\nTo [more](docs/more.md#below), and a ![picture](docs/picture.png).\n"
MORE = "# More\n\n## Below\n\n[Back](../README.md), [here](#below), `[code](nowhere)`.\n"
NAVIGATION = '[project]\nsite_name = "x"\ndocs_dir = "pages"\nnav = ["README.md", "docs/more.md"]\n'


@pytest.fixture
def small(tmp_path: Path) -> Path:
    """A repository with two pages."""
    (tmp_path / "docs").mkdir()
    (tmp_path / "README.md").write_text(HOME, encoding="utf-8")
    (tmp_path / "docs" / "more.md").write_text(MORE, encoding="utf-8")
    (tmp_path / "docs" / "picture.png").write_bytes(b"")
    (tmp_path / STYLE).touch()
    (tmp_path / CONFIGURATION).write_text(NAVIGATION, encoding="utf-8")
    return tmp_path


def test_pages_and_what_they_link_to_are_collected(tmp_path: Path) -> None:
    """Those of the project: so its links lead to files, and its navigation to each page once."""
    collect(ROOT, tmp_path)
    assert (tmp_path / "missions" / "surveillance.png").is_file()
    assert {page for page in pages(ROOT) if not (tmp_path / page).is_file()} == set()


def test_links_in_code_are_none() -> None:
    assert links("[a](b.md#c) [a](b.md)\n```\n[d](e)\n```\n`[f](g)` <h> [i](https://j)") == ["b.md"]


def test_a_bar_in_the_code_of_a_table_is_not_escaped() -> None:
    """GitHub wants it, and Python's Markdown shows it."""
    page = "| `a \\| b` | c \\| d |\n`e \\| f`\n"
    assert as_zensical_reads_it(page) == "| `a | b` | c \\| d |\n`e \\| f`\n"


def test_a_diagram_becomes_a_picture_beside_its_page(tmp_path: Path) -> None:
    diagram = "```mermaid\nstateDiagram-v2\n    [*] --> off: made\n```"
    page = with_pictures(f"{diagram}\nand\n{diagram}\n", tmp_path / "lamp.md")
    pictures = [f"[![State diagram](lamp-{i}.svg){{ .diagram }}](lamp-{i}.svg)" for i in (1, 2)]
    assert page == f"{pictures[0]}\nand\n{pictures[1]}\n"
    assert "made" in (tmp_path / "lamp-2.svg").read_text(encoding="utf-8")


@pytest.mark.long
@pytest.mark.slow
def test_the_site_is_built_and_asks_no_other_host_for_anything(tmp_path: Path) -> None:
    """Links may lead elsewhere; what a page loads by itself is its own."""
    build(ROOT, tmp_path / "built")
    site = tmp_path / "built" / "site"
    assert "MAV companion" in (site / "index.html").read_text(encoding="utf-8")
    loads = re.compile(
        r"""<(?:script|img|iframe|source|link)\b[^>]*\b(?:src|href)=["']?(https?:[^"'\s>]*)"""
    )
    for page in site.rglob("*.html"):
        text = page.read_text(encoding="utf-8")
        assert loads.findall(text) == [] and 'class="mermaid"' not in text, page


@pytest.mark.parametrize("link", ["docs/nothing.png", "docs", "../outside"])
def test_a_link_to_no_file_fails(small: Path, link: str) -> None:
    with (small / "README.md").open("a", encoding="utf-8") as page:
        page.write(f"[gone]({link})\n")
    with pytest.raises(SiteError, match=rf"README\.md: {link} is no file"):
        collect(small, small / "collected")


@pytest.mark.slow
@pytest.mark.parametrize(
    "link", ["docs/more.md#nowhere", pytest.param("#nowhere", marks=pytest.mark.long)]
)
def test_a_link_to_no_heading_fails(small: Path, link: str) -> None:
    build(small, small / "built")
    with (small / "README.md").open("a", encoding="utf-8") as page:
        page.write(f"[gone]({link})\n")
    with pytest.raises(SiteError, match="anchor does not exist"):
        build(small, small / "built")


def test_a_page_without_a_place_in_the_navigation_fails(small: Path) -> None:
    shutil.copy(small / "docs/more.md", small / "docs/other.md")
    with pytest.raises(SiteError, match=r"one place for each page: docs/other\.md"):
        collect(small, small / "collected")
