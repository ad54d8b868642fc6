"""Faults of a scenario, as a client sees them: links, answers, reboots, jumps, no gauge."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from random import Random

import pytest
from hypothesis import given
from hypothesis import strategies as st
from wire import NAN, Wire, gcs_heartbeat

from companion.mavlink.framing import dialect
from sitl.link.disturbance import Disturbance
from sitl.link.routing import LinkName
from sitl.results import MavResult
from sitl.world.faults import ANSWERS, Answer, Direction, LinkQuality, Port
from sitl.world.scenario import parse_scenario

ARM = "MAV_CMD_COMPONENT_ARM_DISARM"
NO_CURRENT, NO_VOLTAGE = -1, 65535


def fly(*events: str, link: LinkName = LinkName.OFFBOARD) -> Wire:
    """A world without walls in which something happens."""
    text = "version: 1\nhappens:\n" + "".join(f"  - {{{event}}}\n" for event in events)
    return Wire(parse_scenario(text, Path("missions/a.sim.yaml")), link=link)


def hover(wire: Wire, up_m: float = 3.0) -> None:
    altitude_m = wire.simulation._vehicle.origin.altitude_m + up_m
    wire.command(dialect.MAV_CMD_NAV_TAKEOFF, 0, 0, 0, NAN, NAN, NAN, altitude_m)
    assert wire.arm() == [MavResult.ACCEPTED]
    wire.run_until(lambda: wire.simulation.flight.position[2] < 0.3 - up_m, 20.0)


# -- links -----------------------------------------------------------------------------------------


def test_a_cut_link_says_and_hears_nothing_until_it_is_mended() -> None:
    wire = fly("at_s: 1, link: {port: companion, loss: 1}", "at_s: 3, link: {}")
    wire.run(1.1)
    before = len(wire.heard)
    assert wire.arm() == []
    wire.run(1.8)
    assert [heard for heard in wire.heard[before:] if heard.link is wire.link] == []
    assert not wire.simulation.is_armed
    assert len(wire.named("ATTITUDE", LinkName.GCS)) > 100  # the other port is as it was
    wire.run(0.2)
    assert wire.arm() == [MavResult.ACCEPTED]


def test_a_link_may_be_cut_in_one_direction() -> None:
    wire = fly("at_s: 1, link: {port: companion, direction: from_vehicle, loss: 1}")
    wire.run(1.1)
    assert wire.arm() == []
    assert wire.simulation.is_armed


def test_a_delay_is_the_same_for_all_and_nothing_overtakes() -> None:
    wire = fly("at_s: 1, link: {port: companion, delay_s: 0.5}")
    wire.run(3.0)
    late = [h for h in wire.named("ATTITUDE") if h.time_s > 1.1]
    delays = [h.time_s - h.message.time_boot_ms / 1e3 for h in late]
    assert min(delays) == pytest.approx(0.5, abs=0.01)
    assert max(delays) == pytest.approx(0.5, abs=0.01)


@given(
    st.builds(
        LinkQuality,
        loss=st.floats(0, 1),
        doubled=st.floats(0, 1),
        delay_s=st.floats(0, 1),
        jitter_s=st.floats(0, 1),
    ),
    st.integers(0, 9),
)
def test_what_arrives_was_sent_and_came_in_its_time(quality: LinkQuality, seed: int) -> None:
    port, direction = Port.COMPANION, Direction.TO_VEHICLE
    fates = []
    for _ in range(2):
        lane = Disturbance(direction, {(port, direction): quality}, seed)
        sent_s: dict[bytes, float] = {}
        arrivals: list[tuple[float, bytes]] = []
        for tick in range(80):
            now_s = 0.05 * tick
            sent = [(LinkName.OFFBOARD, bytes([tick]))] if tick < 30 else []
            sent_s |= {datagram: now_s for _, datagram in sent}
            arrivals += [(now_s, datagram) for _, datagram in lane.step(now_s, sent)]
        fates.append(arrivals)
        delays = [now_s - sent_s[datagram] for now_s, datagram in arrivals]
        assert all(
            quality.delay_s - 1e-6 <= each <= quality.delay_s + quality.jitter_s + 0.051
            for each in delays
        )
        assert max(Counter(datagram for _, datagram in arrivals).values(), default=0) <= 2
    assert fates[0] == fates[1]


def test_the_shares_of_loss_and_of_doubles_are_those_of_the_scenario() -> None:
    port, direction = Port.GROUND, Direction.FROM_VEHICLE
    lane = Disturbance(direction, {(port, direction): LinkQuality(loss=0.3, doubled=0.2)}, 7)
    arrived = lane.step(0.0, [(LinkName.GCS, b"")] * 20_000)
    assert len(arrived) == pytest.approx(20_000 * 0.7 * 1.2, rel=0.02)


def test_a_good_link_hands_on_the_same_datagrams_and_draws_nothing() -> None:
    state = Random("link 3 companion to_vehicle").getstate()
    lane = Disturbance(Direction.TO_VEHICLE, {}, 3)
    datagrams = [(LinkName.OFFBOARD, b"x")]
    assert lane.step(0.0, datagrams) is datagrams
    assert lane._chances[Port.COMPANION].getstate() == state


# -- answers ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "answer",
    [
        pytest.param(answer, marks=[pytest.mark.long] if number % 3 else [])
        for number, answer in enumerate(Answer)
    ],
)
def test_every_answer_and_its_effect(answer: Answer) -> None:
    wire = fly(f"at_s: 0, answer: {{command: {ARM}, answer: {answer}}}")
    wire.run(0.1)
    wire.arm()
    wire.run(3.0)
    results = [heard.message.result for heard in wire.named("COMMAND_ACK")]
    assert results == [result for _, result in ANSWERS[answer].results]
    assert wire.simulation.is_armed is ANSWERS[answer].has_effect


def test_an_answer_ends_when_the_scenario_says_so() -> None:
    wire = fly(
        f"at_s: 0, answer: {{command: {ARM}, answer: DENIED}}",
        f"at_s: 1, answer: {{command: {ARM}}}",
    )
    wire.run(0.5)
    assert wire.arm() == [MavResult.DENIED]
    wire.run(1.0)
    assert wire.arm() == [MavResult.ACCEPTED]


# -- the autopilot ---------------------------------------------------------------------------------


def test_a_reboot_in_the_air_stops_the_motors_and_the_vehicle_falls() -> None:
    wire = fly("at_s: 12, reboot: {silent_s: 3}")
    hover(wire)
    wire.run(12.0 - wire.now_s)
    before = len(wire.heard)
    wire.run(2.9)
    assert wire.heard[before + 20 :] == []
    assert wire.simulation.flight.position[2] > -0.1
    wire.run(1.0)
    assert wire.last("ATTITUDE").time_boot_ms == pytest.approx(3900, abs=20)
    assert not wire.simulation.is_armed


def test_a_vehicle_that_recovers_holds_and_has_lost_streams_but_no_parameter() -> None:
    wire = fly("at_s: 12, reboot: {silent_s: 2, recovers: true}", link=LinkName.GCS)
    wire.send(gcs_heartbeat())
    name = b"COM_OF_LOSS_T"
    wire.send(dialect.MAVLink_param_set_message(1, 1, name, 0.7, 9))
    vfr = dialect.MAVLINK_MSG_ID_VFR_HUD
    assert wire.command(dialect.MAV_CMD_SET_MESSAGE_INTERVAL, vfr, -1) == [MavResult.ACCEPTED]
    hover(wire)
    wire.run(10.0 - wire.now_s)
    there = wire.simulation.flight.position
    wire.run(15.0 - wire.now_s)
    assert wire.simulation.is_armed and wire.simulation.mode == "AUTO.LOITER"
    assert wire.simulation.flight.position[2] < -1.0
    assert wire.simulation.flight.position[:2] == pytest.approx(there[:2], abs=0.3)
    wire.run(2.0)
    assert wire.named("VFR_HUD")[-1].time_s > 14.0
    assert wire.simulation._autopilot.parameters["COM_OF_LOSS_T"] == pytest.approx(0.7)
    heartbeat = [h for h in wire.named("HEARTBEAT") if h.message.get_srcComponent() == 1][-1]
    assert heartbeat.message.base_mode & dialect.MAV_MODE_FLAG_SAFETY_ARMED
    wire.command(dialect.MAV_CMD_NAV_LAND, 0, 0, 0, NAN, NAN, NAN, 0)
    wire.run_until(lambda: not wire.simulation.is_armed, 30.0)
    assert not wire.simulation.is_damaged


def test_the_estimate_jumps_for_good_and_odometry_counts_it() -> None:
    wire = fly("at_s: 1, estimate: {east_m: 3, north_m: -2, up_m: 0.5}")
    wire.run(0.9)
    assert wire.last("ODOMETRY").reset_counter == 0
    for _ in range(3):
        wire.run(2.0)
        heard = wire.last("LOCAL_POSITION_NED")
        assert (heard.x, heard.y, heard.z) == pytest.approx((-2.0, 3.0, -0.5), abs=0.01)
    assert wire.last("ODOMETRY").reset_counter == 1
    fix, origin = wire.last("GPS_RAW_INT"), wire.simulation._vehicle.origin
    assert origin.to_local(fix.lat / 1e7, fix.lon / 1e7, 0.0)[:2] == pytest.approx((-2, 3), abs=1.0)
    assert wire.simulation.flight.position[:2] == pytest.approx((0.0, 0.0), abs=0.01)


def test_a_fix_after_a_loss_is_a_reset() -> None:
    wire = fly("at_s: 1, gps: {lost: true}", "at_s: 5, gps: {lost: false}")
    wire.run(7.0)
    assert wire.last("ODOMETRY").reset_counter == 1


def test_a_battery_that_is_not_known_is_told_so_and_calls_no_failsafe() -> None:
    wire = fly("at_s: 1, battery: {known: false, charge: 0.01}", "at_s: 5, battery: {known: true}")
    wire.run(4.9)
    status, system = wire.last("BATTERY_STATUS"), wire.last("SYS_STATUS")
    assert (status.battery_remaining, status.current_battery) == (-1, NO_CURRENT)
    assert set(status.voltages) == {NO_VOLTAGE}
    told = (system.battery_remaining, system.current_battery, system.voltage_battery)
    assert told == (-1, NO_CURRENT, NO_VOLTAGE)
    assert wire.arm() == [MavResult.ACCEPTED]
    wire.arm(False)
    wire.run(2.5)
    assert wire.last("BATTERY_STATUS").battery_remaining == 1
    assert wire.arm() == [MavResult.TEMPORARILY_REJECTED]
