"""What the one end refuses by its name is what the other end would, and it says what to do."""

from __future__ import annotations

import tempfile
from pathlib import Path, PurePosixPath

import pytest
from commands import Companion
from drawn import drawn
from hypothesis import example, given
from hypothesis import strategies as st

from companion.cli.upload_files import remote_paths
from companion.errors import MissionError
from companion.ground.ftp_sessions import MAX_FILE_BYTES
from companion.ground.mission_store import MissionStore, names_of
from companion.ground.upload_names import problem_of
from companion.mavlink.ftp_frames import FtpRefusal
from companion.mission.files import files_of

MISSIONS = Path(__file__).parents[3] / "missions"
NAMES = st.text(st.sampled_from("aZ09_-. äß\n\\é"), min_size=1, max_size=8).filter(
    lambda name: name not in (".", "..")
)
ENDINGS = st.sampled_from(["", ".yaml", ".yml", ".YAML", ".txt", ".pgm", ".png", ".pddl"])


def is_taken(path: PurePosixPath) -> bool:
    """Whether a companion takes a file by this name."""
    with tempfile.TemporaryDirectory() as folder:
        store = MissionStore(Path(folder))
        try:
            for depth in range(1, len(names_of(str(path)))):
                store.make_folder("/".join(path.parts[:depth]))
            store.write(str(path), b"")
        except FtpRefusal:
            return False
    return True


@drawn(60)
@given(st.lists(NAMES, max_size=4), NAMES, ENDINGS)
@example(["maps"], "hall", ".yaml")
@example(["a", "b", "c", "d"], "hall", ".yaml")
@example([], "x" * 60, ".yaml")
@example([], "x" * 59, ".yaml")
def test_both_ends_take_the_same_names(folders: list[str], name: str, ending: str) -> None:
    path = PurePosixPath(*folders, name + ending)
    assert (problem_of(str(path)) is None) == is_taken(path)


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("my mission.yaml", "its name has ' '"),
        ("weingärten.yaml", "its name has 'ä'"),
        ("Vine.YAML", "its name ends in '.YAML'"),
        ("vine.txt", "its name ends in '.txt'"),
        ("vine", "its name has no ending"),
        ("_vine.yaml", "its name begins with '_'"),
        ("v" * 61 + ".yaml", "its name has 66 characters"),
        ("vine.png", "its name ends in '.png'"),
    ],
)
def test_a_mission_of_another_name_is_refused_before_a_link_is_opened(
    name: str, said: str, tmp_path: Path, companion: Companion
) -> None:
    (tmp_path / name).write_text((MISSIONS / "open_field.yaml").read_text(encoding="utf-8"))
    ended = companion("upload", tmp_path / name, "--connect", "udpin://127.0.0.1:1")
    assert (ended.code, ended.out) == (2, "")
    assert ended.err.startswith(f"{name} cannot be uploaded: {said}\n    rename it: ")
    assert "A-Z, a-z, 0-9" in ended.err and ".yaml or .yml" in ended.err


def test_all_files_are_told_at_once_and_maps_are_named_in_missions(tmp_path: Path) -> None:
    files = [tmp_path / "my maps" / "hall.pgm", tmp_path / "hall.pgm", tmp_path / "my hall.yaml"]
    files[0].parent.mkdir()
    for file, size in zip(files, (1, MAX_FILE_BYTES + 1, 1), strict=True):
        file.write_bytes(b" " * size)
    with pytest.raises(MissionError) as error:
        remote_paths(files, tmp_path)
    lines = str(error.value).splitlines()
    assert [line for line in lines if not line.startswith(" ")] == [
        "my maps/hall.pgm cannot be uploaded: its folder 'my maps' has ' '",
        f"hall.pgm cannot be uploaded: it has {MAX_FILE_BYTES + 1} bytes",
        "my hall.yaml cannot be uploaded: its name has ' '",
    ]
    assert "also where the mission names it" in lines[1]


@pytest.mark.parametrize("name", sorted(path.name for path in MISSIONS.glob("*.yaml")))
def test_the_shipped_missions_can_be_uploaded(name: str) -> None:
    if not name.endswith(".sim.yaml"):
        assert remote_paths(files_of(MISSIONS / name, MISSIONS), MISSIONS)
