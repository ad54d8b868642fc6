"""What was read of PDDL files is kept as it is, and read back without their parser."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest

from companion.errors import MissionError
from companion.mission.kept_domain import KEPT, kept_domain, read_and_keep
from companion.mission.loader import load_mission

MISSIONS = Path(__file__).parents[3] / "missions"


@pytest.fixture
def delivery(tmp_path: Path) -> Path:
    shutil.copytree(MISSIONS, tmp_path / "m", ignore=shutil.ignore_patterns("*.png"))
    return tmp_path / "m" / "delivery.yaml"


def test_the_same_mission_comes_back(delivery: Path) -> None:
    read = load_mission(delivery)
    for domain_of in (read_and_keep, kept_domain):
        assert replace(load_mission(delivery, domain_of=domain_of), grid=read.grid) == read


@pytest.mark.long
def test_it_is_read_without_the_parser(delivery: Path) -> None:
    load_mission(delivery, domain_of=read_and_keep)
    program = (
        "import sys\n"
        "from pathlib import Path\n"
        "from companion.mission.kept_domain import kept_domain\n"
        "from companion.mission.loader import load_mission\n"
        f"load_mission(Path({str(delivery)!r}), domain_of=kept_domain)\n"
        "sys.exit('unified_planning' in sys.modules)"
    )
    assert subprocess.run([sys.executable, "-c", program], check=False).returncode == 0


def test_of_a_mission_without_pddl_nothing_is_kept(delivery: Path) -> None:
    path = delivery.with_name("surveillance.yaml")
    load_mission(path, domain_of=read_and_keep)
    assert not (path.parent / KEPT).exists()
    assert load_mission(path, domain_of=kept_domain).name == "surveillance"


@pytest.mark.parametrize(
    "kept",
    [
        None,
        "",
        "{}",
        "[]",
        "null",
        '{"mission": {}, "predicates": {}}',
        '{"mission": 7, "predicates": 7}',
        "{",
        "[" * 5000,
        "\xff",
    ],
)
def test_what_is_damaged_is_refused_at_the_key(delivery: Path, kept: str | None) -> None:
    if kept is not None:
        (delivery.parent / KEPT).write_text(kept, encoding="latin-1")
    with pytest.raises(MissionError, match=r"delivery.yaml:\d+:\d+: what was read of delivery.dom"):
        load_mission(delivery, domain_of=kept_domain)


@pytest.mark.parametrize(
    "predicates",
    [
        7,
        pytest.param({"in": 7}, marks=pytest.mark.long),
        {"in": [7]},
        pytest.param({"in": None}, marks=pytest.mark.long),
        pytest.param([], marks=pytest.mark.long),
    ],
)
def test_so_are_predicates_of_another_form(delivery: Path, predicates: object) -> None:
    load_mission(delivery, domain_of=read_and_keep)
    kept = json.loads((delivery.parent / KEPT).read_text("utf-8"))
    (delivery.parent / KEPT).write_text(json.dumps(kept | {"predicates": predicates}), "utf-8")
    with pytest.raises(MissionError, match="missing or damaged"):
        load_mission(delivery, domain_of=kept_domain)


def test_what_cannot_be_kept_is_refused(delivery: Path) -> None:
    (delivery.parent / KEPT).mkdir()
    with pytest.raises(MissionError, match=r"delivery.yaml:\d+:\d+: what delivery.domain.pddl"):
        load_mission(delivery, domain_of=read_and_keep)
