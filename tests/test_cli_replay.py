"""`companion replay` and the page's server, as processes: what they answer, and how they end."""

from __future__ import annotations

import io
import json
import os
import re
import shutil
import signal
import socket
import subprocess
import sys
import time
import urllib.request
from collections.abc import Iterator
from pathlib import Path
from urllib.error import HTTPError

import pytest
from commands import UNDRAWN, Companion
from mcap.reader import make_reader

DOCUMENTED = "companion replay runs/2026-11-21T101500-surveillance"
"""The command in docs/watching.md."""
AS_A_FILE = "companion replay runs/2026-11-21T101500-surveillance --mcap surveillance.mcap"
"""The one in docs/run-folder.md."""
ROOT = Path(__file__).parents[1]
HOP = ROOT / "tests" / "data" / "hop.yaml"
START_S = 300.0  # wall time that no answer needs


@pytest.fixture
def replaying(surveillance_run: Path) -> Iterator[tuple[subprocess.Popen[str], str]]:
    """A replay that runs, and its address."""
    command = [sys.executable, "-m", "companion", *DOCUMENTED.split()[1:-1], str(surveillance_run)]
    with subprocess.Popen([*command, "--port", "0"], stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        address = re.search(r"http://127\.0\.0\.1:\d+", process.stdout.readline())
        assert address
        yield process, address[0]
        process.kill()


def test_page_files_and_stream(
    replaying: tuple[subprocess.Popen[str], str], surveillance_run: Path
) -> None:
    process, address = replaying
    with urllib.request.urlopen(address, timeout=START_S) as page:
        text = page.read().decode()
        policy = page.headers["Content-Security-Policy"]
        assert page.headers["Content-Type"].startswith("text/html")
    assert policy.startswith("default-src 'none'") and "http" not in policy
    files = re.findall(r'(?:src|href)="([^"]+)"', text)
    assert {"main.js", "palette.css", "style.css", "icon.svg"} == set(files)
    for name in files:
        with urllib.request.urlopen(f"{address}/{name}", timeout=START_S) as file:
            assert file.status == 200 and file.headers["Content-Security-Policy"] == policy
    for name in ("nothing.js", "..%2fserver.py", "%2e%2e/server.py", "static/main.js"):
        with pytest.raises(HTTPError) as refused:
            urllib.request.urlopen(f"{address}/{name}", timeout=START_S)
        assert refused.value.code == 404
    with pytest.raises(HTTPError) as refused:
        urllib.request.urlopen(f"{address}/stream", data=b"write", timeout=START_S)
    assert refused.value.code == 405
    with urllib.request.urlopen(f"{address}/stream", timeout=START_S) as stream:
        assert stream.headers["Content-Type"].startswith("text/event-stream")
        seen: list[str] = []
        while "end" not in seen:
            line = stream.readline().decode()
            if line.startswith("data: ["):
                seen += [event.get("kind", "") for event in json.loads(line[6:])]
    assert {"plan", "replan", "tree", "status", "path", "states"} <= set(seen)
    process.send_signal(signal.SIGINT)
    assert process.wait(START_S) == 0


@pytest.mark.long
def test_a_port_in_use_is_passed_over(surveillance_run: Path) -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        arguments = ["replay", str(surveillance_run), "--port", str(port)]
        command = [sys.executable, "-m", "companion", *arguments]
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
            assert process.stdout is not None
            said = process.stdout.readline()
            process.kill()
    found = re.search(r"http://127\.0\.0\.1:(\d+)", said)
    assert found and port < int(found[1]) < port + 50


# -- folders that cannot be shown ----------------------------------------------------------------


def test_what_is_no_run_folder_is_refused(companion: Companion, tmp_path: Path) -> None:
    ended = companion("replay", tmp_path)
    assert ended.code == 2
    assert f"{tmp_path} is not a run folder" in ended.err


def test_a_run_without_a_scene_is_refused(
    companion: Companion, surveillance_run: Path, tmp_path: Path
) -> None:
    shutil.copy(surveillance_run / "events.jsonl", tmp_path)
    ended = companion("replay", tmp_path, "--port", 0)
    assert ended.code == 2
    assert "scene.json is missing, and nothing shows the run without it" in ended.err


def test_a_damaged_line_is_refused_with_its_place(
    companion: Companion, surveillance_run: Path, tmp_path: Path
) -> None:
    lines = (surveillance_run / "events.jsonl").read_text(encoding="utf-8").splitlines()
    (tmp_path / "events.jsonl").write_text("\n".join([*lines[:3], "{", *lines[3:]]) + "\n")
    ended = companion("replay", tmp_path)
    assert ended.code == 2
    assert "events.jsonl:4:1: this line is not JSON" in ended.err


# -- beside a flight -------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("address", ["8080", "localhost", ":80", "h:99999", "on"])
def test_an_address_that_is_none_is_refused(companion: Companion, address: str) -> None:
    mission = ROOT / "missions" / "surveillance.yaml"
    ended = companion("sim", mission, "--speed", "max", "--monitor", address)
    assert ended.code == 2
    assert "neither HOST:PORT nor off" in ended.err


@pytest.mark.flight
def test_a_page_that_cannot_be_served_keeps_nobody_from_flying(
    companion: Companion, tmp_path: Path
) -> None:
    """192.0.2.1 is nobody's (RFC 5737)."""
    ended = companion("sim", HOP, "--speed", "max", "--monitor", "192.0.2.1:8080")
    assert ended.code == 0
    assert "the monitor cannot listen on 192.0.2.1:8080" in ended.err
    assert "world      an open field, without wind (there is no hop.sim.yaml" in ended.out
    assert "task satisfied, landed" in ended.out


@pytest.mark.long
@pytest.mark.flight
def test_a_server_that_cannot_start_keeps_nobody_from_flying(tmp_path: Path) -> None:
    """As if uvicorn were not installed."""
    (tmp_path / "uvicorn.py").write_text("raise ImportError('no uvicorn here')\n")
    arguments = ["sim", str(HOP), "--speed", "max", "--monitor", "127.0.0.1:0"]
    flight = subprocess.run(
        [*UNDRAWN, *arguments, "--log-dir", str(tmp_path / "runs")],
        env={**os.environ, "PYTHONPATH": f"{tmp_path}:{os.environ.get('PYTHONPATH', '')}"},
        capture_output=True,
        text=True,
        timeout=START_S,
        check=False,
    )
    assert flight.returncode == 0, flight.stderr
    assert "the flight goes on: no uvicorn here" in flight.stderr
    assert "task satisfied, landed" in flight.stdout


def test_the_page_shows_one_run_after_the_other_and_ends_with_its_flight(
    surveillance_run: Path, tmp_path: Path
) -> None:
    """A flight that is killed closes the pipe, and that is enough."""
    other = shutil.copytree(surveillance_run, tmp_path / "other")
    flight = f"""
import sys
from pathlib import Path
from companion.monitor.child import Child, listen, url
listener = listen("127.0.0.1", 0)
print(url(listener), flush=True)
child = Child(listener)
child.show(Path({str(surveillance_run)!r}))
sys.stdin.readline()
child.show(Path({str(other)!r}))
sys.stdin.readline()
"""
    command = [sys.executable, "-c", flight]
    with subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as process:
        assert process.stdin is not None and process.stdout is not None
        address = process.stdout.readline().strip()
        with urllib.request.urlopen(f"{address}/stream", timeout=START_S) as stream:
            for name in (b'"run":"run"', b'"run":"other"'):
                while name not in stream.readline():
                    pass
                print(file=process.stdin, flush=True)
            process.kill()
            stream.read()  # to its end
    host, port = address.removeprefix("http://").split(":")
    deadline_s = time.monotonic() + START_S
    while time.monotonic() < deadline_s:
        with socket.socket() as probe:
            if probe.connect_ex((host, int(port))) != 0:
                return
        time.sleep(0.05)
    raise AssertionError("the page is still served")


# -- as a file -------------------------------------------------------------------------------------


def test_a_run_becomes_a_file_for_foxglove(
    companion: Companion, surveillance_run: Path, tmp_path: Path
) -> None:
    _, command, _, option, name = AS_A_FILE.split()
    file = tmp_path / name
    ended = companion(command, surveillance_run, option, file)
    assert ended.code == 0, ended.err
    assert re.search(rf"written    {file}: \d+ messages, 0\.\d MB", ended.out)
    reader = make_reader(io.BytesIO(file.read_bytes()))
    assert {a.name for a in reader.iter_attachments()} == {
        "mission.yaml",
        "scene.json",
        "events.jsonl",
        "clocks.json",
    }
    (geojson,) = (json.loads(m.data) for _, _, m in reader.iter_messages(["/map"]))
    kinds = {f["properties"]["kind"] for f in json.loads(geojson["geojson"])["features"]}
    assert {"home", "place", "fence", "flown"} <= kinds


def test_a_file_that_is_there_is_kept(
    companion: Companion, surveillance_run: Path, tmp_path: Path
) -> None:
    file = tmp_path / "run.mcap"
    file.write_text("of somebody")
    ended = companion("replay", surveillance_run, "--mcap", file)
    assert ended.code == 2
    assert f"{file} is there already" in ended.err and "choose another" in ended.err
    assert file.read_text() == "of somebody"


@pytest.mark.parametrize("place", ["nothing/run.mcap", "."])
def test_a_file_that_cannot_be_written_is_told(
    companion: Companion, surveillance_run: Path, tmp_path: Path, place: str
) -> None:
    ended = companion("replay", surveillance_run, "--mcap", tmp_path / place)
    assert ended.code in (1, 2)
    assert str(tmp_path) in ended.err and "Traceback" not in ended.err


def test_what_cannot_be_shown_leaves_no_file(
    companion: Companion, surveillance_run: Path, tmp_path: Path
) -> None:
    file = tmp_path / "run.mcap"
    ended = companion("replay", tmp_path, "--mcap", file)
    assert ended.code == 2 and f"{tmp_path} is not a run folder" in ended.err
    shutil.copy(surveillance_run / "events.jsonl", tmp_path)
    ended = companion("replay", tmp_path, "--mcap", file)
    assert ended.code == 2 and "scene.json is missing" in ended.err
    assert not file.exists()


@pytest.mark.long
def test_a_run_that_was_cut_off_is_written_as_far_as_it_goes(
    companion: Companion, surveillance_run: Path, tmp_path: Path
) -> None:
    run = shutil.copytree(surveillance_run, tmp_path / "run")
    for name in ("events.jsonl", "flight.tlog"):
        data = (run / name).read_bytes()
        (run / name).write_bytes(data[: len(data) // 2])
    ended = companion("replay", run, "--mcap", tmp_path / "half.mcap")
    assert ended.code == 0, ended.err
    assert "notice     the run has no end: it was cut off, or is still going on" in ended.out
