"""`sitl` as people start it: options, environment, several at once, what it prints."""

import os
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from ports import free_instance

from companion.mavlink.framing import MavlinkCodec, dialect
from sitl.link.routing import LinkName
from sitl.link.server import HOST, PORTS

pytestmark = pytest.mark.sockets

START_S = 30.0
EVENTS = "version: 1\nhappens:\n  - {at_s: 0.5, wind: {east_mps: 2}}\n"
LOCAL, _ = PORTS[LinkName.OFFBOARD]


@contextmanager
def running(*arguments: object, **environment: str) -> Iterator[subprocess.Popen[str]]:
    """A simulator whose ports are open; the two lines that say so have been read."""
    process = subprocess.Popen(
        [sys.executable, "-m", "sitl", *map(str, arguments)],
        stdout=subprocess.PIPE,
        text=True,
        env={**os.environ, **environment},
    )
    with process:
        try:
            assert process.stdout is not None
            assert process.stdout.readline().startswith("sitl: vehicle ")
            assert "UDP" in process.stdout.readline()
            yield process
        finally:
            process.terminate()
    assert process.returncode == 0


def hear(instance: int, seconds: float) -> list[Any]:
    """What the offboard link of an instance sends to a client that speaks to it."""
    client, messages = MavlinkCodec(255, 190), []
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as udp:
        udp.settimeout(1.0)
        heartbeat = dialect.MAVLink_heartbeat_message(6, 8, 0, 0, 4, 3)
        udp.sendto(client.pack(heartbeat), (HOST, LOCAL + instance))
        end_s = time.monotonic() + seconds
        while time.monotonic() < end_s:
            messages += client.parse(udp.recv(2048))
    return messages


def last(messages: list[Any], name: str) -> Any:
    return [message for message in messages if message.get_type() == name][-1]


def check(path: Path) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "sitl", "--check", str(path)]
    return subprocess.run(command, capture_output=True, text=True, timeout=START_S, check=False)


def test_the_environment_of_px4_is_honoured() -> None:
    instance = free_instance()
    home = {"PX4_HOME_LAT": "48.5", "PX4_HOME_LON": "-11.25", "PX4_HOME_ALT": "250"}
    with running("-i", instance, PX4_SIM_SPEED_FACTOR="4", **home):
        heard = hear(instance, 3.0)
    place = last(heard, "GLOBAL_POSITION_INT")
    assert (place.lat, place.lon) == (pytest.approx(485000000, 10), pytest.approx(-112500000, 10))
    assert place.alt == pytest.approx(250_000, abs=500)
    stamps = [m.time_boot_ms for m in heard if m.get_type() == "ATTITUDE"]
    assert (stamps[-1] - stamps[0]) / 3000 == pytest.approx(4.0, rel=0.15)


def test_an_option_wins_over_the_environment() -> None:
    instance = free_instance()
    options = ("-i", instance, "--speed", 2, "--home", "10,20,30")
    with running(*options, PX4_SIM_SPEED_FACTOR="9", PX4_HOME_LAT="48.5"):
        heard = hear(instance, 2.0)
    place = last(heard, "GLOBAL_POSITION_INT")
    assert (place.lat, place.lon) == (pytest.approx(10**8, 10), pytest.approx(2 * 10**8, 10))
    stamps = [m.time_boot_ms for m in heard if m.get_type() == "ATTITUDE"]
    assert (stamps[-1] - stamps[0]) / 2000 == pytest.approx(2.0, rel=0.15)


def test_instances_side_by_side_are_vehicles_of_their_own() -> None:
    first = free_instance()
    with running("-i", first):
        second = free_instance()
        with running("-i", second, "--home", "10,20,30"):
            vehicles = {instance: hear(instance, 1.0) for instance in (first, second)}
    for instance, heard in vehicles.items():
        assert {message.get_srcSystem() for message in heard} == {1 + instance}
    latitudes = [last(heard, "GLOBAL_POSITION_INT").lat for heard in vehicles.values()]
    assert latitudes == [pytest.approx(473977420, 10), pytest.approx(10**8, 10)]


def test_what_happens_is_told_in_a_line_unless_it_shall_be_quiet(tmp_path: Path) -> None:
    scenario = tmp_path / "a.sim.yaml"
    scenario.write_text(EVENTS)
    instance = free_instance()
    with running("--scenario", scenario, "-i", instance) as sitl:
        assert sitl.stdout is not None
        assert sitl.stdout.readline() == "sitl: 0.50 s: wind: east_mps 2.0\n"
    with running("--scenario", scenario, "-i", instance, "--quiet") as sitl:
        hear(instance, 1.5)
        sitl.terminate()
        assert sitl.stdout is not None
        assert sitl.stdout.read() == ""


def test_a_scenario_is_checked_without_flying(tmp_path: Path) -> None:
    good, bad = tmp_path / "a.sim.yaml", tmp_path / "b.sim.yaml"
    good.write_text(EVENTS)
    bad.write_text(EVENTS.replace("wind", "wnd"))
    right, wrong, missing = check(good), check(bad), check(tmp_path / "c.sim.yaml")
    assert (right.returncode, right.stdout) == (0, f"{good}: a good scenario, 1 event\n")
    assert (wrong.returncode, wrong.stdout) == (2, "")
    assert f"{bad}:3:" in wrong.stderr and "wind" in wrong.stderr
    assert (missing.returncode, "cannot be read" in missing.stderr) == (2, True)


@pytest.mark.parametrize(
    ("arguments", "part"),
    [(("--speed", "0"), "0.01"), (("-i", "254"), "253"), (("--home", "north"), "LAT,LON,ALT")],
)
def test_a_wrong_option_is_explained(arguments: tuple[str, str], part: str) -> None:
    command = [sys.executable, "-m", "sitl", *arguments]
    done = subprocess.run(command, capture_output=True, text=True, timeout=START_S, check=False)
    assert done.returncode == 2
    assert part in done.stderr
