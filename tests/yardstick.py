"""How much work something takes, in seconds of the machine on which the claims were made.

CPU time of this process, held against that of a fixed piece of work which is done just before. A
slow machine is slow at both, and other programs hardly count, so a claim fails for what the code
does and not for where it runs.
"""

from __future__ import annotations

import time

PIECE_S = 0.0028  # of CPU time for `piece_of_work` on that machine
REPETITIONS = 3


def piece_of_work() -> int:
    """Arithmetic, a dictionary and small sets, as in a search."""
    kept: dict[int, frozenset[int]] = {}
    for i in range(10_000):
        key = (i * 2_654_435_761) & 0xFFFF
        kept[key] = kept.get(key, frozenset()) | {i & 7}
    return len(kept)


class Stopwatch:
    """Runs from the time when it is made."""

    def __init__(self) -> None:
        self._piece_s = min(_cpu_time_of_a_piece_s() for _ in range(REPETITIONS))
        self._start_s = time.process_time()

    def seconds(self) -> float:
        """CPU time so far, as it would be on the machine of the claims."""
        return (time.process_time() - self._start_s) * PIECE_S / self._piece_s


def _cpu_time_of_a_piece_s() -> float:
    start_s = time.process_time()
    piece_of_work()
    return time.process_time() - start_s
