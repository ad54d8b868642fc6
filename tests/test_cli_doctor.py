"""`companion doctor`: what is there, what is in the way and what to do about it."""

from __future__ import annotations

import os
import socket
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from commands import Companion
from ports import free_instance, own_ports

from companion.cli.shipped import names
from companion.vehicle.endpoints import OFFBOARD_PORT


@pytest.fixture
def instance() -> int:
    return free_instance()


def lines(out: str) -> dict[str, str]:
    """What is said of each topic, with its remedy."""
    found: dict[str, str] = {}
    topic = ""
    for line in out.splitlines():
        if line.startswith(("ok ", "no ")):
            topic = line[3:14].strip()
            found[topic] = line[:3] + line[14:]
        else:
            found[topic] += " -> " + line.strip()
    return found


def test_a_machine_where_nothing_is_in_the_way(
    companion: Companion, instance: int, tmp_path: Path
) -> None:
    ended = companion("doctor", "-i", str(instance), "--log-dir", tmp_path / "runs")
    said = lines(ended.out)
    assert ended.code == 0, ended.out
    assert said["program"].startswith("ok mav-companion ")
    assert "GB free" in said["runs"] and not (tmp_path / "runs").exists()
    assert said["missions"].startswith(f"ok {len(names())} by name")
    assert said["simulator"].startswith("ok JSBSim")
    assert said["planners"] == "ok built-in, fast-downward, pyperplan"
    assert said[f"port {OFFBOARD_PORT + instance}"].endswith("free")
    assert "was not asked for" in said["vehicle"]


def test_who_has_the_port_is_named(companion: Companion, instance: int, tmp_path: Path) -> None:
    port = OFFBOARD_PORT + instance
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as udp:
        udp.bind(("127.0.0.1", port))
        ended = companion("doctor", "-i", str(instance), "--log-dir", tmp_path)
    said = lines(ended.out)[f"port {port}"]
    assert ended.code == 1
    assert f"(process {os.getpid()})" in said
    assert said.startswith("no ") and "-> choose another --instance" in said


def test_run_folders_that_cannot_be_made(companion: Companion, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("in the way")
    ended = companion("doctor", "--log-dir", tmp_path / "file" / "runs")
    said = lines(ended.out)["runs"]
    assert ended.code == 1
    assert said.startswith("no ") and said.endswith("-> choose another by --log-dir")


def test_a_serial_port_that_is_not_there(companion: Companion, tmp_path: Path) -> None:
    ended = companion("doctor", "--connect", "serial:///dev/ttyNONE:57600", "--log-dir", tmp_path)
    said = lines(ended.out)["vehicle"]
    assert ended.code == 1
    assert said.startswith("no there is no /dev/ttyNONE -> serial ports here: ")


@pytest.fixture
def simulator(instance: int) -> Iterator[None]:
    command = [sys.executable, "-m", "sitl", *own_ports(instance)]
    with subprocess.Popen(command, stdout=subprocess.DEVNULL) as child:
        yield
        child.terminate()


@pytest.mark.sockets
def test_a_vehicle_is_listened_for(
    companion: Companion, instance: int, simulator: None, tmp_path: Path
) -> None:
    url = f"udpin://127.0.0.1:{OFFBOARD_PORT + instance}"
    vehicle = ""
    for _ in range(20):  # a busy machine needs some time to start the simulator
        ended = companion("doctor", "--connect", url, "-i", str(instance), "--log-dir", tmp_path)
        vehicle = lines(ended.out)["vehicle"]
        if "PX4" in vehicle:
            break
    expected = f"ok {url}: system {1 + instance}, PX4, AUTO.LOITER, disarmed"
    assert vehicle == expected


@pytest.mark.sockets
def test_nobody_there(companion: Companion, instance: int, tmp_path: Path) -> None:
    url = f"udpin://127.0.0.1:{OFFBOARD_PORT + instance}"
    ended = companion("doctor", "--connect", url, "-i", str(instance), "--log-dir", tmp_path)
    said = lines(ended.out)["vehicle"]
    assert ended.code == 1
    assert "nothing arrived in 3 s" in said and "docs/real-vehicle.md" in said
