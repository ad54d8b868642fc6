"""Ports for tests that need real ones: the simulator's of an instance that nobody runs here.

No two of the instances share a port, and two test runs on a machine hardly choose the same one.
"""

from __future__ import annotations

import contextlib
import random
import socket

from sitl.link.server import PORTS

INSTANCES = [tens + one for tens in (30, 80, 130, 180) for one in range(10)]
"""The ports of an instance lie 10, 30 and 40 apart, and so those of others might."""


def free_instance() -> int:
    """An instance whose four UDP ports are free on this machine."""
    for instance in random.SystemRandom().sample(INSTANCES, len(INSTANCES)):
        with contextlib.ExitStack() as stack:
            try:
                for base in (port for pair in PORTS.values() for port in pair):
                    udp = stack.enter_context(socket.socket(socket.AF_INET, socket.SOCK_DGRAM))
                    udp.bind(("127.0.0.1", base + instance))
            except OSError:
                continue
            return instance
    raise AssertionError("no free ports")
