"""The autopilot reboots in flight, its estimate jumps, its battery is not known."""

from __future__ import annotations

from random import Random

import meadow
import pytest
from campaign import actions, begin, shipped, sweep, undisturbed, world
from lockstep import Lockstep
from synthetic import mission

from companion.errors import Aborted
from companion.flight_events.skills import SkillCompleted
from companion.flight_events.sortie import Phase, PhaseEntered, RunEnded, RunFailed, TaskSatisfied
from companion.flights.simulated_world import world_of
from companion.geometry import Ned, distance
from companion.mavlink.framing import dialect
from companion.tick import TICK_S
from companion.vehicle.heard_time import QUIET_S
from companion.vehicle.wire import AUTOPILOT
from companion.vehicle_profile import VehicleProfile
from sitl.world.scenario import read_scenario

pytestmark = pytest.mark.faults

CHARGED_S = 80.0
"""After the first recharge of the patrol."""
SURVEILLANCE, PATROL = "surveillance", "persistent_patrol"
TOLD_WITHIN_S = 3.0
TASK_S, LANDING_S = 5.0, 40.0
"""Within these times the surveillance mission flies its task."""
ROOM = mission("F (at(A) & F (at(B) & F (at(C) & F at(H))))", "HABC")


# -- reboot ----------------------------------------------------------------------------------------


def rebooted_flight(at_s: float, silent_s: float, recovers: bool) -> Lockstep:
    """The surveillance mission until 10 s after the autopilot is heard again."""
    reboot = {"at_s": at_s, "reboot": {"silent_s": silent_s, "recovers": recovers}}
    return Lockstep(shipped(SURVEILLANCE), world(SURVEILLANCE, reboot)).run_for(
        at_s + silent_s + 10.0
    )


@pytest.mark.parametrize("recovers", [pytest.param(True, marks=pytest.mark.long), False])
@pytest.mark.parametrize(
    ("silent_s", "seed"),
    sweep((0.3, 1.0, 3.0, 8.0), range(10), few=lambda silent_s, seed: (silent_s, seed) == (3.0, 0)),
)
def test_a_reboot_during_the_task_ends_the_run(silent_s: float, seed: int, recovers: bool) -> None:
    """Told within 3 s of the first that is heard again; nothing is sent from then on.

    A payload's command may still leave until the silence is noticed, half a second later.
    """
    at_s = Random(f"reboot {seed}").uniform(TASK_S, LANDING_S - 10.0)
    flight = rebooted_flight(at_s, silent_s, recovers)
    heard_s = at_s + silent_s
    assert flight.exit_code == Aborted.exit_code
    told_s = flight.time_of(RunEnded)
    assert told_s <= heard_s + TOLD_WITHIN_S
    after = [c for c in flight.commands if c.time_s > at_s + 0.1]
    assert [c for c in after if c.message.target_component == AUTOPILOT] == []
    assert [c for c in after if c.time_s > at_s + QUIET_S + TICK_S] == []
    assert [s for s in flight.setpoints if s.time_s > told_s] == []
    assert flight.armings == 1


@pytest.mark.parametrize(
    ("phase", "silent_s", "recovers"),
    sweep(
        (Phase.ARMING, Phase.TAKE_OFF, Phase.OFFBOARD, Phase.LANDING),
        (0.3, 3.0),
        (True, False),
        few=lambda phase, silent_s, recovers: (
            phase in (Phase.TAKE_OFF, Phase.OFFBOARD)
            and (silent_s < 1.0) is recovers is (phase is Phase.TAKE_OFF)
        ),
    ),
)
def test_nothing_arms_by_itself_after_a_reboot(
    phase: Phase, silent_s: float, recovers: bool
) -> None:
    at_s = undisturbed(SURVEILLANCE).time_of(PhaseEntered, phase=phase) + 0.5
    flight = rebooted_flight(at_s, silent_s, recovers)
    arming = dialect.MAV_CMD_COMPONENT_ARM_DISARM
    assert [c for c in flight.commands if c.time_s > at_s and c.message.command == arming] == []
    assert flight.armings == 1
    if not recovers:
        assert flight.time_of(RunEnded) <= at_s + silent_s + TOLD_WITHIN_S


@pytest.mark.parametrize(
    ("at_s", "recovers"),
    sweep(
        (16.0, 22.8, 23.2, 30.0, 42.9, 43.3, 45.0, 47.0, 51.0, 55.0),
        (True, False),
        few=lambda at_s, recovers: not recovers and at_s == 23.2,
    ),
    ids=str,
)
def test_what_has_restarted_while_the_plan_has_it_on_the_ground_is_not_armed_again(
    at_s: float, recovers: bool
) -> None:
    """Down to A, standing there, up again, and landing at the end: it fell, or nobody knows."""
    mission = meadow.stay("land()", "wait(20)", "take_off()")
    reboot = {"at_s": at_s, "reboot": {"silent_s": 3.0, "recovers": recovers}}
    flight = Lockstep(mission, world_of(mission, {"version": 1, "happens": [reboot]}))
    flight.run(at_s)
    armings = flight.armings
    flight.run(30.0)
    assert flight.ending == RunFailed("the autopilot has restarted", Aborted.exit_code)
    assert flight.time_of(RunEnded) <= at_s + 3.0 + TOLD_WITHIN_S
    assert flight.armings == armings
    heard_s = at_s + 3.0 + TICK_S  # a command without an answer may be sent again just before
    assert [c for c in flight.commands if c.time_s > heard_s] == []


# -- estimate --------------------------------------------------------------------------------------


def jump(seed: int) -> Ned:
    """A step of the estimate: up to 1 m to each side, and half a metre up or down."""
    chance = Random(f"jump {seed}")
    return (chance.uniform(-1, 1), chance.uniform(-1, 1), chance.uniform(-0.5, 0.5))


@pytest.mark.parametrize("seed", sweep(range(30), few=lambda seed: seed < 1))
def test_a_jump_of_the_estimate_changes_no_action(seed: int) -> None:
    """In an empty room: each place is reached as estimated, and no setpoint is far from there."""
    north_m, east_m, up_m = jump(seed)
    at_s = Random(f"when {seed}").uniform(6.0, 20.0)
    off = {"at_s": at_s, "estimate": {"north_m": north_m, "east_m": east_m, "up_m": up_m}}
    flight = Lockstep(ROOM, read_scenario({"version": 1, "happens": [off]}), seed=seed)
    positions: dict[float, Ned] = {}
    while not flight.companion.has_ended:
        flight.tick()
        positions[flight.now_s] = flight.simulation._vehicle.state.position
    assert flight.ending == TaskSatisfied()
    assert flight.places == ["A", "B", "C", "H"]
    farthest_m = VehicleProfile().carrot_m
    for said in flight.setpoints:
        sent = (said.message.x, said.message.y, said.message.z)
        assert distance(sent, positions[said.time_s]) < farthest_m + 0.2


# -- battery ---------------------------------------------------------------------------------------


@pytest.mark.long
def test_a_battery_that_is_not_known_is_neither_full_nor_empty() -> None:
    """The patrol recharges below 30 %, at first after half a minute: not for -1 %."""
    unknown = {"at_s": 3, "battery": {"known": False}}
    flight = begin(PATROL, unknown, {"at_s": 20, "battery": {"known": True}}).run_for(CHARGED_S)
    assert [e for e in actions(flight) if isinstance(e, SkillCompleted) and "recharge" in e.action]
    assert actions(flight) == actions(begin(PATROL).run_for(CHARGED_S))
