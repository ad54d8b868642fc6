"""Ends a flight by signals of its process."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from types import FrameType
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from companion.app import Companion


@contextmanager
def stopped_by(
    signals: Sequence[signal.Signals], companion: Companion, on_stop: Callable[[], None]
) -> Iterator[None]:
    """While the context lasts, the first signal makes the companion hold, land and end.

    The second one raises KeyboardInterrupt, which leaves the vehicle to the autopilot's failsafe.
    Only the main thread of a program gets signals; in another thread nothing changes.

    Args:
        signals: such as SIGINT, which is Ctrl-C.
        companion: it is stopped.
        on_stop: called when it was told to stop.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return

    def stop(number: int, _: FrameType | None) -> None:
        signal.signal(number, signal.default_int_handler)  # before `on_stop` promises it
        companion.stop()
        on_stop()

    before = {number: signal.signal(number, stop) for number in signals}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
