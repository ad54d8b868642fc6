"""The first signal asks a companion to land; the second one leaves the vehicle to the autopilot."""

from __future__ import annotations

import signal
import threading
from typing import Any

import pytest

from companion.flights.stopping import stopped_by

SIGNALS = (signal.SIGINT, signal.SIGTERM)


class Asked:
    """A companion, and the program around it, that note what they are asked."""

    def __init__(self) -> None:
        self.asked: list[str] = []

    def stop(self) -> None:
        self.asked.append("stop")

    def on_stop(self) -> None:
        self.asked.append("told")


@pytest.mark.parametrize("number", SIGNALS)
def test_the_first_one_stops_and_the_second_one_interrupts(number: signal.Signals) -> None:
    companion: Any = Asked()
    before = [signal.getsignal(each) for each in SIGNALS]
    with stopped_by(SIGNALS, companion, companion.on_stop):
        signal.raise_signal(number)
        assert companion.asked == ["stop", "told"]
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(number)
    assert companion.asked == ["stop", "told"]
    assert [signal.getsignal(each) for each in SIGNALS] == before


def test_another_thread_has_no_signals() -> None:
    companion: Any = Asked()
    handlers: list[Any] = []

    def fly() -> None:
        with stopped_by(SIGNALS, companion, companion.on_stop):
            handlers.extend(signal.getsignal(each) for each in SIGNALS)

    before = [signal.getsignal(each) for each in SIGNALS]
    thread = threading.Thread(target=fly)
    thread.start()
    thread.join()
    assert handlers == before
