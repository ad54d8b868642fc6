"""One heartbeat of another mode is doubted, and two are believed; the pilot is never overruled."""

from __future__ import annotations

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from companion.vehicle.control_watch import (
    CONTRADICTED_S,
    PAUSED_S,
    ControlState,
    ControlWatch,
)
from companion.vehicle.ports.control import Takeover
from companion.vehicle.ports.state import Heartbeat, Mode

OURS, DOUBTED, LOST = ControlState
FLOWN = Heartbeat(Mode.OFFBOARD, is_armed=True, is_failsafe=False, received_s=0.0)
PILOT = Heartbeat(Mode.POSCTL, is_armed=True, is_failsafe=False, received_s=0.0)
FAILSAFE = Heartbeat(Mode.LOITER, is_armed=True, is_failsafe=True, received_s=0.0)
DISARMED = Heartbeat(Mode.LOITER, is_armed=False, is_failsafe=True, received_s=0.0)


def hear(watch: ControlWatch, time_s: float, heartbeat: Heartbeat, *, is_our_mode: bool) -> None:
    watch.take(replace(heartbeat, received_s=time_s), is_our_mode)


def states(*heard: tuple[float, Heartbeat]) -> list[ControlState]:
    """The state after each heartbeat, in OFFBOARD."""
    watch, found = ControlWatch(), []
    for time_s, heartbeat in heard:
        hear(watch, time_s, heartbeat, is_our_mode=heartbeat.mode is Mode.OFFBOARD)
        found.append(watch.state)
        assert (watch.takeover is None) is (watch.state is not LOST)
    return found


def test_the_second_in_a_row_takes_control() -> None:
    assert states((0, FLOWN), (1, PILOT), (2, PILOT), (3, FLOWN)) == [OURS, DOUBTED, LOST, LOST]


def test_two_are_in_a_row_whatever_modes_they_show() -> None:
    assert states((0, PILOT), (0.1, DISARMED)) == [DOUBTED, LOST]


def test_a_failsafe_of_an_armed_vehicle_needs_no_second() -> None:
    assert states((0, FAILSAFE)) == [LOST]
    assert states((0, DISARMED)) == [DOUBTED]


def test_a_failsafe_in_our_own_mode_is_none_that_takes_control() -> None:
    """A low battery is told so, in any mode."""
    assert states(
        (0, Heartbeat(Mode.OFFBOARD, is_armed=True, is_failsafe=True, received_s=0.0))
    ) == [OURS]


@pytest.mark.parametrize(
    ("after_s", "state"), [(0.01, OURS), (CONTRADICTED_S, OURS), (CONTRADICTED_S + 0.01, LOST)]
)
def test_only_one_who_speaks_too_early_is_contradicted(after_s: float, state: ControlState) -> None:
    """What comes a second later may be the same autopilot, whose pilot has come and gone."""
    assert states((0, PILOT), (after_s, FLOWN)) == [DOUBTED, state]


def test_a_disarming_contradicts_nothing() -> None:
    """The pilot has landed it within the second, and it has fallen back to a mode of ours."""
    landed = replace(FLOWN, is_armed=False)
    assert states((0, FLOWN), (1, PILOT), (1.5, landed)) == [OURS, DOUBTED, LOST]
    assert states((0, landed), (1, PILOT), (1.5, landed)) == [OURS, DOUBTED, OURS]


def test_each_doubt_is_a_new_one() -> None:
    heard = [(0.0, PILOT), (0.5, FLOWN), (1.4, PILOT), (1.5, FLOWN)]
    assert states(*heard) == [DOUBTED, OURS, DOUBTED, OURS]


def test_it_is_told_who_has_control() -> None:
    watch = ControlWatch()
    hear(watch, 0.0, PILOT, is_our_mode=False)
    hear(watch, 2.0, FLOWN, is_our_mode=True)
    assert watch.takeover == Takeover(Mode.POSCTL, is_failsafe=False)
    watch.regain()
    hear(watch, 3.0, FAILSAFE, is_our_mode=False)
    assert watch.takeover == Takeover(Mode.LOITER, is_failsafe=True)


def test_what_is_settled_is_not_what_is_lost() -> None:
    watch = ControlWatch()
    hear(watch, 0.0, PILOT, is_our_mode=False)
    watch.settle()
    assert watch.state is OURS
    hear(watch, 0.1, PILOT, is_our_mode=False)
    assert watch.state is DOUBTED
    hear(watch, 0.2, PILOT, is_our_mode=False)
    watch.settle()
    assert watch.state is LOST
    watch.regain()
    assert watch.state is OURS and watch.takeover is None


@given(st.lists(st.sampled_from([FLOWN, PILOT, FAILSAFE, DISARMED])))
def test_a_pilot_who_stays_has_control_with_the_second_heartbeat(before: list[Heartbeat]) -> None:
    """Whatever was heard, once a second, before."""
    heard = list(enumerate([*before, PILOT, PILOT]))
    found = states(*heard)
    assert found[-1] is LOST
    assert found[-2] is not OURS  # and nothing is sent after the first


@pytest.mark.parametrize(
    ("heard", "state"), [(FLOWN, OURS), (PILOT, DOUBTED), (FAILSAFE, LOST), (DISARMED, DOUBTED)]
)
def test_after_a_pause_of_ours_the_next_heartbeat_counts_as_the_first(
    heard: Heartbeat, state: ControlState
) -> None:
    watch = ControlWatch()
    watch.step(100.0)
    hear(watch, 100.0, FLOWN, is_our_mode=True)
    watch.step(100.0 + PAUSED_S)
    assert watch.state is DOUBTED and watch.takeover is None
    watch.step(101.0)
    assert watch.state is DOUBTED
    hear(watch, 101.0, heard, is_our_mode=heard is FLOWN)
    assert watch.state is state


def test_late_ticks_are_no_pause_and_neither_is_the_beginning() -> None:
    watch = ControlWatch()
    for time_s in (1e6, 1e6 + PAUSED_S - 0.01, 1e6 + 1.8 * PAUSED_S):
        watch.step(time_s)
        assert watch.state is OURS


def test_after_a_pause_of_this_program_the_mode_is_heard_first() -> None:
    """At the limit, which is below the second after which PX4 misses its setpoints."""
    assert 0.5 <= PAUSED_S < 1.0
    for pause_s, state in ((PAUSED_S - 0.125, OURS), (PAUSED_S, DOUBTED)):
        watch = ControlWatch()
        watch.step(0.0)
        watch.step(pause_s)
        assert watch.state is state and watch.takeover is None


def test_before_any_heartbeat_no_disarming_is_told() -> None:
    on_the_ground = replace(FLOWN, is_armed=False)
    assert states((0, PILOT), (0.5, on_the_ground)) == [DOUBTED, OURS]
