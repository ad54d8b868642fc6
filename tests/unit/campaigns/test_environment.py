"""What a campaign's rows depend on besides the mission: also the packages whose skills it calls."""

from __future__ import annotations

from pathlib import Path

import pytest
from offered import offer
from synthetic import mission

from companion import load_mission
from companion.campaigns.environment import environment, environment_of

CODE = """
from companion.skills import skill

@skill
def weigh(run):
    return {answer}
"""
CALLING = """
version: 1
name: weighing
limits: {speed_mps: 3, up_m: [1, 8], fence: [[-9, -9], [9, -9], [9, 9], [-9, 9]]}
places: {Home: {east_m: 0, north_m: 0, up_m: 3}}
skills: {weigh: {effect: weighed, execute: python(weigh)}}
initially: [at(Home)]
task: {weigh: F weighed}
"""


def test_a_mission_that_calls_nothing_depends_on_no_package() -> None:
    assert environment_of(mission("F at(A)")) == environment()


@pytest.mark.parametrize("is_package", [False, True])
def test_other_code_of_a_package_is_another_line(
    is_package: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    offer(tmp_path, "scale", CODE.format(answer=1), "weigh")
    code = tmp_path / "scale.py"
    if is_package:
        (tmp_path / "scale").mkdir()
        code = code.rename(tmp_path / "scale" / "__init__.py")
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    calling = load_mission(CALLING)

    def line() -> str:
        ours = {k: v for k, v in environment_of(calling).items() if k not in environment()}
        assert list(ours) == ["package scale"]
        return ours["package scale"]

    before = line()
    assert before.startswith("scale 1.0 ") and line() == before
    code.write_text(CODE.format(answer=2), encoding="utf-8")
    assert line() != before
