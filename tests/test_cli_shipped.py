"""A MISSION argument: a path, or the name of a mission that is shipped."""

from __future__ import annotations

from importlib import metadata
from pathlib import Path

import pytest

import companion
from companion.cli import shipped
from companion.cli.shipped import completions, mission_file, names
from companion.errors import MissionError


def test_names_are_those_of_the_missions_without_their_scenarios() -> None:
    assert "surveillance" in names()
    assert not any(name.endswith(".sim") for name in names())


def test_a_name_means_the_shipped_file(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.chdir(tmp_path)
    assert mission_file("night_watch").name == "night_watch.yaml"
    assert mission_file("night_watch").is_file()


def test_a_file_that_is_there_comes_before_a_name(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "surveillance").write_text("version: 1\n")
    assert mission_file("surveillance") == Path("surveillance")


def test_what_is_neither_is_refused_with_the_names_there_are() -> None:
    with pytest.raises(MissionError) as error:
        mission_file("nowhere/survaillance.yaml")
    assert "there is no file nowhere/survaillance.yaml" in str(error.value)
    assert "did you mean surveillance?" in str(error.value)
    assert ", ".join(names()) in str(error.value)


@pytest.mark.parametrize("ending", ["yaml", "yml"])
def test_a_file_whose_ending_is_left_out_is_asked_for(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, ending: str
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / f"t4.{ending}").write_text("")
    (tmp_path / f"t4.sim.{ending}").write_text("")
    with pytest.raises(MissionError, match=rf"did you mean t4\.{ending}\?"):
        mission_file("t4")


def test_a_program_without_its_missions_leaves_the_path_to_the_reader(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(companion, "__file__", str(tmp_path / "companion" / "__init__.py"))
    monkeypatch.setattr(metadata, "files", lambda name: None)
    assert shipped.folder() is None
    assert mission_file("surveillance") == Path("surveillance")


def test_a_shell_is_told_names_files_and_folders(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "survey").mkdir()
    (tmp_path / "survey" / "field.yaml").write_text("")
    (tmp_path / "survey.png").write_text("")
    assert completions("surv") == ["surveillance", "survey/"]
    assert completions("survey/") == ["survey/field.yaml"]
    assert completions("survey/f") == ["survey/field.yaml"]
    assert set(names()) < set(completions(""))
