"""An autopilot that has restarted, and stamps that only look like it."""

from __future__ import annotations

import pytest

from companion.vehicle.restart_watch import SURE, RestartWatch

PERIOD_S = 0.05


def heard(*stamps: float) -> RestartWatch:
    """One that has heard an autopilot for a second, and then these."""
    watch = RestartWatch()
    before = [100.0 + PERIOD_S * tick for tick in range(20)]
    for tick, boot_s in enumerate([*before, *stamps]):
        watch.take(PERIOD_S * tick, boot_s)
    return watch


def row(begin_s: float, count: int = SURE) -> list[float]:
    return [begin_s + PERIOD_S * tick for tick in range(count)]


def test_a_clock_that_stays_behind_is_of_another_boot() -> None:
    assert heard(*row(2.0)).restarts == 1
    assert heard(*row(2.0), *row(1.5)).restarts == 1
    assert heard(*row(50.0), *row(2.0)).restarts == 2


@pytest.mark.parametrize(
    "stamps",
    [
        [*row(2.0, SURE - 1), 101.0],
        [2.0, 101.0] * SURE,
        [4e6, 101.0],
        [3.0, 30.0, 60.0, 12.0, 90.0, 45.0],
        row(160.0),
        [*row(160.0), 101.0, 160.2],
        [100.5, 101.0, 100.8] * SURE,
    ],
)
def test_what_is_late_stray_or_after_a_gap_is_no_restart(stamps: list[float]) -> None:
    assert heard(*stamps).restarts == 0


def test_it_is_not_certain_before_it_is_decided_nor_in_a_silence() -> None:
    now_s = PERIOD_S * 20
    assert heard(101.0).is_certain(now_s) and not heard(101.0).is_certain(now_s + 0.6)
    assert not heard(2.0).is_certain(now_s)
    assert heard(*row(2.0)).is_certain(now_s + PERIOD_S * SURE)
    assert not RestartWatch().is_certain(0.0)
