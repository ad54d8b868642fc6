"""Builds the documentation as a site, with Zensical: build/docs/site.

The pages are those of the repository, where links lead from file to file. So they are collected
into a folder of the same structure, with all files to which they link. A link to a missing file is
an error here, and so is a page that is missing in the navigation of docs/zensical.toml. Zensical
reports links to missing pages or headings. Mermaid diagrams become pictures, so that the site loads
no program from another host.

Usage: scripts/docs
"""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
import tomllib
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import mmdr

ROOT = Path(__file__).parent.parent
CONFIGURATION, STYLE = "docs/zensical.toml", "docs/site.css"
PAGES = ("README.md", "ARCHITECTURE.md", "CHANGELOG.md", "docs/*.md", "docs/decisions/*.md")
BUILT = ROOT / "build" / "docs"
_LINK = re.compile(r"\]\((?!https?:|mailto:)([^)#]+)(?:#[^)]*)?\)")
_DIAGRAM = re.compile(r"^```mermaid\n(.*?)^```$", re.MULTILINE | re.DOTALL)
_CODE = re.compile(r"^```.*?^```$|`[^`\n]+`", re.MULTILINE | re.DOTALL)


class SiteError(Exception):
    """What has to be fixed before the site can be built."""


def pages(root: Path) -> list[Path]:
    """The pages of a repository, from its root."""
    found = (path for pattern in PAGES for path in sorted(root.glob(pattern)))
    return [path.relative_to(root) for path in found]


def links(text: str) -> list[str]:
    """The files to which a page links, as written in the page; links in code do not count."""
    return list(dict.fromkeys(_LINK.findall(_CODE.sub("", text))))


def as_zensical_reads_it(text: str) -> str:
    r"""A page with unescaped bars in the code of tables.

    Other renderers need the escape; Zensical would show it.
    """
    rows = re.compile(r"^\|.*$", re.MULTILINE)
    code = re.compile(r"`[^`\n]+`")
    return rows.sub(lambda row: code.sub(lambda c: c[0].replace(r"\|", "|"), row[0]), text)


def with_pictures(text: str, page: Path) -> str:
    """A page with its diagrams as pictures, which are written beside it and can be opened."""

    def picture(found: re.Match[str]) -> str:
        name = f"{page.stem}-{text.count('```mermaid', 0, found.start()) + 1}.svg"
        (page.parent / name).write_text(mmdr.render(found[1]).svg(), encoding="utf-8")
        return f"[![State diagram]({name}){{ .diagram }}]({name})"

    return _DIAGRAM.sub(picture, text)


def collect(root: Path, folder: Path) -> None:
    """Copies the pages of a repository, and the files that they link to, into a folder.

    Raises:
        SiteError: a file is missing or is a folder, or a page is not exactly once in the
            navigation.
    """
    known = pages(root)
    _check_navigation(root, known)
    for page in known:
        text = (root / page).read_text(encoding="utf-8")
        for link in links(text):
            linked = (root / page.parent / link).resolve()
            if not linked.is_file() or not linked.is_relative_to(root.resolve()):
                raise SiteError(f"{page}: {link} is no file of the repository")
            _copy(root, folder, linked.relative_to(root.resolve()))
    for page in known:
        (folder / page).parent.mkdir(parents=True, exist_ok=True)
        text = with_pictures((root / page).read_text(encoding="utf-8"), folder / page)
        (folder / page).write_text(as_zensical_reads_it(text), encoding="utf-8")


def build(root: Path, built: Path) -> None:
    """Builds the site of a repository.

    Args:
        root: the root of the repository.
        built: a folder that is recreated, with the collected `pages` and the `site`.

    Raises:
        SiteError: says what is wrong.
    """
    shutil.rmtree(built, ignore_errors=True)
    collect(root, built / "pages")
    _copy(root, built / "pages", Path(STYLE))
    shutil.copy(root / CONFIGURATION, built)
    zensical = [sys.executable, "-m", "zensical", "build", "--clean", "--strict"]
    run = subprocess.run(
        [*zensical, "--config-file", built / Path(CONFIGURATION).name],
        capture_output=True,
        text=True,
        env={"NO_COLOR": "1"},
        check=False,
    )
    if run.returncode:
        raise SiteError(run.stdout + run.stderr.partition("Traceback")[0])


def _check_navigation(root: Path, known: Iterable[Path]) -> None:
    with (root / CONFIGURATION).open("rb") as file:
        named = sorted(_named(tomllib.load(file)["project"]["nav"]))
    expected = sorted(page.as_posix() for page in known)
    if named != expected:
        different = sorted({*named, *expected} - ({*named} & {*expected})) or named
        raise SiteError(f"{CONFIGURATION}: one place for each page: {', '.join(different)}")


def _named(entry: Any) -> Iterator[str]:
    """The pages in an entry of the navigation."""
    match entry:
        case str():
            yield entry
        case dict():
            for inner in entry.values():
                yield from _named(inner)
        case _:
            for inner in entry:
                yield from _named(inner)


def _copy(root: Path, folder: Path, path: Path) -> None:
    (folder / path).parent.mkdir(parents=True, exist_ok=True)
    shutil.copy(root / path, folder / path)


if __name__ == "__main__":
    try:
        build(ROOT, BUILT)
    except SiteError as error:
        sys.exit(f"no site: {error}")
    print(f"built {BUILT / 'site' / 'index.html'}")
