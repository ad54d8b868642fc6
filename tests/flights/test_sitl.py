"""`sitl` as people start it: options, environment, several at once, what it prints."""

import os
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import islice
from pathlib import Path
from typing import Any

import pytest
from ports import free_instance, own_ports

from companion.mavlink.framing import MavlinkCodec, dialect
from sitl.link.routing import LinkName
from sitl.link.server import HOST, LOCAL_PORTS

pytestmark = pytest.mark.sockets

START_S = 300.0  # wall time that no start and no message needs
EVENTS = "version: 1\nhappens:\n  - {at_s: 0.5, wind: {east_mps: 2}}\n"
LOCAL = LOCAL_PORTS[LinkName.OFFBOARD]


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


def heard(instance: int) -> Iterator[Any]:
    """What the offboard link of an instance sends to a client that speaks to it."""
    client = MavlinkCodec(255, 190)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as udp:
        udp.settimeout(START_S)
        heartbeat = dialect.MAVLink_heartbeat_message(6, 8, 0, 0, 4, 3)
        udp.sendto(client.pack(heartbeat), (HOST, LOCAL + instance))
        while True:
            yield from client.parse(udp.recv(2048))


def first(instance: int, name: str) -> Any:
    return next(message for message in heard(instance) if message.get_type() == name)


def boot_times_s(instance: int) -> Iterator[float]:
    return (m.time_boot_ms / 1e3 for m in heard(instance) if m.get_type() == "ATTITUDE")


def paces(instance: int) -> Iterator[float]:
    """Simulated seconds per second, in one second after the other."""
    times = boot_times_s(instance)
    simulated_s, wall_s = next(times), time.monotonic()
    for now_s in times:
        if (passed_s := time.monotonic() - wall_s) >= 1.0:
            yield (now_s - simulated_s) / passed_s
            simulated_s, wall_s = now_s, time.monotonic()


def keeps_pace(instance: int, speed: float) -> bool:
    """Whether it soon has a second at a speed; a busy machine pauses it in others."""
    return any(pace == pytest.approx(speed, rel=0.15) for pace in islice(paces(instance), 120))


def check(path: Path) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "sitl", "--check", str(path)]
    return subprocess.run(command, capture_output=True, text=True, timeout=START_S, check=False)


def test_the_environment_of_px4_is_honoured() -> None:
    instance = free_instance()
    home = {"PX4_HOME_LAT": "48.5", "PX4_HOME_LON": "-11.25", "PX4_HOME_ALT": "250"}
    with running(*own_ports(instance), PX4_SIM_SPEED_FACTOR="4", **home):
        place = first(instance, "GLOBAL_POSITION_INT")
        assert keeps_pace(instance, 4.0)
    assert (place.lat, place.lon) == (pytest.approx(485000000, 10), pytest.approx(-112500000, 10))
    assert place.alt == pytest.approx(250_000, abs=500)


def test_an_option_wins_over_the_environment() -> None:
    instance = free_instance()
    options = (*own_ports(instance), "--speed", 2, "--home", "10,20,30")
    with running(*options, PX4_SIM_SPEED_FACTOR="9", PX4_HOME_LAT="48.5"):
        place = first(instance, "GLOBAL_POSITION_INT")
        assert keeps_pace(instance, 2.0)
    assert (place.lat, place.lon) == (pytest.approx(10**8, 10), pytest.approx(2 * 10**8, 10))


def test_instances_side_by_side_are_vehicles_of_their_own() -> None:
    one = free_instance()
    with running(*own_ports(one)):
        other = free_instance()
        with running(*own_ports(other), "--home", "10,20,30"):
            vehicles = {instance: list(islice(heard(instance), 200)) for instance in (one, other)}
            latitudes = [first(instance, "GLOBAL_POSITION_INT").lat for instance in vehicles]
    for instance, messages in vehicles.items():
        assert {message.get_srcSystem() for message in messages} == {1 + instance}
    assert latitudes == [pytest.approx(473977420, 10), pytest.approx(10**8, 10)]


def test_what_happens_is_told_in_a_line_unless_it_shall_be_quiet(tmp_path: Path) -> None:
    scenario = tmp_path / "a.sim.yaml"
    scenario.write_text(EVENTS)
    instance = free_instance()
    with running("--scenario", scenario, *own_ports(instance)) as sitl:
        assert sitl.stdout is not None
        assert sitl.stdout.readline() == "sitl: 0.50 s: wind: east_mps 2.0\n"
    with running("--scenario", scenario, *own_ports(instance), "--quiet") as sitl:
        next(now_s for now_s in boot_times_s(instance) if now_s > 1.0)
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
