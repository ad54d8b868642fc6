"""The names that uploaded files may have, for both ends of the link.

A path is a list of names between slashes. The sender checks all names before it sends anything, so
that its user reads what is wrong: an error over the link is only a number.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence

NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.-]{0,63}")
MISSION_ENDINGS = (".yaml", ".yml")
ENDINGS = (*MISSION_ENDINGS, ".pgm", ".png", ".pddl")
MAX_DEPTH = 4
"""Names of a path."""
ALLOWED = (
    "a name has at most 64 characters, A-Z, a-z, 0-9, _ - and . alone,\n"
    "begins with a letter or digit, and ends in {endings}, in small letters"
)


def problem_of(path: str, endings: Sequence[str] = ENDINGS) -> str | None:
    """Why a file cannot be uploaded under a path; None if it can.

    >>> problem_of("my mission.yaml"), problem_of("Vine.YAML")
    ("its name has ' '", "its name ends in '.YAML'")
    """
    *folders, name = path.split("/")
    if len(folders) >= MAX_DEPTH:
        return f"it lies {len(folders)} folders deep, and {MAX_DEPTH - 1} are allowed"
    if problem := next(_wrong_names(folders, name), None):
        return problem
    if name.endswith(tuple(endings)):
        return None
    _, dot, ending = name.rpartition(".")
    return f"its name ends in {dot + ending!r}" if dot else "its name has no ending"


def advice_on(path: str, is_mission: bool) -> str:
    """What to do about a file that cannot be uploaded under a path."""
    if path.count("/") >= MAX_DEPTH:
        return "move it nearer to the mission, and write so where the mission names it"
    *most, last = MISSION_ENDINGS if is_mission else ENDINGS
    also = "" if is_mission else ", also where the mission names it"
    allowed = ALLOWED.format(endings=f"{', '.join(most)} or {last}")
    return f"rename it{also}: {allowed}"


def _wrong_names(folders: Sequence[str], name: str) -> Iterator[str]:
    whose = {**{folder: f"its folder {folder!r}" for folder in folders}, name: "its name"}
    for each in (*folders, name):
        if NAME.fullmatch(each):
            continue
        if wrong := re.search(r"[^A-Za-z0-9_.-]", each):
            yield f"{whose[each]} has {wrong[0]!r}"
        elif not NAME.match(each):
            yield f"{whose[each]} begins with {each[:1]!r}"
        else:
            yield f"{whose[each]} has {len(each)} characters"
