"""The companion as real ground stations see it: over UDP, in processes of their own.

pymavlink is the ground station that steps in; MAVProxy and MAVSDK are authorities from outside on
what people get to see. The operator's companion is
`companion run missions/surveillance.yaml --wait`, with a shorter mission.
"""

from __future__ import annotations

import asyncio
import contextlib
import math
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from ports import free_instance, own_ports
from pymavlink import mavutil
from test_mavproxy import MAVProxy
from test_mavsdk_client import mavsdk
from test_sockets import GROUND_STATION, SPEED, START_S, Run, hopping, run

from companion.mavlink.framing import dialect

__all__ = ["run"]
pytestmark = pytest.mark.sockets

START, PAUSE = dialect.MAV_CMD_MISSION_START, dialect.MAV_CMD_DO_PAUSE_CONTINUE
RETURN = dialect.MAV_CMD_NAV_RETURN_TO_LAUNCH
ANSWER_S = 300.0
"""Wall time that no answer needs; QGroundControl waits 1.2 s, for which see test_operator.py."""


class Station:
    """A ground station of pymavlink's: system 255, on the port where QGroundControl listens."""

    def __init__(self, port: int, system: int) -> None:
        self._link: Any = mavutil.mavlink_connection(
            f"udpin:127.0.0.1:{port}", source_system=255, source_component=190
        )
        self._system = system
        self.heard: list[Any] = []
        self._beat_s = 0.0

    def until(self, is_so: Callable[[Any], bool], limit_s: float = ANSWER_S) -> Any:
        """The first message that is so; heartbeats are sent meanwhile."""
        end_s = time.monotonic() + limit_s
        while (now_s := time.monotonic()) < end_s:
            if now_s >= self._beat_s:
                self._beat_s = now_s + 1.0
                self._link.mav.heartbeat_send(6, 8, 0, 0, 4)
            message = self._link.recv_match(blocking=True, timeout=0.1)
            if message is not None:
                self.heard.append(message)
                if is_so(message):
                    return message
        raise AssertionError(f"not heard in {limit_s:.1f} s; texts: {self.texts}")

    def ask(self, number: int, *parameters: float) -> int:
        """A command to the companion; its answer."""
        filled = (*parameters, *[0.0] * (7 - len(parameters)))
        self._link.mav.command_long_send(self._system, 191, number, 0, *filled)
        answer = self.until(
            lambda m: (
                m.get_type() == "COMMAND_ACK" and (m.get_srcComponent(), m.command) == (191, number)
            )
        )
        assert (answer.target_system, answer.target_component) == (255, 190)
        return int(answer.result)

    def until_accepted(self, number: int, limit_s: float = ANSWER_S) -> None:
        """Asks for a command again, while it is refused for now."""
        end_s = time.monotonic() + limit_s
        while self.ask(number) != dialect.MAV_RESULT_ACCEPTED:
            assert time.monotonic() < end_s, self.texts
            self.until(lambda m: m.get_type() == "HOME_POSITION")

    def list_parameters(self, component: int) -> set[int]:
        """Indices of the companion's parameters, as a list brought them."""
        self._link.mav.param_request_list_send(self._system, component)
        indices: set[int] = set()

        def is_complete(message: Any) -> bool:
            if message.get_type() == "PARAM_VALUE" and message.get_srcComponent() == 191:
                indices.add(message.param_index)
                return len(indices) == int(message.param_count)
            return False

        self.until(is_complete)
        return indices

    def until_told(self, text: str, limit_s: float = ANSWER_S) -> None:
        """Waits for a STATUSTEXT of the companion."""

        def is_it(message: Any) -> bool:
            is_text = message.get_type() == "STATUSTEXT" and message.get_srcComponent() == 191
            return is_text and str(message.text).startswith(text)

        self.until(is_it, limit_s)

    def position(self) -> Any:
        """The next position."""
        return self.until(lambda m: m.get_type() == "LOCAL_POSITION_NED")

    def until_moving(self, is_so: Callable[[float], bool]) -> Any:
        """The next position with such a speed over ground, m/s."""
        return self.until(
            lambda m: m.get_type() == "LOCAL_POSITION_NED" and is_so(math.hypot(m.vx, m.vy))
        )

    @property
    def texts(self) -> list[str]:
        return [m.text for m in self.heard if m.get_type() == "STATUSTEXT"]

    def close(self) -> None:
        self._link.close()


@pytest.fixture
def instance() -> int:
    return free_instance()


@pytest.fixture
def station(instance: int) -> Iterator[Station]:
    station = Station(GROUND_STATION + instance, 1 + instance)
    yield station
    station.close()


def test_an_operator_starts_and_steps_in(
    run: Run, instance: int, station: Station, tmp_path: Path
) -> None:
    simulator = run("sitl", *own_ports(instance))
    simulator.until_printed("ground station on UDP", START_S)
    companion, _ = hopping(run, instance, tmp_path, "--wait")
    companion.until_printed("waiting", START_S)
    station.until(lambda m: m.get_type() == "HEARTBEAT" and m.get_srcComponent() == 191, START_S)
    station.until(lambda m: m.get_type() == "HOME_POSITION", START_S)
    assert station.list_parameters(191) == station.list_parameters(0) == set(range(5))
    assert station.ask(31999) == dialect.MAV_RESULT_UNSUPPORTED
    assert station.ask(START) == dialect.MAV_RESULT_ACCEPTED
    station.until_told("flying the task")
    station.until_moving(lambda speed_mps: speed_mps > 0.5)  # under way to A
    assert station.ask(PAUSE, 0.0) == dialect.MAV_RESULT_ACCEPTED
    held = station.until_moving(lambda speed_mps: speed_mps < 0.1)
    for _ in range(40):
        now = station.position()
        assert abs(now.x - held.x) + abs(now.y - held.y) + abs(now.z - held.z) < 0.5
    assert station.ask(PAUSE, 1.0) == dialect.MAV_RESULT_ACCEPTED
    station.until_told("at A")
    assert station.ask(RETURN) == dialect.MAV_RESULT_ACCEPTED
    station.until_told("returned as asked, landed")
    landed = station.position()
    assert abs(landed.x) < 0.5 and abs(landed.y) < 0.5
    companion.until_printed("results", START_S)
    (folder,) = tmp_path.glob("*-hop")
    assert (folder / "events.jsonl").exists()


def test_mavproxy_starts_it_and_shows_what_happens(run: Run, instance: int, tmp_path: Path) -> None:
    simulator = run("sitl", *own_ports(instance))
    simulator.until_printed("ground station on UDP", START_S)
    companion, _ = hopping(run, instance, tmp_path, "--wait")
    companion.until_printed("waiting", START_S)
    client = MAVProxy(GROUND_STATION + instance, 1 + instance, tmp_path)
    try:
        client.expect(r"Received 14\d parameters")
        client.expect("Received 5 parameters")
        client.type("set target_component 191")
        client.type("long MISSION_START 0 0 0 0 0 0 0", "MISSION_START: ACCEPTED")
        client.expect("taking off", "flying the task", "at A", limit_s=ANSWER_S)
    finally:
        client.close()


def test_mavsdk_hears_what_happens(run: Run, instance: int, tmp_path: Path) -> None:
    """It is there before the first word: nothing is told again."""
    simulator = run("sitl", *own_ports(instance), "--speed", SPEED)
    simulator.until_printed("ground station on UDP", START_S)

    def fly() -> None:
        hopping(run, instance, tmp_path)

    texts = asyncio.run(hear(GROUND_STATION + instance, fly, "at B"))
    told = ["flying the task", "at A", "at B"]
    assert [text for text in texts if text in told] == told


async def hear(port: int, fly: Callable[[], None], last: str) -> list[str]:
    """The texts of a flight that MAVSDK hands on, up to a last one."""
    from mavsdk.asyncio.plugins.telemetry import TelemetryAsync

    kind = mavsdk.ComponentType.GROUND_STATION
    async with mavsdk.Mavsdk(mavsdk.Configuration.create_with_component_type(kind)) as client:
        await client.add_any_connection(f"udpin://127.0.0.1:{port}")
        system = await client.first_autopilot(timeout_s=START_S)
        assert system is not None
        telemetry = TelemetryAsync(system)  # its streams end with it
        stream = telemetry.subscribe_status_text()
        fly()
        texts: list[str] = []

        async def collect() -> None:
            async for status in stream:
                texts.append(status.text)
                if status.text == last:
                    return

        with contextlib.suppress(TimeoutError):
            await asyncio.wait_for(collect(), ANSWER_S)
        await stream.aclose()
        return texts
