"""Real clients against the server on a real simulator's link: MAVSDK, pymavlink, MAVProxy, ours.

The simulator forwards between its two links, as PX4 does. Timers of the clients run in wall time.
"""

from __future__ import annotations

import asyncio
import os
import re
import shlex
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

os.environ.setdefault("MAVLINK20", "1")

import pytest
from ports import free_instance, own_ports
from pymavlink import mavutil
from pymavlink.mavftp import MAVFTP
from test_ground_station import START, Station
from test_mavproxy import MAVProxy
from test_mavsdk_client import mavsdk, within
from test_sockets import Run, run
from upload_host import UploadHost

from companion.mavlink.ftp_frames import crc32

pytestmark = pytest.mark.sockets
__all__ = ["run"]

MISSION = Path(__file__).parents[2] / "missions" / "surveillance.yaml"
UPLOAD = "companion upload missions/surveillance.yaml --connect udpin://0.0.0.0:14550 --start"
WATCH = "companion watch --connect udpin://0.0.0.0:14550"
CONTENT = bytes(range(256)) * 256  # 64 KiB
START_S, ANSWER_S = 300.0, 600.0  # wall time that no start and no answer needs


@pytest.fixture
def instance() -> Iterator[int]:
    """Of a running simulator."""
    number = free_instance()
    command = [sys.executable, "-m", "sitl", *own_ports(number)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as child:
        assert child.stdout is not None
        assert str(14550 + number) in child.stdout.readline() + child.stdout.readline()
        try:
            yield number
        finally:
            child.send_signal(signal.SIGINT)
            assert child.wait(timeout=START_S) == 0


class Pymavlink:
    """pymavlink's own client."""

    def __init__(self, instance: int) -> None:
        self.link = mavutil.mavlink_connection(
            f"udpin:127.0.0.1:{14550 + instance}", source_system=255, source_component=190
        )
        end_s, heard = time.monotonic() + START_S, set[int]()
        while 191 not in heard:
            assert time.monotonic() < end_s, f"heard {heard}, no companion"
            beat = self.link.recv_match(type="HEARTBEAT", blocking=True, timeout=1.0)
            self.link.mav.heartbeat_send(6, 8, 0, 0, 4)
            heard |= {beat.get_srcComponent()} if beat else set()
        self.ftp = MAVFTP(self.link, 1 + instance, 191)
        self.ftp.ftp_settings.write_size = 239
        self.ftp.ftp_settings.burst_read_size = 239

    def put(self, local: Path, remote: str) -> int:
        self.ftp.cmd_put([str(local), remote])
        return int(self.ftp.process_ftp_reply("CreateFile", timeout=15).error_code)


def test_pymavlink_s_client_is_content(instance: int, tmp_path: Path) -> None:
    local, back = tmp_path / "a.pgm", tmp_path / "b.pgm"
    content = CONTENT[: 16 * 1024]  # its client is slow
    local.write_bytes(content)
    with UploadHost(14540 + instance, tmp_path / "root"):
        client = Pymavlink(instance)
        ftp = client.ftp
        assert ftp.cmd_mkdir(["/maps"]).error_code == 0
        assert client.put(local, "/maps/a.pgm") == 0
        listed = ftp.cmd_list(["/maps"]).directory_listing
        assert [(e.name, e.size_b) for e in listed] == [("a.pgm", len(content))]
        ftp.cmd_get(["/maps/a.pgm", str(back)])
        assert ftp.process_ftp_reply("OpenFileRO", timeout=ANSWER_S).error_code == 0
        assert back.read_bytes() == content
        assert ftp.cmd_crc(["/maps/a.pgm"]).error_code == 0
        assert ftp.cmd_rename(["/maps/a.pgm", "/maps/c.pgm"]).error_code == 0
        assert ftp.cmd_rmdir(["/maps"]).error_code != 0  # not empty
        assert ftp.cmd_rm(["/maps/c.pgm"]).error_code == 0
        assert ftp.cmd_rmdir(["/maps"]).error_code == 0
        client.link.close()


def test_64_kib_arrive_whole_at_30_percent_loss_each_way(instance: int, tmp_path: Path) -> None:
    """Lost requests and lost replies. pymavlink sends CreateFile and the end only once, so a person
    has to look at the file and try again."""
    local, arrived = tmp_path / "a.pgm", tmp_path / "root" / "incoming" / "a.pgm"
    local.write_bytes(CONTENT)
    with UploadHost(14540 + instance, tmp_path / "root", loss=0.3):
        client = Pymavlink(instance)
        start_s = time.monotonic()
        while not arrived.exists() or arrived.read_bytes() != CONTENT:
            assert time.monotonic() - start_s < ANSWER_S
            client.put(local, "/a.pgm")
            client.ftp.cmd_cancel()  # what it has not ended by itself
        client.link.close()


async def transfer(port: int, local: Path, back: Path) -> None:
    from mavsdk.asyncio.plugins.ftp import FtpAsync
    from mavsdk.plugins.ftp import FtpError, FtpResult

    kind = mavsdk.ComponentType.GROUND_STATION
    async with mavsdk.Mavsdk(mavsdk.Configuration.create_with_component_type(kind)) as client:
        await client.add_any_connection(f"udpin://127.0.0.1:{port}")
        system = await client.first_autopilot(timeout_s=START_S)
        ftp = FtpAsync(system)
        await ftp.set_target_compid(191)
        await within(ftp.create_directory("/maps"))
        with pytest.raises(FtpError) as refused:
            await within(ftp.create_directory("/maps"))
        assert refused.value.result == FtpResult.FILE_EXISTS
        async for result, _ in ftp.upload(str(local), "/maps"):
            assert result in (FtpResult.NEXT, FtpResult.SUCCESS)
        listed = await within(ftp.list_directory("/maps"))
        assert [(f.name, f.size_bytes) for f in listed.entries] == [(local.name, len(CONTENT))]
        assert await within(ftp.are_files_identical(str(local), f"/maps/{local.name}"))
        for uses_burst in (False, True):
            async for _ in ftp.download(f"/maps/{local.name}", str(back), uses_burst):
                pass
            assert (back / local.name).read_bytes() == CONTENT
            (back / local.name).unlink()
        await within(ftp.rename(f"/maps/{local.name}", "/b.pgm"))
        for outside in ("/../root_x/a.pgm", "/../../etc/hosts"):
            with pytest.raises(FtpError):
                async for _ in ftp.download(outside, str(back), False):
                    pass
        await within(ftp.remove_file("/b.pgm"))
        await within(ftp.remove_directory("/maps"))
        assert (await within(ftp.list_directory("/"))).entries == []


def test_mavsdk_s_client_is_content(instance: int, tmp_path: Path) -> None:
    local, back = tmp_path / "a.pgm", tmp_path / "back"
    local.write_bytes(CONTENT)
    back.mkdir()
    with UploadHost(14540 + instance, tmp_path / "root"):
        asyncio.run(asyncio.wait_for(transfer(14550 + instance, local, back), ANSWER_S))


def test_mavproxy_puts_gets_and_lists(instance: int, tmp_path: Path) -> None:
    with UploadHost(14540 + instance, tmp_path / "root") as host:
        proxy = MAVProxy(14550 + instance, 1 + instance, tmp_path)
        try:
            proxy.expect("Detected vehicle", rf"{1 + instance}:191", r"Received \d+ parameters")
            proxy.type("set target_component 191")
            proxy.type("ftp mkdir maps")
            for name in ("maps/hall.pgm", "maps/hall.yaml", "surveillance.yaml"):
                proxy.type(f"ftp put {MISSION.parent / name} {name}", "Sent file of length")
            proxy.expect("surveillance.yaml accepted", limit_s=ANSWER_S)
            proxy.type("ftp list /", "D maps", "surveillance.yaml", "verdict.json")
            proxy.type(f"ftp get verdict.json {tmp_path / 'v.json'}", "Wrote")
            proxy.type("ftp crc surveillance.yaml", f"{crc32(MISSION.read_bytes()):08x}")
        finally:
            proxy.close()
    (verdict,) = host.verdicts
    assert verdict.text.encode()[:20] in (tmp_path / "v.json").read_bytes()
    assert host.uploads.take_active() is not None


def test_the_upload_command_sends_what_is_missing_and_says_the_verdict(
    instance: int, tmp_path: Path, run: Run
) -> None:
    connect = ("--connect", f"udpin://127.0.0.1:{14550 + instance}")
    with UploadHost(14540 + instance, tmp_path / "root") as host:
        first = run(*shlex.split(UPLOAD.replace("14550", str(14550 + instance))))
        assert first.exit_code(ANSWER_S) == 0, first.printed
        for told in (
            "sent       /maps/hall.pgm, 38415 bytes",
            "sent       /surveillance.yaml",
            "verdict    surveillance.yaml accepted",
            "started",
        ):
            assert told in first.printed
        path = host.uploads.take_active()
        assert path is not None and path.read_bytes() == MISSION.read_bytes()
        broken = tmp_path / "surveillance.yaml"
        broken.write_text(MISSION.read_text().replace("F (at(A) |", "F (at(D) |"))
        shutil.copytree(MISSION.parent / "maps", tmp_path / "maps")
        second = run("companion", "upload", broken, *connect)
        assert second.exit_code(ANSWER_S) == 2, second.printed
        assert "there      /maps/hall.pgm" in second.printed
        assert "surveillance.yaml:73:" in second.printed
        assert host.uploads.take_active() is None


def test_watch_prints_what_is_said_and_ends_with_the_run(
    instance: int, tmp_path: Path, run: Run
) -> None:
    with UploadHost(14540 + instance, tmp_path / "root", exit_code=3) as host:
        watch = run(*shlex.split(WATCH.replace("14550", str(14550 + instance))))
        watch.until_printed("watching", START_S)
        host.start()
        assert watch.exit_code(ANSWER_S) == 3, watch.printed
        assert "  the run has started, and has ended at once, which is a long text" in watch.printed


def test_without_a_companion_there_is_no_upload(instance: int, run: Run) -> None:
    connect = ("--connect", f"udpin://127.0.0.1:{14550 + instance}", "--timeout", 5)
    alone = run("companion", "upload", MISSION, *connect)
    assert alone.exit_code(ANSWER_S) == 4
    assert "no companion (component 191)" in alone.printed


def like_the_papers(folder: Path, name: str, task: str) -> Path:
    """A mission with the paper's places and skills, and another task."""
    shutil.copytree(MISSION.parent / "maps", folder / "maps", dirs_exist_ok=True)
    head, _, rest = MISSION.read_text(encoding="utf-8").partition("\ntask:\n")
    head = head.replace("name: surveillance", f"name: {name}")
    tail = rest[rest.index("\n\n") :]
    path = folder / f"{name}.yaml"
    path.write_text(f"{head}\ntask:\n  go: {task}{tail}", encoding="utf-8")
    return path


def test_missions_are_uploaded_one_is_flown_and_watched_to_its_end(
    tmp_path: Path, run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COMPANION_LOG_DIR", str(tmp_path))
    number = free_instance()
    scenario = MISSION.with_suffix(".sim.yaml")
    simulator = run("sitl", *own_ports(number), "--scenario", scenario)
    simulator.until_printed(str(14550 + number), START_S)
    link = ("--connect", f"udpin://127.0.0.1:{14540 + number}", "--monitor", "off")
    on_board = run("companion", "run", *link)
    on_board.until_printed("hosting", START_S)
    ground = f"udpin://0.0.0.0:{14550 + number}"
    broken = like_the_papers(tmp_path, "broken", "F at(D)")
    upload = run("companion", "upload", broken, "--connect", ground)
    assert upload.exit_code(ANSWER_S) == 2, upload.printed
    assert re.search(r"broken\.yaml:\d+:\d+: unknown fact at\(D\)", upload.printed)
    hop = like_the_papers(tmp_path, "hop", "F at(A) & F at(r2) & F G at(Home)")
    command = UPLOAD.replace("14550", str(14550 + number))
    upload = run(*shlex.split(command.replace("missions/surveillance.yaml", str(hop))))
    assert upload.exit_code(ANSWER_S) == 0, upload.printed + on_board.printed
    on_board.until_printed("taking off", ANSWER_S)
    assert "\nhosting    hop is ready; MISSION_START flies it\n" in on_board.printed
    upload = run("companion", "upload", MISSION.with_name("lost_person.yaml"), "--connect", ground)
    assert upload.exit_code(ANSWER_S) == 0, upload.printed
    assert "becomes active after landing" in upload.printed
    assert "notice     not heard: EVENT[person]; --events says where" in upload.printed
    watch = run(*shlex.split(WATCH.replace("14550", str(14550 + number))))
    assert watch.exit_code(ANSWER_S) == 0, watch.printed + on_board.printed
    assert "task satisfied, landed" in watch.printed
    os.kill(on_board.pid, signal.SIGINT)
    assert on_board.exit_code(ANSWER_S) == 0
    (folder,) = tmp_path.glob("*-hop")
    assert (folder / "mission.yaml").read_bytes() == hop.read_bytes()
    assert "notice: not heard: EVENT[person]" in (folder / "events.jsonl").read_text("utf-8")


def test_a_mission_that_was_accepted_is_flown_although_the_companion_is_killed_before(
    tmp_path: Path, run: Run
) -> None:
    """It goes before the mission of the command, which a service on board gives at each start."""
    number = free_instance()
    simulator = run("sitl", *own_ports(number), "--scenario", MISSION.with_suffix(".sim.yaml"))
    simulator.until_printed(str(14550 + number), START_S)
    command = (
        *("companion", "run", MISSION, "--wait", "--monitor", "off", "--log-dir", tmp_path),
        *("--connect", f"udpin://127.0.0.1:{14540 + number}"),
    )
    on_board = run(*command)
    on_board.until_printed("hosting", START_S)
    hop = like_the_papers(tmp_path, "hop", "F at(A) & F G at(Home)")
    ground = f"udpin://0.0.0.0:{14550 + number}"
    upload = run("companion", "upload", hop, "--connect", ground)
    assert upload.exit_code(ANSWER_S) == 0, upload.printed
    os.kill(on_board.pid, signal.SIGKILL)
    assert on_board.exit_code(ANSWER_S) == -signal.SIGKILL
    station = Station(14550 + number, 1 + number)  # listens before the first word
    try:
        run(*command)
        station.until_told("hop.yaml accepted again after a restart", START_S + ANSWER_S)
        station.until_told("hop is ready; MISSION_START flies it", ANSWER_S)
        station.until_accepted(START)  # once it has heard all of the vehicle's state again
        station.until_told("taking off", ANSWER_S)
    finally:
        station.close()
    (folder,) = tmp_path.glob("*-hop")
    assert (folder / "mission.yaml").read_bytes() == hop.read_bytes()
    assert not list(tmp_path.glob("*-surveillance"))
