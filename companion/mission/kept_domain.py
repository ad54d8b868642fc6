"""Keeps what a mission's PDDL files say beside the mission, so that they are parsed only once.

The PDDL parser takes 70 MB and a second. So the child process that checks an upload saves what it
has read, and the process that flies loads that. The file is JSON, in the terms of a mission file.
"""

from __future__ import annotations

import json
from pathlib import Path

from companion.documents import Document
from companion.errors import MissionError
from companion.mission.pddl_domain import Predicates, with_domain
from companion.mission.schema import MissionFile

KEPT = ".domain.json"
"""Ending of the saved file; no client of MAVLink FTP can use this name."""


def read_and_keep(
    file: MissionFile, document: Document, folder: Path
) -> tuple[MissionFile, Predicates]:
    """Does the same as `with_domain`, and saves the result.

    Raises:
        MissionError: as `with_domain`; or the result cannot be saved.
    """
    merged, predicates = with_domain(file, document, folder)
    if file.domain is not None:
        kept = {"mission": merged.model_dump(mode="json", exclude_none=True)}
        text = json.dumps(kept | {"predicates": predicates})
        try:
            (folder / KEPT).write_text(text, encoding="utf-8")
        except OSError as error:
            what = f"what {file.domain} says cannot be kept: {error.strerror}"
            raise MissionError(what, document.where("domain")) from error
    return merged, predicates


def kept_domain(
    file: MissionFile, document: Document, folder: Path
) -> tuple[MissionFile, Predicates]:
    """Loads what was saved beside a mission; without PDDL files there is nothing to load.

    Raises:
        MissionError: the file is missing or damaged.
    """
    if file.domain is None:
        return with_domain(file, document, folder)
    try:
        kept = json.loads((folder / KEPT).read_text(encoding="utf-8"))
        merged = MissionFile.model_validate(kept["mission"])
        return merged, {
            str(name): tuple(tuple(map(str, members)) for members in domains)
            for name, domains in kept["predicates"].items()
        }
    except (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        what = f"what was read of {file.domain} is missing or damaged; upload the mission again"
        raise MissionError(what, document.where("domain")) from error
