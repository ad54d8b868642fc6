"""Ports for tests that need real ones: the simulator's of an instance that nobody runs here."""

from __future__ import annotations

import contextlib
import socket

from sitl.link.server import PORTS


def free_instance() -> int:
    """The first instance, from 30 on, whose four UDP ports are free on this machine."""
    for instance in range(30, 200):
        with contextlib.ExitStack() as stack:
            try:
                for base in (port for pair in PORTS.values() for port in pair):
                    udp = stack.enter_context(socket.socket(socket.AF_INET, socket.SOCK_DGRAM))
                    udp.bind(("127.0.0.1", base + instance))
            except OSError:
                continue
            return instance
    raise AssertionError("no free ports")
