"""Runs a companion by the clock, over a link.

In real or scaled time, at 20 Hz, in one loop of one thread.
"""

from __future__ import annotations

import gc
import logging
from collections.abc import Callable

from companion.app import Companion
from companion.clock import ScaledClock
from companion.errors import LinkTimeout
from companion.flight_events.hosting import ClockFollowed
from companion.ground.operations import SystemStatus
from companion.slices import abandon_all
from companion.tick import TICK_S
from companion.vehicle.control_watch import PAUSED_S
from companion.vehicle.endpoints import SerialPort, TcpServer
from companion.vehicle.link import Link
from companion.vehicle.report_port import ReportPort

log = logging.getLogger(__name__)

NEWS = 1.1
"""The clock's speed is reported when it has changed by this factor."""


def fly(
    companion: Companion,
    link: Link,
    clock: ScaledClock,
    timeout_s: float,
    beat: Callable[[], None] = lambda: None,
    reports: ReportPort | None = None,
) -> None:
    """Runs a companion over a link, at 20 Hz of the clock's time, until it has ended.

    1. While nothing is flown, messages are answered at once, between ticks: a file arrives as a
       series of requests, each of which would otherwise wait for a tick.
    2. In flight, the autopilot's time requests are answered at once too, without a step.
    3. If an event that the plan watches changes, an extra step is done between two ticks, which
       stay where they are.
    4. The companion reports datagrams that were lost in a flood or refused on a signed link.
    5. After a pause of this process (stopped, or a stalled machine) the autopilot may have left
       OFFBOARD, and the next setpoint could bring it back. So messages that were due before the
       pause are not sent, messages that arrived during it are not read, and the flight waits for a
       heartbeat (`ControlWatch`).
    6. If the autopilot's clock runs at another speed than this computer's, it belongs to a
       simulator, and the flight's clock follows it.

    Args:
        companion: the companion to run.
        link: to its vehicle.
        clock: the clock of the flight.
        timeout_s: time within which the vehicle must be heard.
        beat: called in each step.
        reports: where other programs on board report events; read in each tick.

    Raises:
        LinkTimeout: no vehicle was heard in time (seconds of the clock), or not everything that a
            mission needs to begin.
    """
    try:
        _drive(companion, link, clock, timeout_s, beat, reports)
    finally:
        abandon_all()
        gc.unfreeze()  # the garbage collection at exit covers everything again


def _drive(
    companion: Companion,
    link: Link,
    clock: ScaledClock,
    timeout_s: float,
    beat: Callable[[], None],
    reports: ReportPort | None,
) -> None:
    companion.wire.time.zero_s = clock.zero_s
    told_speed = clock.speed
    begun_s = next_tick_s = now_s = clock.now_s()
    was_flying, is_tick = False, True
    while not companion.has_ended:
        beat()
        heard: list[bytes] = []
        may_answer = is_tick or companion.is_idle
        is_tick = not (may_answer and _hears(companion, link, clock, next_tick_s, heard))
        if is_tick:
            clock.sleep_until(next_tick_s)
        now_s = _step(companion, link, clock, heard, is_tick, now_s, reports)
        told_speed = _keep_pace(companion, clock, told_speed)
        if now_s - begun_s > timeout_s and (missing := companion.missing) is not None:
            raise _timed_out(link, timeout_s, missing)
        is_flying = companion.system_status is not SystemStatus.STANDBY
        if is_flying and not was_flying:
            _set_aside()
        was_flying = is_flying
        if is_tick and now_s > next_tick_s + TICK_S:
            log.debug("tick %.0f ms late", 1000 * (now_s - next_tick_s))
        if is_tick or now_s > next_tick_s:
            next_tick_s = max(next_tick_s + TICK_S, now_s)


def _timed_out(link: Link, timeout_s: float, missing: str) -> LinkTimeout:
    """No vehicle was heard in time, or not everything that a mission needs to begin."""
    if link.has_heard:
        return LinkTimeout(
            f"the vehicle on {link.endpoint} is not ready after {timeout_s:.0f} s: it tells "
            f"{missing}\n"
            "    an autopilot has a position and a home when its GPS is good, minutes after a cold "
            "start; --timeout waits longer"
        )
    match link.endpoint:
        case SerialPort():
            advice = (
                "    is it the port that the autopilot is wired to, and its speed that of "
                "SER_*_BAUD?\n    companion doctor --connect shows what is heard there"
            )
        case TcpServer():
            advice = "    is a program running there that waits for connections?"
        case _:
            advice = (
                "    PX4 SITL and `sitl` send to port 14540 by themselves; is one running?\n"
                "    QGroundControl must not listen on this port"
            )
    return LinkTimeout(
        f"no vehicle on {link.endpoint} after {timeout_s:.0f} s: {link.account()}\n{advice}"
    )


def _step(
    companion: Companion,
    link: Link,
    clock: ScaledClock,
    heard: list[bytes],
    is_tick: bool,
    stepped_s: float,
    reports: ReportPort | None,
) -> float:
    """One step; in flight, messages from before a pause of this process are not read or sent.

    Args:
        heard: messages that have arrived already.
        stepped_s: when the last step began.
        reports: read in a tick.

    Returns:
        When the step began.
    """
    is_flying = companion.system_status is not SystemStatus.STANDBY
    now_s = clock.now_s()
    arrived = heard + link.receive()
    if is_flying and now_s - stepped_s >= PAUSED_S:
        arrived = []
        link.discard()
    reported = reports.receive() if reports is not None and is_tick else ()
    sent = companion.step(now_s, arrived, is_tick, reported)
    link.send([] if is_flying and clock.now_s() - now_s >= PAUSED_S else sent)
    companion.note(link.news())
    return now_s


def _hears(
    companion: Companion, link: Link, clock: ScaledClock, until_s: float, heard: list[bytes]
) -> bool:
    """Waits until a time for messages that need a step; returns whether any came.

    Args:
        heard: receives all other messages, for the next step.
    """
    while link.wait(clock.wall_s_until(until_s)):
        if companion.is_idle:
            return True
        arrived, now_s = link.receive(), clock.now_s()
        heard += arrived
        if answers := companion.wire.answers(now_s, arrived):
            link.answer(answers)
        if now_s >= until_s or companion.is_urgent(now_s, arrived):
            return now_s < until_s
    return False


def _keep_pace(companion: Companion, clock: ScaledClock, told_speed: float) -> float:
    """Adapts the flight's clock to the autopilot's speed; returns the last reported speed."""
    if (rate := companion.telemetry.clock.rate.take_news()) is None:
        return told_speed
    clock.speed_up(rate)
    companion.wire.time.zero_s = clock.zero_s
    if max(clock.speed / told_speed, told_speed / clock.speed) < NEWS:
        return told_speed
    companion.note([ClockFollowed(round(clock.speed, 2))])
    return clock.speed


def _set_aside() -> None:
    """Excludes existing objects from garbage collection before a flight.

    With 20 sites a collection took 50 ms, which is a tick, once per minute of flight. Before the
    next flight, all objects are collected again.
    """
    gc.unfreeze()
    gc.collect()
    gc.freeze()
