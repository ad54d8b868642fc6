"""Ports for tests that need real ones: the simulator's of an instance that nobody runs here.

No two of the instances share a port, and two test runs on a machine hardly choose the same one.
"""

from __future__ import annotations

import contextlib
import os
import random
import socket

from sitl.link.server import COMPANION_PORT, GROUND_PORT, LOCAL_PORTS

INSTANCES = [tens + one for tens in (30, 80, 130, 180) for one in range(10)]
"""The ports of an instance lie 10, 30 and 40 apart, and so those of others might."""


def _share() -> list[int]:
    """Those of this process, where pytest runs in several: no two take the same one at once."""
    number = int(os.environ.get("PYTEST_XDIST_WORKER", "gw0").removeprefix("gw"))
    return INSTANCES[number :: int(os.environ.get("PYTEST_XDIST_WORKER_COUNT", "1"))]


def free_instance(besides: int | None = None) -> int:
    """An instance, another than one, whose UDP ports are free here; `own_ports` names them."""
    share = _share()
    for instance in random.SystemRandom().sample(share, len(share)):
        if instance == besides:
            continue
        with contextlib.ExitStack() as stack:
            try:
                for base in (*LOCAL_PORTS.values(), COMPANION_PORT, GROUND_PORT):
                    udp = stack.enter_context(socket.socket(socket.AF_INET, socket.SOCK_DGRAM))
                    udp.bind(("127.0.0.1", base + instance))
            except OSError:
                continue
            return instance
    raise AssertionError("no free ports")


def own_ports(instance: int) -> tuple[str, ...]:
    """Options for a simulator that sends to a ground station of its own, 14550 + instance."""
    return ("-i", str(instance), "--ground-port", str(GROUND_PORT + instance))
