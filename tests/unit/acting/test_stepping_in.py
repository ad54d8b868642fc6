"""An operator steps in: pause, go on, go home; and who may give control back when."""

from __future__ import annotations

import math
from itertools import product
from typing import Any

import pytest
from sortie_rig import SortieRig
from states import changed, flying
from synthetic import mission

from companion.acting.sortie.authority import FRESH_S, not_handed_over
from companion.acting.sortie.operator_requests import ON_THE_GROUND_BY_PLAN
from companion.errors import Aborted
from companion.flight_events.plans import NoPlanFound, PlanReplaced
from companion.flight_events.sortie import (
    ControlRegained,
    ControlTakenBack,
    ControlYielded,
    Phase,
    ReturnFailed,
    RunFailed,
)
from companion.mission.places import Limits
from companion.outcomes import Refusal
from companion.tick import TICK_S
from companion.vehicle.ports.control import Takeover
from companion.vehicle.ports.goals import Goal
from companion.vehicle.ports.state import MODE_KNOWN_S, Mode

LIMITS = Limits(2.0, (0.5, 4.0), ((-9.0, -9.0), (-9.0, 9.0), (9.0, 9.0), (9.0, -9.0)))


def patrol(may_yield: bool = True) -> SortieRig:
    return SortieRig(mission("G F at(A) & G F at(B)"), may_yield=may_yield)


@pytest.fixture
def flown() -> SortieRig:
    return patrol().until(Phase.TASK).run(1.5)


def test_a_pause_freezes_the_task(flown: SortieRig) -> None:
    assert flown.sortie.pause() is None
    flown.run(3.0)
    held, positions = flown.position, flown.rig.task.word.positions
    flown.run(30.0)
    assert math.dist(flown.position, held) < 1e-6
    assert flown.rig.task.word.positions == positions
    assert flown.sortie.resume() is None
    flown.run(20.0)
    assert flown.rig.task.word.positions > positions
    assert {"A", "B"} <= set(flown.places)


@pytest.mark.parametrize("phase", [p for p in Phase if p not in (Phase.TASK, Phase.RETURNING)])
def test_what_is_possible_in_which_phase(phase: Phase) -> None:
    """In every phase each wish is granted, or refused with a reason that names the phase."""
    sortie = patrol().sortie
    sortie.phase = phase
    can_pause, can_return = phase is Phase.PAUSED, phase in (Phase.PAUSED, Phase.LANDING)
    assert (sortie.pause() is None) is can_pause
    if not can_pause:
        assert phase.value in reason(sortie.pause())
        assert phase is Phase.YIELDED or phase.value in reason(sortie.resume())
    if not can_return:
        assert phase.value in reason(sortie.return_home())
    assert sortie.phase is phase
    assert (sortie.return_home() is None) is can_return


def reason(refusal: Refusal | None) -> str:
    assert refusal is not None
    return refusal.reason


def test_nothing_interrupts_a_vehicle_on_the_ground_by_its_plan(flown: SortieRig) -> None:
    flown.rig.flight.progress.take_to_ground()
    assert flown.sortie.pause() == flown.sortie.return_home() == ON_THE_GROUND_BY_PLAN
    assert flown.sortie.phase is Phase.TASK


def test_a_return_that_finds_no_way_lands_where_it_is(flown: SortieRig) -> None:
    flown.vehicle.is_stuck = True
    assert flown.sortie.return_home() is None
    flown.until(Phase.ENDED)
    assert flown.vehicle.pursued[-2:] == [Goal.HOLDING, Goal.LANDED]
    failed = flown.one(ReturnFailed)
    assert (failed.place, failed.reason) == ("H", "stuck on the way to H")
    assert flown.events[-1] == RunFailed(failed.text, Aborted.exit_code)
    assert flown.sortie.failure is not None and flown.sortie.failure.exit_code == 5


def test_a_return_is_not_left_for_the_task(flown: SortieRig) -> None:
    assert flown.sortie.return_home() is None
    flown.rig.executive.deliberation.assumptions.note_restored_beliefs()
    flown.until(Phase.ENDED)
    assert math.dist(flown.position[:2], (0.0, 0.0)) < 0.3
    assert not flown.of(PlanReplaced) and not flown.of(NoPlanFound)


# -- whose it is -----------------------------------------------------------------------------------


def take_over(flown: SortieRig, mode: Mode) -> None:
    flown.vehicle.change(mode=mode)
    flown.vehicle.control.takeover = Takeover(mode, is_failsafe=False)
    flown.run(TICK_S)


def test_nothing_is_sent_while_the_pilot_flies(flown: SortieRig) -> None:
    take_over(flown, Mode.POSCTL)
    assert flown.sortie.phase is Phase.YIELDED
    assert flown.one(ControlYielded).loss == "the pilot has control, in POSCTL"
    flown_before, sent = len(flown.vehicle.flown), len(flown.vehicle.pursued)
    flown.run(60.0)
    assert (len(flown.vehicle.flown), len(flown.vehicle.pursued)) == (
        flown_before,
        sent,
    )
    assert flown.vehicle.setpoint is None


def test_an_autopilot_that_restarts_while_the_pilot_flies_ends_the_run(flown: SortieRig) -> None:
    take_over(flown, Mode.POSCTL)
    flown.vehicle.goals.has_restarted = True
    flown.run(TICK_S)
    assert flown.failure.reason == "the autopilot has restarted"


def test_given_back_it_holds_where_it_is_and_goes_on(flown: SortieRig) -> None:
    take_over(flown, Mode.POSCTL)
    flown.vehicle.change(position=(3.0, 3.0, -2.5), mode=Mode.LOITER)
    flown.run(1.0)
    assert flown.sortie.resume() is None
    flown.run(TICK_S)
    assert flown.vehicle.setpoint is not None
    assert flown.vehicle.setpoint.position == (3.0, 3.0, -2.5)
    flown.until(Phase.TASK).run(20.0)
    assert ControlRegained() in flown.events
    assert "A" in flown.places


def test_without_somebody_who_may_give_it_back_it_ends() -> None:
    flown = patrol(may_yield=False).until(Phase.TASK).run(1.5)
    take_over(flown, Mode.POSCTL)
    assert flown.sortie.has_ended


def test_it_is_handed_over_only_if_all_is_so() -> None:
    """All combinations: one alone that is wrong, and all of them, is a refusal."""
    good = changed(flying(heard_s=10.0), mode=Mode.LOITER)
    wrong: list[dict[str, Any]] = [
        {"motion_measured_s": 10.0 - FRESH_S - 0.01},
        {"heartbeat_received_s": 10.0 - MODE_KNOWN_S - 0.01},
        {"is_armed": False},
        {"is_landed": True},
        {"is_failsafe": True},
        *({"mode": mode} for mode in Mode if mode is not Mode.LOITER),
    ]
    assert not_handed_over(good, 10.0, False, LIMITS) is None
    assert not_handed_over(None, 10.0, False, LIMITS)
    for one, other in product(wrong, wrong):
        assert not_handed_over(changed(good, **(one | other)), 10.0, False, LIMITS)


def test_a_failsafe_that_only_no_longer_heard_us_is_no_obstacle() -> None:
    held = changed(flying(heard_s=10.0), mode=Mode.LOITER, is_failsafe=True)
    assert not_handed_over(held, 10.0, True, LIMITS) is None
    for mode in Mode:
        if mode is not Mode.LOITER:
            assert not_handed_over(changed(held, mode=mode), 10.0, True, LIMITS)


@pytest.mark.parametrize("is_critical", [False, True])
def test_with_a_critical_battery_no_hold_is_resumed_by_itself(is_critical: bool) -> None:
    """The autopilot holds, as nothing was sent for a second; the key is given beforehand."""
    flown = SortieRig(mission("G F at(A) & G F at(B)"), resumes=True).until(Phase.TASK).run(1.5)
    for _ in range(round(1.0 / TICK_S)):
        flown.rig.pass_time()
    held = {"mode": Mode.LOITER, "is_failsafe": True, "battery_is_critical": is_critical}
    flown.vehicle.change(**held)
    flown.vehicle.control.takeover = Takeover(Mode.LOITER, is_failsafe=True)
    flown.step()
    flown.step()
    assert (flown.of(ControlTakenBack) == []) is is_critical
    assert (flown.sortie.phase is Phase.YIELDED) is is_critical
