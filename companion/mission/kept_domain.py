"""What the PDDL files of a mission say, kept beside it, so that nobody has to parse them again.

Their parser takes 70 MB and a second. So the child that checks an upload keeps what it has read,
and the process that flies reads that: JSON, in the words of a mission file.
"""

from __future__ import annotations

import json
from pathlib import Path

from companion.documents import Document
from companion.errors import MissionError
from companion.mission.pddl_domain import Predicates, with_domain
from companion.mission.schema import MissionFile

KEPT = ".domain.json"
"""Beside the mission; no client of MAVLink FTP can use this name."""


def read_and_keep(
    file: MissionFile, document: Document, folder: Path
) -> tuple[MissionFile, Predicates]:
    """The same as `with_domain`; what it returns is kept.

    Raises:
        MissionError: as there; or it cannot be kept.
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
    """What was kept of a mission in its folder; of one without PDDL files there is nothing to read.

    Raises:
        MissionError: it is missing, or damaged.
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
