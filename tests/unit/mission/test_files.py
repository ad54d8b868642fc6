"""Which files a mission needs, and that none of them may lie elsewhere."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from companion.errors import MissionError
from companion.mission.files import files_of

MISSIONS = Path(__file__).parents[3] / "missions"


@pytest.mark.parametrize(
    ("mission", "others"),
    [
        ("surveillance", ["maps/hall.pgm", "maps/hall.yaml", "vehicles/quad_35cm.yaml"]),
        (
            "delivery",
            [
                "maps/hall.pgm",
                "maps/hall.yaml",
                "vehicles/quad_35cm.yaml",
                "delivery.domain.pddl",
                "delivery.problem.pddl",
            ],
        ),
    ],
)
def test_the_files_of_the_shipped_missions(mission: str, others: list[str]) -> None:
    path = MISSIONS / f"{mission}.yaml"
    named = files_of(path, MISSIONS)
    assert [str(p.relative_to(MISSIONS)) for p in named] == [*others, path.name]
    assert all(p.is_file() for p in named)


@pytest.mark.parametrize("path", ["../maps/hall.yaml", "/etc/hosts", "link/hall.yaml"])
def test_a_file_elsewhere_is_refused_where_it_is_named(tmp_path: Path, path: str) -> None:
    folder = tmp_path / "missions"
    folder.mkdir()
    shutil.copytree(MISSIONS / "maps", tmp_path / "maps")
    (folder / "link").symlink_to(tmp_path / "maps")
    text = (MISSIONS / "surveillance.yaml").read_text()
    mission = folder / "m.yaml"
    mission.write_text(text.replace("maps/hall.yaml", path))
    with pytest.raises(MissionError, match=r"m\.yaml:11:6: .* lies outside") as refused:
        files_of(mission, folder)
    assert refused.value.where is not None
