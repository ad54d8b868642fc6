"""Where the files of an upload go, and which of them a companion would refuse."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path, PurePosixPath

from companion.errors import MissionError
from companion.ground.ftp_sessions import MAX_FILE_BYTES
from companion.ground.upload_names import ENDINGS, MISSION_ENDINGS, advice_on, problem_of


def remote_paths(files: Sequence[Path], folder: Path) -> dict[Path, PurePosixPath]:
    """The paths of a mission's files on the companion.

    Args:
        files: the last one is the mission.
        folder: the root of the upload.

    Raises:
        MissionError: some cannot be uploaded; lists them, with what to do.
    """
    root = folder.resolve()
    remotes = {file: PurePosixPath(file.resolve().relative_to(root)) for file in files}
    refused = [
        refusal
        for file, path in remotes.items()
        if (refusal := _refusal(file, str(path), is_mission=file == files[-1])) is not None
    ]
    if refused:
        first, *others = refused
        raise MissionError(first.what, hint=first.hint, others=others)
    return {file: PurePosixPath("/", path) for file, path in remotes.items()}


def _refusal(file: Path, path: str, is_mission: bool) -> MissionError | None:
    problem = problem_of(path, MISSION_ENDINGS if is_mission else ENDINGS)
    advice = advice_on(path, is_mission)
    size = file.stat().st_size
    if problem is None and size > MAX_FILE_BYTES:
        problem, advice = f"it has {size} bytes", f"at most {MAX_FILE_BYTES} are taken"
    if problem is None:
        return None
    return MissionError(f"{path} cannot be uploaded: {problem}", hint=advice)
