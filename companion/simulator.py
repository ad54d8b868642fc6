"""Runs the bundled simulator as a child process, which uses UDP exactly like a PX4.

It has a session of its own, so Ctrl-C in a terminal reaches only the companion, which first lands
the vehicle and then ends the simulator. The simulator also ends with this process, in any case: its
standard input is then closed.
"""

from __future__ import annotations

import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from companion.errors import Collided, LinkError
from companion.python_child import python_module

START_TIMEOUT_S = 30.0
END_TIMEOUT_S = 5.0


class SimulatorChild:
    """The running simulator.

    Attributes:
        is_damaged: whether its vehicle has hit something; known when the context is left.
    """

    is_damaged = False


@contextmanager
def simulator(options: list[object], log: Path) -> Iterator[SimulatorChild]:
    """Runs `sitl` with some options while the context lasts.

    Args:
        options: as on the command line.
        log: receives its output.

    Raises:
        LinkError: it ended before it had its ports, or did not get them in time.
    """
    with log.open("wb") as output:
        child = subprocess.Popen(
            python_module("sitl", "--attended", *map(str, options)),
            stdout=output,
            stderr=subprocess.STDOUT,
            stdin=subprocess.PIPE,
            start_new_session=True,
        )
    simulated = SimulatorChild()
    try:
        _await_start(child, log)
        yield simulated
    finally:
        child.terminate()
        try:
            child.wait(END_TIMEOUT_S)
        except subprocess.TimeoutExpired:
            child.kill()
            child.wait()
        simulated.is_damaged = child.returncode == Collided.exit_code


def _await_start(child: subprocess.Popen[bytes], log: Path) -> None:
    """Waits until it has its ports; otherwise the vehicle of another simulator would be flown."""
    deadline_s = time.monotonic() + START_TIMEOUT_S
    while "ground station on UDP" not in (said := log.read_text(errors="replace")):
        if child.poll() is not None:
            raise LinkError(f"the simulator did not start\n    {said.strip()}")
        if time.monotonic() > deadline_s:
            raise LinkError(f"the simulator did not start in {START_TIMEOUT_S:.0f} s")
        time.sleep(0.05)
