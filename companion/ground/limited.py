"""A command of this program as a child process that cannot do much harm, whatever it reads.

    python -m companion.ground.limited FOLDER ARGUMENT ...

runs `companion ARGUMENT ...` in a folder, with bounds on memory, processor time and the size of
files, and yields to the process that flies. The bounds are set before anything is read.
"""

from __future__ import annotations

import os
import resource
import runpy
import sys

MAX_MEMORY_BYTES = 2 << 30  # address space; numpy and scipy map 0.5 GiB by being imported
MAX_CPU_S = 30
MAX_OUTPUT_BYTES = 1 << 20
NICENESS = 10


def main() -> None:
    """Entry point."""
    limits = {
        resource.RLIMIT_AS: MAX_MEMORY_BYTES,
        resource.RLIMIT_CPU: MAX_CPU_S,
        resource.RLIMIT_FSIZE: MAX_OUTPUT_BYTES,
        resource.RLIMIT_CORE: 0,
    }
    for what, limit in limits.items():
        resource.setrlimit(what, (limit, limit))
    os.nice(NICENESS)
    folder, *arguments = sys.argv[1:]
    os.chdir(folder)  # the module search path stays as it was: nothing is imported from there
    sys.argv = ["companion", *arguments]
    runpy.run_module("companion", run_name="__main__")


if __name__ == "__main__":
    main()
