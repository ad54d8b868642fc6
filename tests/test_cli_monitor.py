"""The monitor page as a ground station switches it: what becomes of the page, and of the flight.

Everything is said and heard over MAVLink; the page is asked over HTTP.
"""

from __future__ import annotations

import contextlib
import os
import re
import signal
import socket
import time
import urllib.request
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from urllib.error import URLError

import pytest
from autopilot import Autopilot, of_type
from notes import Notes
from synthetic import mission

from companion.app import Companion
from companion.cli.terminal import Terminal
from companion.flight_events.event import FlightEvent
from companion.flight_events.sortie import TaskSatisfied
from companion.flights.monitor_page import Page, PageOptions, monitored
from companion.mavlink.framing import MavlinkCodec, dialect
from companion.mavlink.parameters import INT32, decode, encode
from companion.run_sources.only_run import OnlyRun
from companion.tick import TICK_S

HTTP_S = GONE_S = 300.0  # wall time that no answer and no end needs
NAME = b"CMP_MONITOR"


class Flight(Notes):
    """A companion that flies to A, with an autopilot and a ground station, tick by tick."""

    def __init__(self, page: Page | None) -> None:
        super().__init__()
        self.companion = Companion(OnlyRun(mission("F at(A)"), self), page=page)
        self.told: list[str] = []
        self._autopilot, self._station = Autopilot(), MavlinkCodec(255, 190)
        self._ear = MavlinkCodec(0, 0)
        self._answers: list[bytes] = []
        self._ticks = 0

    def tick(self, *messages: Any) -> list[Any]:
        """One tick, in which the ground station says something; what the companion said."""
        arriving = [self._station.pack(message) for message in messages]
        arriving += [*self._answers, *self._autopilot.telemetry()]
        sent = self.companion.step(self._ticks * TICK_S, arriving)
        self._answers = self._autopilot.answer(sent)
        self._ticks += 1
        heard = [message for datagram in sent for message in self._ear.parse(datagram)]
        self.told += [message.text for message in of_type(heard, "STATUSTEXT")]
        return heard

    def run(self, seconds: float) -> list[Any]:
        return [m for _ in range(round(seconds / TICK_S)) for m in self.tick()]

    def to_the_end(self) -> list[FlightEvent]:
        """Flies on; all that was reported."""
        while not self.companion.has_ended:
            assert self._ticks * TICK_S < 60.0, self.events
            self.tick()
        return self.events

    @property
    def monitor(self) -> float:
        """CMP_MONITOR as it is read."""
        return value_of(self.tick(dialect.MAVLink_param_request_read_message(1, 191, NAME, -1)))

    def switch(self, is_on: bool) -> list[Any]:
        """PARAM_SET; what was said in the same tick."""
        value = encode(float(is_on), INT32)
        return self.tick(dialect.MAVLink_param_set_message(1, 191, NAME, value, INT32))


def value_of(heard: list[Any]) -> float:
    (answer,) = of_type(heard, "PARAM_VALUE")
    assert answer.param_id == NAME.decode()
    return decode(answer.param_value, answer.param_type)


def address_in(texts: list[str]) -> str:
    """Where the page is, as the ground station was told."""
    found = re.search(r"monitor page (http://127\.0\.0\.1:\d+)", "".join(texts))
    assert found, texts
    return found[1]


def is_there(address: str) -> bool:
    """Whether the page answers."""
    try:
        with urllib.request.urlopen(address, timeout=HTTP_S) as page:
            return b'<section id="map"' in page.read()
    except (URLError, ConnectionError):
        return False


def is_gone(address: str) -> bool:
    """Whether it stops answering."""
    end_s = time.monotonic() + GONE_S
    while is_there(address):
        if time.monotonic() > end_s:
            return False
        time.sleep(0.02)
    return True


@pytest.fixture
def page() -> Iterator[Page]:
    page = Page(PageOptions(port=0), Terminal().say)
    yield page
    page.close()


def kill(page: Page) -> None:
    """As if it had crashed."""
    assert page._child is not None
    os.kill(page._child._process.pid, signal.SIGKILL)
    while page.is_served:
        time.sleep(0.01)


def test_it_goes_on_and_off_as_a_ground_station_says(page: Page, surveillance_run: Path) -> None:
    flight = Flight(page)
    page.show(surveillance_run)
    flight.run(1.0)
    assert flight.monitor == 0.0
    assert value_of(flight.switch(True)) == 1.0
    flight.run(2.0)
    address = address_in(flight.told)
    assert is_there(address)
    with urllib.request.urlopen(f"{address}/stream", timeout=HTTP_S) as stream:
        while b'"name":"surveillance"' not in stream.readline():
            pass
    told = len(flight.told)
    assert value_of(flight.switch(True)) == 1.0  # said again
    flight.run(1.0)
    assert not any("monitor" in text for text in flight.told[told:])
    assert value_of(flight.switch(False)) == 0.0
    assert is_gone(address)
    assert value_of(flight.switch(True)) == 1.0
    assert is_there(address), "where it was before"


def test_a_page_that_cannot_be_served_is_off_and_the_reason_is_told() -> None:
    """No port is higher than 65535, so there is no next one."""
    with socket.socket() as taken:
        with contextlib.suppress(OSError):  # somebody else has it, which is as good
            taken.bind(("127.0.0.1", 65535))
            taken.listen()
        flight = Flight(Page(PageOptions(port=65535), Terminal().say))
        flight.run(1.0)
        heard = flight.switch(True)
    assert value_of(heard) == 0.0
    assert [e.param_id for e in of_type(heard, "PARAM_ERROR")] == [NAME.decode()]
    flight.run(2.0)
    assert "the monitor cannot listen on 127.0.0.1:65535: Address already in use" in "".join(
        flight.told
    )
    assert flight.monitor == 0.0


def test_a_page_that_crashes_is_off_and_the_flight_goes_on(page: Page) -> None:
    undisturbed = Flight(None).to_the_end()
    flight = Flight(page)
    flight.run(6.0)
    assert flight.switch(True)
    flight.run(0.5)
    kill(page)
    assert value_of(flight.tick()) == 0.0
    flight.run(1.0)
    assert "monitor page has ended by itself" in flight.told
    assert flight.switch(True)
    assert flight.monitor == 1.0
    assert flight.to_the_end() == undisturbed
    assert undisturbed[-1] == TaskSatisfied()


def test_without_a_page_it_stays_off() -> None:
    flight = Flight(None)
    flight.run(1.0)
    assert value_of(flight.switch(True)) == 0.0


@pytest.mark.parametrize("is_on", [False, True])
def test_it_begins_as_the_command_says(is_on: bool, capfd: pytest.CaptureFixture[str]) -> None:
    with monitored(PageOptions(port=0, is_on=is_on), Terminal().say) as page:
        flight = Flight(page)
        flight.run(1.0)
        assert flight.monitor == is_on
    printed = capfd.readouterr().out
    assert bool(re.search(r"^monitor    http://127\.0\.0\.1:\d+$", printed, re.MULTILINE)) is is_on
