"""Flies in real time: the link, the clock, the watchdog, and the signals that end the flight."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from types import FrameType
from typing import TYPE_CHECKING

from companion.cli.terminal import Terminal, undisturbed
from companion.errors import CompanionError

if TYPE_CHECKING:
    from companion.app import Companion
    from companion.vehicle.link import Link

OFFBOARD_PORT = 14540


def fly_over(
    companion: Companion,
    terminal: Terminal,
    speed: float,
    timeout_s: float,
    begin_s: float = 0.0,
    *,
    link_of: Callable[[], Link],
    events: str | None,
) -> None:
    """Flies over a link in real time until the companion has ended or is stopped.

    Args:
        companion: the companion to run.
        terminal: where it prints.
        speed: as a multiple of real time.
        timeout_s: time to wait for a vehicle.
        begin_s: flight time that has passed already.
        link_of: opens the link.
        events: where reports are received.
    """
    from companion.clock import ScaledClock
    from companion.driving import fly
    from companion.vehicle.report_port import reports_at
    from companion.watchdog import Watchdog

    with (
        reports_at(events) as reports,
        closing(link_of()) as link,
        closing(Watchdog(os.environ)) as watchdog,
    ):
        terminal.say(f"waiting    for a vehicle on {link.endpoint}")
        clock = ScaledClock(speed, begin_s=begin_s)
        with stoppable(companion, terminal), undisturbed(companion.hang_up):
            fly(companion, link, clock, timeout_s, lambda: watchdog.beat(time.monotonic()), reports)


def raise_failure(failure: CompanionError | None) -> None:
    """Raises the failure of a flight, if there is one."""
    if failure is not None:
        raise failure


@contextmanager
def stoppable(companion: Companion, terminal: Terminal) -> Iterator[None]:
    """The first Ctrl-C (or SIGTERM) holds, lands and exits; the second one exits at once."""

    def stop(number: int, _: FrameType | None) -> None:
        signal.signal(number, signal.default_int_handler)  # before the message below promises it
        companion.stop()
        terminal.say("stopping: hold, land, exit; once more to exit at once", is_error=True)

    before = {n: signal.signal(n, stop) for n in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
