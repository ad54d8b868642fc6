"""The autopilot's own words reach the record of a run, though its link has no ground station."""

from __future__ import annotations

from typing import Any

import pytest
from lockstep import Cut, Lockstep, Lossy
from synthetic import mission

from companion.flight_events.sortie import AutopilotSaid, GoalFailed, Phase, PhaseEntered
from sitl.world.scenario import read_scenario

SHORT = mission("F (at(A) & F at(H))")
LONG = mission("G F at(A) & G F at(H)")
NO_BLADES: dict[str, Any] = {
    "version": 1,
    "happens": [{"at_s": 0, "arming": {"refused": "no blades"}}],
}
SOON = [*NO_BLADES["happens"], {"at_s": 3, "arming": {"allowed": True}}]
REFUSED = "not armed: temporarily rejected (autopilot: no blades)"


@pytest.mark.parametrize("has_station", [False, True], ids=["alone", "beside a station"])
def test_a_refusal_to_arm_is_told_with_its_reason_once(has_station: bool) -> None:
    """With a station the same comes as STATUSTEXT as well."""
    flight = Lockstep(SHORT, read_scenario(NO_BLADES), has_station=has_station).until_the_end()
    assert flight.exit_code == 5
    assert flight.of(GoalFailed)[0].reason == REFUSED
    assert flight.ending.text == REFUSED


@pytest.mark.parametrize("seed", [*(pytest.param(n, marks=pytest.mark.long) for n in (0, 2)), 1])
def test_a_link_that_loses_a_fifth_tells_it_too(seed: int) -> None:
    up, down = Lossy(0.2, seed), Lossy(0.2, seed + 100)
    flight = Lockstep(SHORT, read_scenario(NO_BLADES), up=up, down=down).until_the_end()
    assert flight.ending.text.endswith("(autopilot: no blades)")


def test_what_stood_in_the_way_before_is_not_told() -> None:
    """The reason has changed: the report that is told is the newest."""
    other = {"at_s": 4, "arming": {"refused": "no propellers"}}
    happens = {"version": 1, "happens": [*NO_BLADES["happens"], other]}
    flight = Lockstep(SHORT, read_scenario(happens)).until_the_end()
    assert flight.ending.text.endswith("(autopilot: no propellers; Arming denied: no blades)")


def test_a_warning_in_flight_is_an_event_once() -> None:
    low = {"version": 1, "happens": [{"at_s": 15, "battery": {"charge": 0.12}}]}
    flight = Lockstep(LONG, read_scenario(low), has_station=True)
    flight.until_reported(AutopilotSaid).run(20.0)
    assert [event.words for event in flight.of(AutopilotSaid)].count("Low battery") == 1
    assert flight.time_of(AutopilotSaid, words="Low battery") == pytest.approx(15.0, abs=0.3)


def test_what_was_said_during_a_blackout_is_told_after_it() -> None:
    """No text is sent again, but an event is."""
    way = Cut()
    low = {"at_s": 20, "battery": {"charge": 0.12}}
    flight = Lockstep(LONG, read_scenario({"version": 1, "happens": [*SOON, low]}), up=way)
    flight.run(19.5)
    way.is_cut = True
    flight.run(1.0)
    way.is_cut = False
    flight.until_reported(AutopilotSaid, limit_s=5.0)
    assert flight.of(AutopilotSaid)[0].words == "Low battery"


def test_the_metadata_is_fetched_on_the_ground_alone_and_delays_nothing() -> None:
    world = read_scenario({"version": 1, "happens": SOON})
    flight = Lockstep(SHORT, world).until_the_end()
    files = [s.time_s for s in flight.said if s.message.get_type() == "FILE_TRANSFER_PROTOCOL"]
    assert flight.exit_code == 0
    assert files and max(files) < flight.time_of(PhaseEntered, phase=Phase.TAKE_OFF)
    silent = Lockstep(SHORT, world, up=without_events).until_the_end()
    assert all(s.message.get_type() != "FILE_TRANSFER_PROTOCOL" for s in silent.said)
    assert silent.reports == flight.reports


def without_events(now_s: float, datagrams: list[bytes]) -> list[bytes]:
    """As an autopilot that knows none."""
    return [each for each in datagrams if each[7:10] not in EVENTS]


EVENTS = {number.to_bytes(3, "little") for number in (410, 411)}
