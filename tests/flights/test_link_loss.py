"""What happens when the link fails: silence, loss, jitter, and answers that do not come.

In lockstep, as in test_safety.py.
"""

from __future__ import annotations

from dataclasses import replace

import pytest
from interference import Start, aborted, flown_modes, on_the_way_to_b
from lockstep import (
    PAYLOAD,
    AllButFinalAnswers,
    Cut,
    Jittery,
    Lockstep,
    Lossy,
    Said,
    World,
    is_final_answer,
)

from companion.acting.sortie import authority
from companion.errors import LinkError
from companion.flight_events.facts import BeliefWithdrawn
from companion.flight_events.plans import PlanReplaced
from companion.flight_events.skills import SkillCompleted, SkillFailed
from companion.flight_events.sortie import (
    RunFailed,
    SetpointRefused,
)
from sitl.results import MavResult
from sitl.world.payload import PayloadAnswer, PayloadSite


@pytest.mark.long
def test_a_short_silence_is_not_noticed(start: Start, undisturbed: Lockstep) -> None:
    up, down = Cut(), Cut()
    flight = on_the_way_to_b(start(up=up, down=down))
    up.is_cut = down.is_cut = True
    flight.run(0.4)
    up.is_cut = down.is_cut = False
    flight.until_the_end()
    assert flight.story == undisturbed.story
    assert flown_modes(flight) == flown_modes(undisturbed)


def test_without_telemetry_it_holds_and_then_goes_on(start: Start, undisturbed: Lockstep) -> None:
    up = Cut()
    flight = on_the_way_to_b(start(up=up))
    up.is_cut = True
    flight.run(1.0)
    held = {(s.message.vx, s.message.vy) for s in flight.setpoints[-5:]}
    up.is_cut = False
    flight.until_the_end()
    assert held == {(0.0, 0.0)}
    refused = flight.one(SetpointRefused)
    assert refused.reason in ("the position is 0.5 s old", "the position is 0.6 s old")
    assert [event for event in flight.story if event != refused] == undisturbed.story
    assert flown_modes(flight) == flown_modes(undisturbed)
    assert flight.simulation.collisions == 0


def test_after_an_outage_the_autopilot_keeps_the_vehicle(start: Start) -> None:
    """PX4 would go back to OFFBOARD by itself if setpoints came; the mode is observed first."""
    up, down = Cut(), Cut()
    flight = on_the_way_to_b(start(up=up, down=down))
    up.is_cut = down.is_cut = True
    flight.run(5.0)
    assert flight.simulation.mode == "AUTO.LOITER"
    up.is_cut = down.is_cut = False
    streamed, asked = len(flight.setpoints), len(flight.commands)
    flight.until_the_end()
    flight.run(5.0)
    assert flight.ending == aborted("a failsafe of the autopilot has control, in AUTO.LOITER")
    assert (len(flight.setpoints), len(flight.commands)) == (streamed, asked)
    assert flight.simulation.mode == "AUTO.LOITER"
    assert flight.simulation.collisions == 0


@pytest.mark.long
def test_a_vehicle_that_is_silent_for_ever_ends_the_run(
    start: Start, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It may come back, as long as a battery may last."""
    monkeypatch.setattr(authority, "NEVER_BACK_S", 30.0)
    up = Cut()
    flight = on_the_way_to_b(start(up=up))
    up.is_cut = True
    silent_s = flight.now_s
    flight.until_the_end()
    assert flight.now_s - silent_s == pytest.approx(30.0, abs=0.2)
    assert flight.setpoints[-1].time_s - silent_s == pytest.approx(3.0, abs=0.1)
    assert flight.commands[-1].time_s < silent_s
    assert isinstance(flight.companion.failure, LinkError)
    silence = "no position from the vehicle for 30 s"
    assert flight.ending == RunFailed(silence, LinkError.exit_code)
    assert flight.simulation.mode == "AUTO.LOITER"


@pytest.mark.long
@pytest.mark.parametrize("seed", range(4))
def test_loss_changes_no_action(seed: int, start: Start, undisturbed: Lockstep) -> None:
    """A tenth of all datagrams each way; what is sent only once is the subject of the next test."""
    up = AllButFinalAnswers(Lossy(0.1, seed))
    flight = start(up=up, down=Lossy(0.1, 100 + seed)).until_the_end()
    assert flight.story == undisturbed.story
    assert_each_command_took_effect_once(flight, undisturbed)


@pytest.mark.long
@pytest.mark.parametrize("tells_progress", [False, True])
def test_a_payload_that_needs_twelve_of_fifteen_seconds_is_asked_once(
    start: Start, short_hall: World, tells_progress: bool
) -> None:
    scenario, grid = short_hall
    assert scenario.payload is not None
    slow = PayloadAnswer(MavResult.ACCEPTED, 12.0, tells_progress=tells_progress)
    everywhere = PayloadSite((0.0, 0.0), 100.0, slow)
    world = replace(scenario, payload=replace(scenario.payload, sites=(everywhere,)))
    flight = start((world, grid)).until_the_end()
    assert flight.exit_code == 0
    assert flight.of(SkillFailed) == []
    (asked,) = [s for s in flight.commands if s.message.target_component == PAYLOAD]
    answered_s = payloads_answers(flight)[-1].time_s
    assert answered_s - asked.time_s == pytest.approx(12.0, abs=0.2)
    assert flight.of(SkillCompleted, action="upload(r1)") != []


@pytest.mark.long
def test_a_final_answer_that_is_lost_is_a_failed_upload(start: Start) -> None:
    """The command protocol sends it once. The command is not repeated: it may have taken effect."""
    lost: list[bytes] = []

    def without_the_second(now_s: float, datagrams: list[bytes]) -> list[bytes]:
        lost.extend(d for d in datagrams if is_final_answer(d))
        return [d for d in datagrams if d not in lost[1:2]]

    flight = start(up=without_the_second).until_the_end()
    failed = flight.one(SkillFailed, action="upload(r2)", reason="no final answer in 15 s")
    at = flight.events.index(failed)
    assert flight.events[at + 1] == BeliefWithdrawn("canUpload(r2)")
    replaced = flight.events[at + 2]
    assert isinstance(replaced, PlanReplaced)
    assert (replaced.number, replaced.reason) == (3, failed.text)
    assert replaced.plan.prefix[0].action == "move(r2, r3)"
    assert [answer.message.result for answer in payloads_answers(flight)] == [
        *(MavResult.DENIED, MavResult.ACCEPTED, MavResult.ACCEPTED),
    ]
    assert flight.reports[at].time_s - payloads_answers(flight)[1].time_s < 15.0
    assert flight.exit_code == 0


@pytest.mark.parametrize("seed", [*(pytest.param(n, marks=pytest.mark.long) for n in (0, 1)), 6])
def test_doubled_and_reordered_datagrams_change_no_action(
    seed: int, start: Start, undisturbed: Lockstep
) -> None:
    """Nor is an old heartbeat a pilot: with 6, one comes when OFFBOARD has begun."""
    flight = start(up=Jittery(0.2, seed), down=Jittery(0.2, 100 + seed)).until_the_end()
    assert flight.story == undisturbed.story
    assert_each_command_took_effect_once(flight, undisturbed)


def assert_each_command_took_effect_once(flight: Lockstep, undisturbed: Lockstep) -> None:
    assert flown_modes(flight) == flown_modes(undisturbed)
    assert flight.armings == 1
    answers = [answer.message.result for answer in payloads_answers(flight)]
    assert answers == [MavResult.DENIED, MavResult.ACCEPTED]
    assert flight.simulation.collisions == 0


def payloads_answers(flight: Lockstep) -> list[Said]:
    """Its final answers: one for each time that it did something."""
    return [
        said
        for said in flight.acknowledged
        if said.message.get_srcComponent() == PAYLOAD
        and said.message.result != MavResult.IN_PROGRESS
    ]
