"""How the programs start others of their own: with this interpreter, and nothing of the folder.

Without `-P`, Python looks for modules in the working directory first: a file that lies there under
the name of one of ours, in an uploaded folder or a download, would be run.

A child that reads what a stranger has written, or runs a program of others, confines itself first.
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
    """Bounds the memory of this process, and of each that it starts; none leaves a core file.

    Libraries that are mapped from files do not count. Python raises MemoryError at the bound.
    """
    resource.setrlimit(resource.RLIMIT_DATA, (memory_bytes, memory_bytes))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def confine_time(cpu_s: float, grace_s: int = 1) -> None:
    """Bounds the processor time of this process from now on.

    Args:
        cpu_s: by then it gets SIGXCPU; up to a second earlier, as the system counts in seconds.
        grace_s: seconds of processor time more after which it is killed.
    """
    used = resource.getrusage(resource.RUSAGE_SELF)
    last_s = max(1, math.floor(used.ru_utime + used.ru_stime + cpu_s))
    resource.setrlimit(resource.RLIMIT_CPU, (last_s, last_s + grace_s))
