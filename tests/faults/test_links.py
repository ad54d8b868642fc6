"""Links that lose, double, delay and reorder: the same actions, and each command once."""

from __future__ import annotations

import pytest
from campaign import actions, fly, modes, sweep, undisturbed
from lockstep import PAYLOAD, AllButFinalAnswers, Deaf, Lockstep, Lossy

from companion.errors import Aborted
from companion.flight_events.skills import PlaceReached, SkillCompleted
from companion.flight_events.sortie import RunFailed, SetpointRefused
from sitl.results import MavResult
from sitl.world.payload import REPEATED_WITHIN_S

pytestmark = pytest.mark.faults

SURVEILLANCE, PATROL = "surveillance", "persistent_patrol"
SHARES = (0.05, 0.1, 0.2, 0.3)
SEEDS = range(10)


def assert_flown_as_without(flight: Lockstep, mission: str) -> None:
    """The same actions; every command of ours has had its effect once."""
    expected = undisturbed(mission)
    assert actions(flight) == actions(expected)
    assert modes(flight) == modes(expected)
    assert flight.armings == expected.armings
    assert final_answers(flight) == final_answers(expected)
    assert flight.simulation.collisions == 0


def final_answers(flight: Lockstep) -> list[int]:
    """Of the payload: one for each time that it did something.

    The same soon after is the same answer again, to a command that came again.
    """
    final = [
        said
        for said in flight.acknowledged
        if said.message.get_srcComponent() == PAYLOAD
        and said.message.result != MavResult.IN_PROGRESS
    ]
    return [
        said.message.result
        for before, said in zip([None, *final], final, strict=False)
        if before is None or said.time_s - before.time_s > REPEATED_WITHIN_S
    ]


@pytest.mark.parametrize(
    ("share", "seed"),
    sweep(SHARES, SEEDS, few=lambda share, seed: seed == 0 and share == 0.3),
)
def test_loss_with_a_payload(share: float, seed: int) -> None:
    """Its final answers pass: the command protocol sends them once, and a lost one is a failure."""
    up, down = AllButFinalAnswers(Lossy(share, seed)), Lossy(share, 100 + seed)
    assert_flown_as_without(fly(SURVEILLANCE, seed=seed, up=up, down=down), SURVEILLANCE)


@pytest.mark.parametrize(("share", "seed"), sweep(SHARES, SEEDS, few=lambda *_: False))
def test_loss_with_three_landings(share: float, seed: int) -> None:
    """The flight takes longer, and the battery is told late: one site more may come before either.

    The order of the sites is the mission's, as are the three landings and the end.
    """
    flight = fly(PATROL, {"at_s": 0, "link": {"port": "companion", "loss": share}}, seed=seed)
    expected = undisturbed(PATROL)
    assert sites(flight) == ("ABC" * 5)[: len(sites(flight))]
    assert abs(len(sites(flight)) - len(sites(expected))) <= 1
    assert len(flight.of(SkillCompleted)) == len(expected.of(SkillCompleted)) == 3
    assert flight.ending == expected.ending
    assert modes(flight) == modes(expected)
    assert flight.armings == expected.armings
    assert flight.simulation.collisions == 0


def sites(flight: Lockstep) -> str:
    """Those of the patrol that were reached, in order."""
    return "".join(e.place for e in flight.of(PlaceReached) if e.place != "Home")


@pytest.mark.parametrize(
    ("mission", "seed"),
    sweep((SURVEILLANCE, PATROL), SEEDS, few=lambda name, seed: False),
)
def test_jitter_reorders_and_datagrams_come_twice(mission: str, seed: int) -> None:
    shaken = {"at_s": 0, "link": {"port": "companion", "doubled": 0.2, "jitter_s": 0.2}}
    assert_flown_as_without(fly(mission, shaken, seed=seed), mission)


def test_a_blackout_of_three_seconds_ends_the_run_with_the_failsafe() -> None:
    """PX4 holds 1 s after the last setpoint; what is heard then is a failsafe that has control."""
    cut = {"at_s": 10, "link": {"port": "companion", "loss": 1}}
    flight = fly(SURVEILLANCE, cut, {"at_s": 13, "link": {}})
    why = "a failsafe of the autopilot has control, in AUTO.LOITER"
    assert flight.ending == RunFailed(why, Aborted.exit_code)
    assert flight.now_s == pytest.approx(13.0, abs=0.3)
    assert flight.simulation.mode == "AUTO.LOITER"


TIMESYNC = 111
OLD = {"at_s": 15, "link": {"port": "companion", "direction": "from_vehicle", "delay_s": 0.8}}


def test_a_link_that_buffers_makes_positions_old() -> None:
    """For four seconds all comes 0.8 s late: it is held as long, and flown as without."""
    flight = fly(SURVEILLANCE, OLD, {"at_s": 19, "link": {}})
    held_s = [
        said.time_s
        for said in flight.setpoints
        if (said.message.vx, said.message.vy, said.message.vz) == (0.0, 0.0, 0.0)
        and 15.9 < said.time_s < 19.0
    ]
    assert len(held_s) == len([s for s in flight.setpoints if 15.9 < s.time_s < 19.0]) > 50
    (refused,) = flight.of(SetpointRefused)
    assert refused.reason == "the position is 0.5 s old"
    assert actions(flight) == actions(undisturbed(SURVEILLANCE))


@pytest.mark.long
def test_an_autopilot_that_does_not_tell_its_time_is_heard_when_it_arrives() -> None:
    deaf = Deaf(TIMESYNC)
    deaf.is_deaf = True
    flight = fly(SURVEILLANCE, OLD, {"at_s": 19, "link": {}}, up=deaf)
    moving = [s for s in flight.setpoints if 16.5 < s.time_s < 19.0 and abs(s.message.vx) > 0.1]
    assert moving != []
    assert actions(flight) == actions(undisturbed(SURVEILLANCE))
