"""Starts programs of our own: with this interpreter, and with nothing from the working directory.

Without `-P`, Python looks for modules in the working directory first. A file there with the name of
one of our modules, from an upload or a download, would be executed.

A child that reads untrusted text, or runs another program, confines itself first.
"""

from __future__ import annotations

import math
import resource
import sys

MIB = 1 << 20


def python_module(module: str, *arguments: str) -> list[str]:
    """The command that runs an installed module.

    >>> python_module("sitl", "--help")[1:]
    ['-P', '-m', 'sitl', '--help']
    """
    return [sys.executable, "-P", "-m", module, *arguments]


def confine_memory(memory_bytes: int) -> None:
    """Limits the memory of this process and its children; none of them writes a core file.

    Libraries that are mapped from files do not count. Python raises MemoryError at the limit.
    """
    resource.setrlimit(resource.RLIMIT_DATA, (memory_bytes, memory_bytes))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def confine_time(cpu_s: float, grace_s: int = 1) -> None:
    """Limits the processor time of this process from now on.

    Args:
        cpu_s: time until SIGXCPU; up to a second less, because the system counts in seconds.
        grace_s: further seconds of processor time until the process is killed.
    """
    used = resource.getrusage(resource.RUSAGE_SELF)
    last_s = max(1, math.floor(used.ru_utime + used.ru_stime + cpu_s))
    resource.setrlimit(resource.RLIMIT_CPU, (last_s, last_s + grace_s))
