"""A mission arrives, is checked by a real child process, and becomes active or not."""

from __future__ import annotations

import io
import json
import time
from contextlib import chdir, redirect_stdout
from pathlib import Path

import pytest
from ftp_client import Client

from companion.cli.check_child import BoundedCheck
from companion.ground.checking import CheckResult, begin_check, result_of
from companion.ground.upload_states import UploadVerdict
from companion.ground.uploads import CHECK_S, Uploads
from companion.mavlink.ftp_frames import Opcode, crc32
from companion.mission.loader import load_mission
from companion.vehicle_profile import VehicleProfile

pytestmark = pytest.mark.slow

MISSIONS = Path(__file__).parents[3] / "missions"
MISSION = (MISSIONS / "surveillance.yaml").read_bytes()
LIMIT_S = 300.0


class Ground(Client):
    """A ground station of `Uploads`."""

    def __init__(self, uploads: Uploads) -> None:
        self.uploads = uploads
        super().__init__(_Door(uploads))  # type: ignore[arg-type]

    def upload_map(self) -> None:
        self.ask(Opcode.CREATE_DIRECTORY, "maps")
        for name in ("hall.pgm", "hall.yaml"):
            self.put(f"maps/{name}", (MISSIONS / "maps" / name).read_bytes())

    def verdict(self, is_flying: bool = False) -> UploadVerdict:
        end_s = time.monotonic() + LIMIT_S
        while not (verdicts := self.uploads.poll(self.now_s, is_flying)):
            assert time.monotonic() < end_s
            time.sleep(0.02)
        (verdict,) = verdicts
        assert json.loads(self.get("verdict.json"))["text"] == verdict.text
        return verdict


class _Door:
    def __init__(self, uploads: Uploads) -> None:
        self.receive = uploads.ftp


class Slow:
    """A check that ends only if it is killed; or as told."""

    def __init__(self, answer: CheckResult | None = None) -> None:
        self.folders: list[Path] = []
        self.answer = answer
        self.killed = 0

    def __call__(self, folder: Path, mission: str) -> Slow:
        self.folders.append(folder)
        return self

    def poll(self) -> CheckResult | None:
        return self.answer

    def kill(self) -> None:
        self.killed += 1
        self.answer = CheckResult(False, "the check needs too much time or memory")


def checked_here(folder: Path, mission: str) -> Slow:
    """The check of a child process in this one, which has loaded everything."""
    with chdir(folder), redirect_stdout(io.StringIO()):
        answer = BoundedCheck(Path(mission)).answer()
    return Slow(result_of(0, json.dumps(answer).encode()))


def test_a_good_mission_becomes_active_with_its_files(tmp_path: Path) -> None:
    uploads = Uploads(tmp_path)
    ground = Ground(uploads)
    ground.upload_map()
    assert uploads.poll(0.0) == []  # a map is no mission
    ground.put("surveillance.yaml", MISSION)
    assert uploads.take_active() is None
    verdict = ground.verdict()
    assert verdict.is_accepted
    assert verdict.text == "surveillance.yaml accepted"
    assert verdict.crc32 == crc32(MISSION)
    assert "move(Home, A)" in verdict.details
    path = uploads.take_active()
    assert path is not None
    assert load_mission(path).name == "surveillance"
    assert uploads.take_active() is None
    ground.put("maps/hall.pgm", b"broken")  # what flies is not touched
    assert load_mission(path).name == "surveillance"
    restarted = Ground(Uploads(tmp_path, checked_here))
    restarted.put("surveillance.yaml", b"version: 2\n")
    assert restarted.verdict().number == verdict.number + 1


@pytest.mark.long
def test_a_vehicle_profile_is_no_mission_and_goes_with_the_one_that_names_it(
    tmp_path: Path,
) -> None:
    uploads = Uploads(tmp_path, checked_here)
    ground = Ground(uploads)
    ground.upload_map()
    ground.ask(Opcode.CREATE_DIRECTORY, "vehicles")
    profile = (MISSIONS / "vehicles" / "quad_35cm.yaml").read_bytes()
    ground.put("vehicles/small.yaml", profile.replace(b"radius_m: 0.35", b"radius_m: 0.25"))
    assert uploads.poll(0.0) == []
    ground.put("surveillance.yaml", MISSION.replace(b"limits:", b"vehicle: small\nlimits:", 1))
    assert ground.verdict().is_accepted
    path = uploads.take_active()
    assert path is not None
    assert load_mission(path).vehicle == VehicleProfile("small", radius_m=0.25)
    ground.put("surveillance.yaml", MISSION.replace(b"limits:", b"vehicle: large\nlimits:", 1))
    assert "surveillance.yaml:13:10: there is no vehicle profile large" in ground.verdict().text


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        (b"F (at(A) |", b"F (at(D) |", "surveillance.yaml:"),
        *(
            pytest.param(*each, marks=pytest.mark.long)
            for each in (
                (
                    b"maps/hall.yaml",
                    b"../../../../etc/hosts",
                    "lies outside the mission's folder",
                ),
                (b"maps/hall.yaml", b"maps/none.yaml", "surveillance.yaml:11:6: "),
                (b"maps/hall.yaml", b"/etc/hosts", "lies outside the mission's folder"),
                (b"version: 1", b"versoin: 1", "surveillance.yaml:8:1: "),
            )
        ),
        (MISSION[-300:], b"", "a part may be missing"),
        (b"\n", b"\r", "not UTF-8 text whose lines end with LF"),
        (MISSION, MISSION.decode().encode("utf-16-le"), "not UTF-8 text whose lines end with LF"),
    ],
)
def test_a_mission_that_cannot_be_flown_changes_nothing(
    tmp_path: Path, old: bytes, new: bytes, told: str
) -> None:
    uploads = Uploads(tmp_path, checked_here)
    ground = Ground(uploads)
    ground.upload_map()
    ground.put("surveillance.yaml", MISSION.replace(old, new))
    verdict = ground.verdict()
    assert not verdict.is_accepted
    assert told in verdict.text
    assert verdict.text.startswith("refused surveillance.yaml:")
    assert uploads.take_active() is None
    assert list((tmp_path / "active").iterdir()) == []


def test_an_image_outside_is_not_opened(tmp_path: Path) -> None:
    ground = Ground(Uploads(tmp_path, checked_here))
    ground.upload_map()
    plan = (MISSIONS / "maps" / "hall.yaml").read_bytes()
    ground.put("maps/hall.yaml", plan.replace(b"hall.pgm", b"../../../x.pgm"))
    ground.put("surveillance.yaml", MISSION)
    assert "the image of maps/hall.yaml lies outside" in ground.verdict().details


def test_in_flight_it_waits_for_the_landing(tmp_path: Path) -> None:
    slow = Slow()
    uploads = Uploads(tmp_path, slow)
    ground = Ground(uploads)
    ground.put("a.yaml", MISSION)
    assert uploads.poll(0.0, is_flying=True) == []
    slow.answer = CheckResult(True, "a plan")
    assert ground.verdict(is_flying=True).text == "a.yaml accepted; becomes active after landing"
    ground.put("b.yaml", MISSION)
    assert ground.verdict(is_flying=True).mission == "b.yaml"
    path = uploads.take_active()  # the newest
    assert path is not None and path.name == "b.yaml"
    assert [folder.name for folder in (tmp_path / "active").iterdir()] == [path.parent.name]


def test_what_is_noticed_is_told_after_the_verdict(tmp_path: Path) -> None:
    uploads = Uploads(
        tmp_path, Slow(CheckResult(True, "a plan", ("low: nothing uses this event",)))
    )
    ground = Ground(uploads)
    ground.put("a.yaml", MISSION)
    told = [news.text for news in ground.verdict().news]
    assert told == ["a.yaml accepted", "notice: low: nothing uses this event"]
    assert json.loads(ground.get("verdict.json"))["notices"] == ["low: nothing uses this event"]


def accepted(root: Path, *names: str) -> Uploads:
    """Missions that were accepted one after the other, by a check that takes no time."""
    uploads = Uploads(root, Slow(CheckResult(True, "a plan")))
    ground = Ground(uploads)
    for name in names:
        ground.put(name, MISSION + f"# {name}\n".encode())
        assert ground.verdict().text == f"{name} accepted"
    return uploads


def test_what_was_accepted_and_not_flown_is_offered_again_after_a_restart(tmp_path: Path) -> None:
    """Whether it was taken or not; as often as it takes; with a real check of all files."""
    before = Uploads(tmp_path, checked_here)
    ground = Ground(before)
    ground.upload_map()
    ground.put("surveillance.yaml", MISSION)
    number = ground.verdict().number
    ground.put("maps/hall.pgm", b"of another mission")
    restarted = ground
    for times, begin in ((1, begin_check), (2, checked_here)):
        restarted = Ground(Uploads(tmp_path, begin))
        verdict = restarted.verdict()
        assert verdict.text == "surveillance.yaml accepted again after a restart"
        assert (verdict.number, verdict.crc32) == (number + times, crc32(MISSION))
        path = restarted.uploads.take_active()
        assert path is not None and load_mission(path).name == "surveillance"
    restarted.uploads.started()
    assert is_forgotten(tmp_path)


def is_forgotten(root: Path) -> bool:
    """Whether nothing is offered, and nothing is even checked, after a restart."""
    slow = Slow()
    uploads = Uploads(root, slow)
    return uploads.poll(0.0) == [] and uploads.take_active() is None and slow.folders == []


def test_the_one_that_was_accepted_last_is_offered_and_none_before_it(tmp_path: Path) -> None:
    uploads = accepted(tmp_path, "a.yaml", "b.yaml")
    path = uploads.take_active()
    assert path is not None and path.name == "b.yaml"
    again = Uploads(tmp_path, Slow(CheckResult(True, "a plan")))
    assert Ground(again).verdict().mission == "b.yaml"
    again.take_active()
    again.started()
    assert is_forgotten(tmp_path)


def test_one_that_came_in_flight_is_offered_although_another_was_flown(tmp_path: Path) -> None:
    slow = Slow(CheckResult(True, "a plan"))
    uploads = Uploads(tmp_path, slow)
    ground = Ground(uploads)
    ground.put("a.yaml", MISSION)
    ground.verdict()
    uploads.take_active()
    uploads.started()
    ground.put("b.yaml", MISSION)
    ground.verdict(is_flying=True)
    assert Ground(Uploads(tmp_path, Slow(slow.answer))).verdict().mission == "b.yaml"


def test_what_a_power_cut_has_broken_is_refused_and_an_upload_goes_on(tmp_path: Path) -> None:
    uploads = accepted(tmp_path, "a.yaml")
    path = uploads.take_active()
    assert path is not None
    path.write_bytes(b"")
    (tmp_path / "incoming" / "verdict.json").unlink()
    restarted = Ground(Uploads(tmp_path, Slow(CheckResult(True, "a plan"))))
    verdict = restarted.verdict()
    assert not verdict.is_accepted and verdict.number == 2
    restarted.put("a.yaml", MISSION)
    assert restarted.verdict().is_accepted
    assert restarted.uploads.take_active() is not None


def test_one_check_at_a_time_and_a_late_one_is_ended(tmp_path: Path) -> None:
    slow = Slow()
    uploads = Uploads(tmp_path, slow)
    ground = Ground(uploads)
    for name in ("a.yaml", "b.yaml", "b.yaml"):
        ground.put(name, MISSION)
        assert uploads.poll(0.0) == []
    assert len(slow.folders) == 1
    assert uploads.poll(CHECK_S) == []
    assert uploads.poll(CHECK_S + 0.1) == []
    assert slow.killed == 1
    verdict = ground.verdict()
    assert verdict.text == "refused a.yaml: the check needs too much time or memory"
    slow.answer = None
    uploads.poll(CHECK_S + 0.2)
    assert len(slow.folders) == 2


def test_a_check_that_was_ended_just_as_it_passed_is_accepted(tmp_path: Path) -> None:
    uploads = Uploads(tmp_path, slow := Slow())
    ground = Ground(uploads)
    ground.put("a.yaml", MISSION)
    for now_s in (0.0, CHECK_S + 0.1, CHECK_S + 0.2):
        assert uploads.poll(now_s) == []
        slow.answer = None  # it has not ended yet
    assert slow.killed == 1
    slow.answer = CheckResult(True, "a plan")
    assert ground.verdict().is_accepted
    assert uploads.take_active() is not None


def test_of_two_that_were_accepted_only_the_newest_is_started(tmp_path: Path) -> None:
    uploads = accepted(tmp_path, "a.yaml", "b.yaml")
    assert uploads.take_active() is not None
    assert uploads.take_active() is None
    uploads.started()
    uploads.started()  # the same mission is flown once more
    assert is_forgotten(tmp_path)


@pytest.mark.parametrize(
    "text",
    [
        b"a: &a [x, x, x]\nb: &b [*a, *a, *a, *a]\nc: [*b, *b, *b]\n",
        pytest.param(b"[" * 60_000 + b"\n", marks=pytest.mark.long),
        pytest.param(b"\xff\0" * 9000 + b"\n", marks=pytest.mark.long),
        pytest.param(b"task: " + b"(" * 30_000 + b"\n", marks=pytest.mark.long),
    ],
)
def test_a_bomb_harms_nobody(tmp_path: Path, text: bytes) -> None:
    ground = Ground(Uploads(tmp_path))
    ground.put("bomb.yaml", text)
    assert not ground.verdict().is_accepted
