"""Flies over a link, by the clock: on PX4, or on any simulator of it."""

from __future__ import annotations

from contextlib import closing

from companion.app import Companion
from companion.clock import ScaledClock
from companion.driving import fly
from companion.flights.front_end import FrontEnd
from companion.flights.options import LinkOptions
from companion.vehicle.report_port import reports_at


def fly_over_link(
    companion: Companion, options: LinkOptions, front_end: FrontEnd, begin_s: float = 0.0
) -> None:
    """Opens the link and the port for reports, and flies until the companion has ended.

    How the flight ended is `companion.failure`.

    Args:
        companion: the companion to run.
        options: the link to its vehicle.
        front_end: the program around the flight.
        begin_s: what the flight's clock shows at the start.

    Raises:
        LinkError: the link, or the port for reports, cannot be opened; or no vehicle was heard in
            time.
    """
    with reports_at(options.events) as reports, closing(options.open()) as link:
        front_end.say(f"waiting    for a vehicle on {link.endpoint}")
        clock = ScaledClock(options.speed, begin_s=begin_s)
        with front_end.attending(companion) as beat:
            fly(companion, link, clock, options.timeout_s, beat, reports)
