"""Simulator and companion as commands in processes of their own, over UDP, as a user runs them.

On instances of the simulator that nobody uses here. A test waits for lines that a command prints,
never for a time. Simulated time runs twice as fast where the command allows it.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import math
import os
import re
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from random import Random

import pytest
from hop import hop_in
from pictures import programs_do_not_draw
from ports import free_instance, own_ports
from test_mavsdk_client import first, mavsdk
from test_shipped import SHIPPED

from companion import load_mission, simulate
from companion.flight_events.event import FlightEvent
from companion.flight_events.hosting import ClockFollowed
from companion.flight_events.reading import read_line
from companion.flight_events.skills import PlaceReached, SkillCompleted
from companion.flight_events.sortie import (
    AutopilotSaid,
    Phase,
    PhaseEntered,
    RunFailed,
    SetpointRefused,
    StoppedAsAsked,
    StopRequested,
)
from companion.record.audit import audit
from companion.record.events import JOURNAL_FILE, read_events
from sitl.link.server import LOCAL_PORTS

pytestmark = pytest.mark.sockets

SURVEILLANCE = Path(__file__).parents[2] / "missions" / "surveillance.yaml"
STORED = Path(__file__).parents[1] / "data" / "surveillance.events.txt"
GROUND_STATION, COMPANION = 14550, 14540
START_S, FLIGHT_S = 300.0, 400.0  # wall time that no start and no flight needs
LOST = "a failsafe of the autopilot has control"
"""Printed where the machine was too busy for the companion's setpoints."""
WAITS = "to give control back"
"""Printed by a companion that then waits for an operator; no test here gives control back."""
SPEED = 2
LEFT_OUT = (SetpointRefused, AutopilotSaid, ClockFollowed)


class Command:
    """A command that runs; what it prints is collected while it does.

    Args:
        module: companion or sitl.
        arguments: of the command.
    """

    def __init__(self, module: str, *arguments: object) -> None:
        self._process = subprocess.Popen(
            [sys.executable, "-m", module, *map(str, arguments)],
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            start_new_session=True,  # a group of its own, as a shell gives a foreground command
        )
        self._lines: list[str] = []
        self._news = threading.Condition()
        self._has_closed = False
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    @property
    def pid(self) -> int:
        return self._process.pid

    @property
    def printed(self) -> str:
        with self._news:
            return "".join(self._lines)

    def until_printed(self, text: str, timeout_s: float = FLIGHT_S) -> None:
        """Waits until a text was printed; fails if the command ends or waits before."""
        assert self.has_printed(text, timeout_s), f"not printed: {text}\n{self.printed}"

    def has_printed(self, text: str, timeout_s: float = FLIGHT_S) -> bool:
        """Waits until a text was printed, or the command ends, or waits for an operator."""

        def is_over() -> bool:
            is_left = any(LOST in line and WAITS in line for line in self._lines)
            return self._has_closed or is_left or any(text in line for line in self._lines)

        with self._news:
            self._news.wait_for(is_over, timeout_s)
        return text in self.printed

    def exit_code(self, timeout_s: float = FLIGHT_S) -> int:
        """Waits for the end."""
        code = self._process.wait(timeout_s)
        self._reader.join(timeout_s)
        return code

    def close(self) -> None:
        """Ends it if it runs, without a landing: so that it ends its children, else by force."""
        for number, wait_s in ((signal.SIGINT, 1.0), (signal.SIGINT, 10.0), (signal.SIGKILL, 10.0)):
            if self._process.poll() is None:
                self._process.send_signal(number)
                with contextlib.suppress(subprocess.TimeoutExpired):
                    self._process.wait(wait_s)
        self._reader.join(START_S)

    def _read(self) -> None:
        assert self._process.stdout is not None
        with self._process.stdout as stream:
            for line in stream:
                with self._news:
                    self._lines.append(line)
                    self._news.notify_all()
        with self._news:
            self._has_closed = True
            self._news.notify_all()


Run = Callable[..., Command]


def simulated(run: Run, mission: Path, speed: int, instance: int, log_dir: Path) -> Command:
    """`companion sim`; without the page, which takes as much time as the flight."""
    return run(
        *(
            "companion",
            "sim",
            mission,
            "--speed",
            speed,
            *own_ports(instance),
            "--log-dir",
            log_dir,
        ),
        *("--monitor", "off"),
    )


@pytest.fixture
def run(
    request: pytest.FixtureRequest,
    monkeypatch: pytest.MonkeyPatch,
    tmp_path_factory: pytest.TempPathFactory,
) -> Iterator[Run]:
    """Starts commands, and ends them all; they draw their flights for those who ask for `drawn`."""
    commands: list[Command] = []
    if "drawn" not in request.fixturenames:
        programs_do_not_draw(tmp_path_factory.mktemp("undrawn"), monkeypatch)

    def start(module: str, *arguments: object) -> Command:
        commands.append(Command(module, *arguments))
        return commands[-1]

    yield start
    for command in reversed(commands):
        command.close()


@pytest.fixture
def instance() -> int:
    return free_instance()


def assert_no_simulator_is_left(instance: int) -> None:
    """A simulator holds its two ports for as long as it lives."""
    for base in LOCAL_PORTS.values():
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as udp:
            udp.bind(("127.0.0.1", base + instance))


def run_folder(log_dir: Path) -> Path:
    """Of the only run."""
    (events,) = log_dir.glob("[0-9]*/events.jsonl")
    return events.parent


def recorded(log_dir: Path) -> list[FlightEvent]:
    """All that people were told in the only run.

    On a busy machine the gate may hold the vehicle for a moment, and the simulator may fall behind
    for seconds; that is left out. So are the autopilot's own words: some are said only where a
    ground station is heard.
    """
    folder = run_folder(log_dir)
    lines = (folder / "events.jsonl").read_text(encoding="utf-8").splitlines()
    events = [read_line(line).event for line in lines]
    return [e for e in events if e.is_told and not isinstance(e, LEFT_OUT)]


def sequence(log_dir: Path) -> str:
    """Its kinds and texts, as the stored file has them."""
    return kinds_and_texts(recorded(log_dir))


def kinds_and_texts(events: Iterable[FlightEvent]) -> str:
    return "".join(f"{event.kind} {event.text}\n" for event in events)


def in_lockstep(mission: Path) -> str:
    """The same of a mission that is flown in this process."""
    events = [stamped.event for stamped in simulate(load_mission(mission)).events]
    return kinds_and_texts(e for e in events if e.is_told and not isinstance(e, LEFT_OUT))


# -- the whole mission -----------------------------------------------------------------------------


def test_a_ground_station_watches_the_simulated_mission(
    run: Run, instance: int, tmp_path: Path
) -> None:
    companion = simulated(run, SURVEILLANCE, SPEED, instance, tmp_path)
    companion.until_printed("ground station on UDP port", START_S)
    asyncio.run(watch(GROUND_STATION + instance))
    assert companion.exit_code() == 0, companion.printed
    assert sequence(tmp_path) == STORED.read_text(encoding="utf-8")
    assert_no_simulator_is_left(instance)


async def watch(port: int) -> None:
    """What QGroundControl shows, as MAVSDK sees it: connected, healthy, armed, and moving."""
    from mavsdk.asyncio.plugins.telemetry import FlightMode, TelemetryAsync

    kind = mavsdk.ComponentType.GROUND_STATION
    async with mavsdk.Mavsdk(mavsdk.Configuration.create_with_component_type(kind)) as client:
        await client.add_any_connection(f"udpin://127.0.0.1:{port}")
        system = await client.first_autopilot(timeout_s=START_S)
        assert system is not None, "no autopilot seen"
        telemetry = TelemetryAsync(system)
        await first(telemetry.subscribe_health_all_ok(), bool)
        await first(telemetry.subscribe_armed(), bool)
        await first(telemetry.subscribe_flight_mode(), lambda mode: mode == FlightMode.OFFBOARD)
        start = (await first(telemetry.subscribe_position_velocity_ned(), lambda _: True)).position
        await first(
            telemetry.subscribe_position_velocity_ned(),
            lambda now: (
                math.hypot(now.position.north_m - start.north_m, now.position.east_m - start.east_m)
                > 2.0
            ),
        )


def hopping(run: Run, instance: int, folder: Path, *options: object) -> tuple[Command, str]:
    """A companion with a short mission, and where it listens."""
    connect = f"udpin://127.0.0.1:{COMPANION + instance}"
    asked = ("run", hop_in(folder), "--connect", connect, "--log-dir", folder, "--monitor", "off")
    return run("companion", *asked, *options), connect


def test_the_mission_flies_on_a_simulator_started_separately(
    run: Run, instance: int, tmp_path: Path
) -> None:
    """In real time, as with a real vehicle; the companion is there first."""
    companion, connect = hopping(run, instance, tmp_path)
    companion.until_printed(f"waiting    for a vehicle on {connect}", START_S)
    simulator = run("sitl", *own_ports(instance))
    assert companion.exit_code() == 0, companion.printed
    assert sequence(tmp_path) == in_lockstep(hop_in(tmp_path))
    os.kill(simulator.pid, signal.SIGTERM)
    assert simulator.exit_code(START_S) == 0


@pytest.mark.parametrize("speed", [2.0, pytest.param(0.5, marks=pytest.mark.long)])
def test_a_simulator_that_runs_at_another_speed_is_followed(
    speed: float, run: Run, instance: int, tmp_path: Path
) -> None:
    """Nobody tells the companion; as with PX4_SIM_SPEED_FACTOR, or a Gazebo that is too slow."""
    run("sitl", *own_ports(instance), "--speed", speed)
    companion, _ = hopping(run, instance, tmp_path)
    assert companion.exit_code() == 0, companion.printed
    assert sequence(tmp_path) == in_lockstep(hop_in(tmp_path))
    assert "times as fast as this computer's" in companion.printed
    assert not audit(read_events(run_folder(tmp_path))).is_failure


def killed(
    run: Run,
    instance: int,
    folder: Path,
    text: str,
    later_s: float = 0.0,
    speed: int = 1,
    mission: Path | None = None,
) -> tuple[str | Path, ...]:
    """Kills a companion so long after it has printed a text; returns the command to go on.

    Without a mission of the shipped ones it flies a short one.
    """
    connect = f"udpin://127.0.0.1:{COMPANION + instance}"
    flown = mission or hop_in(folder)
    options = ("--log-dir", folder, "--resume", "--monitor", "off")
    asked = ("companion", "run", flown, "--connect", connect, *options)
    scenario = ("--scenario", mission.with_suffix(".sim.yaml")) if mission else ()
    run("sitl", *own_ports(instance), *scenario, "--speed", speed)
    companion = run(*asked)
    companion.until_printed(text)
    time.sleep(later_s)
    os.kill(companion.pid, signal.SIGKILL)
    assert companion.exit_code() == -signal.SIGKILL
    return asked


def test_a_flight_that_was_killed_is_gone_on_with(run: Run, instance: int, tmp_path: Path) -> None:
    """Killed between two sites; started again, it has the journal alone.

    As with: companion run missions/surveillance.yaml --resume
    """
    resumed = run(*killed(run, instance, tmp_path, "at A", speed=SPEED))
    assert resumed.exit_code() == 0, resumed.printed
    assert "the companion was away" in resumed.printed
    record = read_events(run_folder(tmp_path))
    assert record.ending is not None and record.ending.exit_code == 0
    assert not audit(record).is_failure


def test_the_time_away_is_the_autopilots_where_the_wall_clock_was_set_back(
    run: Run, instance: int, tmp_path: Path
) -> None:
    """As on a computer without a clock of its own, after a loss of power."""
    asked = killed(run, instance, tmp_path, "at A")
    journal = run_folder(tmp_path) / JOURNAL_FILE
    entries = [json.loads(line) for line in journal.read_text(encoding="utf-8").splitlines()]
    later = [entry | {"unix_s": entry["unix_s"] + 3600.0} for entry in entries]
    journal.write_text("".join(f"{json.dumps(entry)}\n" for entry in later), encoding="utf-8")
    time.sleep(2.0)
    resumed = run(*asked)
    resumed.until_printed("the companion was away")
    most_s = time.time() - entries[-1]["unix_s"] + 2.0  # since the last that the journal has
    (away_s,) = re.findall(r"the companion was away for ([0-9.]+) s", resumed.printed)
    assert 2.0 <= float(away_s) < most_s


@pytest.mark.long
@pytest.mark.parametrize("seed", range(10))
def test_killed_at_any_time_of_the_task_a_flight_is_gone_on_with(
    seed: int, run: Run, instance: int, tmp_path: Path
) -> None:
    """Within four seconds after a place that is drawn; in lockstep 50 times in all phases."""
    chance = Random(seed)
    text = chance.choice(["flying the task", "at A", "at B", "target found", "at r2"])
    later_s = chance.uniform(0.0, 4.0)
    resumed = run(*killed(run, instance, tmp_path, text, later_s, mission=SURVEILLANCE))
    assert resumed.exit_code() == 0, resumed.printed
    record = read_events(run_folder(tmp_path))
    done = [event for event in recorded(tmp_path) if isinstance(event, SkillCompleted)]
    assert len(done) <= 1 and resumed.printed.count("arming\n") == 0
    assert record.ending is not None and record.ending.exit_code == 0
    assert not audit(record).is_failure


# -- the other missions ----------------------------------------------------------------------------

MISSIONS = SURVEILLANCE.parent
SPEEDS = [2, 1]
"""At 2, a pause of 0.5 s is a lost link in flight; several flights share the machine. A speed that
was too fast for it is not tried again."""


def achieved_in(events: Iterable[object]) -> list[str]:
    """The places that were reached (strings, in stories), and what else was completed."""
    achieved: list[str] = []
    for event in events:
        match event:
            case PlaceReached(place=name) | SkillCompleted(action=name) | str(name):
                achieved.append(name)
    return achieved


TOO_LONG = "endless_patrol"
"""Eleven minutes: flown in lockstep alone."""
ACHIEVED = {
    **{
        shipped.mission: achieved_in(shipped.story)
        for shipped in SHIPPED
        if not isinstance(shipped.story[-1], RunFailed) and shipped.mission != TOO_LONG
    },
    "by_hand": ["A", "B", "C", "A", "r1", "r2", "upload(r2)", "Home"],
    "lost_person": ["West", "Person", SkillCompleted("drop").action, "Home"],
    "inspection": ["inspect(Home, A)", "inspect(here, C)", "Home"],
}
"""What each mission achieves until it is satisfied; one that is not is stopped in its test."""


def fly(run: Run, mission: str, instance: int, log_dir: Path, until: str = "") -> list[str]:
    """What a mission achieves until it ends, or is stopped as soon as a text was printed.

    A busy machine pauses processes for longer than the autopilot waits for setpoints. What it ends
    so is flown again more slowly. The audit must find nothing violated.
    """
    while True:
        speed = SPEEDS[0]
        folder = log_dir / str(speed)
        companion = simulated(run, MISSIONS / f"{mission}.yaml", speed, instance, folder)
        if until and companion.has_printed(until):
            os.kill(companion.pid, signal.SIGINT)
        code = companion.exit_code()
        if LOST not in companion.printed or len(SPEEDS) == 1:
            break
        del SPEEDS[0]
    assert code == 0, companion.printed
    assert not audit(read_events(run_folder(folder))).is_failure
    return achieved_in(recorded(folder))


def test_all_missions_are_flown_here() -> None:
    names = {path.name.removesuffix(".sim.yaml") for path in MISSIONS.glob("*.sim.yaml")}
    shipped = {name for name in names if (MISSIONS / f"{name}.yaml").exists()}
    assert shipped - {TOO_LONG} == {
        *ACHIEVED,
        "surveillance",
        "paper_section_v",
        "persistent_patrol",
    }


IN_EVERY_RUN = {"lost_person"}
"""With reports of another program; lockstep flies all, and so do the sweeps."""


@pytest.mark.parametrize(
    "mission",
    [
        name if name in IN_EVERY_RUN else pytest.param(name, marks=pytest.mark.long)
        for name in ACHIEVED
    ],
)
def test_a_mission_flies_in_two_processes(
    mission: str, run: Run, instance: int, tmp_path: Path
) -> None:
    assert fly(run, mission, instance, tmp_path) == ACHIEVED[mission]


def test_a_patrol_lands_charges_and_goes_on_in_two_processes(
    run: Run, instance: int, tmp_path: Path
) -> None:
    charged = SkillCompleted("recharge(here, Dock)")
    achieved = fly(run, "persistent_patrol", instance, tmp_path, until=charged.text)
    assert achieved == ["A", "B", charged.action]


# -- the end comes from outside --------------------------------------------------------------------


@pytest.fixture
def flying(run: Run, instance: int, tmp_path: Path) -> Command:
    """A simulated flight on its way from A to B."""
    companion = simulated(run, hop_in(tmp_path), SPEED, instance, tmp_path)
    companion.until_printed("at A")
    return companion


STOPS: dict[str, Callable[[int], None]] = {
    "SIGINT to the process": lambda pid: os.kill(pid, signal.SIGINT),
    "Ctrl-C in a terminal": lambda pid: os.killpg(pid, signal.SIGINT),
    "SIGTERM": lambda pid: os.kill(pid, signal.SIGTERM),
}


@pytest.mark.parametrize(
    "stop",
    [
        pytest.param(s, marks=[pytest.mark.long] if s == "SIGINT to the process" else [])
        for s in STOPS
    ],
)
def test_a_stop_in_flight_lands(stop: str, flying: Command, instance: int, tmp_path: Path) -> None:
    STOPS[stop](flying.pid)
    assert flying.exit_code() == 0, flying.printed
    assert recorded(tmp_path)[-4:] == [
        StopRequested(),
        PhaseEntered(Phase.HOLDING),
        PhaseEntered(Phase.LANDING),
        StoppedAsAsked(),
    ]
    assert_no_simulator_is_left(instance)


@pytest.mark.parametrize(
    "number", [signal.SIGINT, pytest.param(signal.SIGTERM, marks=pytest.mark.long)]
)
def test_a_second_stop_ends_at_once(
    number: signal.Signals, flying: Command, instance: int, tmp_path: Path
) -> None:
    os.kill(flying.pid, number)
    flying.until_printed("once more to exit at once")
    os.kill(flying.pid, number)
    assert flying.exit_code(START_S) == 128 + signal.SIGINT, flying.printed
    assert "Traceback" not in flying.printed
    assert StoppedAsAsked() not in recorded(tmp_path)
    assert_no_simulator_is_left(instance)


def test_a_killed_companion_leaves_no_simulator(flying: Command, instance: int) -> None:
    os.kill(flying.pid, signal.SIGKILL)
    flying.exit_code(START_S)
    deadline_s = time.monotonic() + START_S
    while time.monotonic() < deadline_s:
        with contextlib.suppress(OSError):
            assert_no_simulator_is_left(instance)
            return
        time.sleep(0.1)
    assert_no_simulator_is_left(instance)


def test_no_vehicle_is_exit_code_4(run: Run, instance: int, tmp_path: Path) -> None:
    connect = f"udpin://127.0.0.1:{COMPANION + instance}"
    companion = run(
        *("companion", "run", SURVEILLANCE, "--connect", connect),
        *("--timeout", 1, "--log-dir", tmp_path),
    )
    assert companion.exit_code(START_S) == 4
    assert f"no vehicle on {connect} after 1 s: nothing arrived" in companion.printed
