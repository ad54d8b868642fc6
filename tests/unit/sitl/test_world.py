"""Target detector, payload and walls, alone and on the wire."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from wire import Wire, companion_heartbeat, gcs_heartbeat

from companion.mavlink.framing import dialect
from companion.motion.grid import OccupancyGrid
from sitl.link.routing import LinkName
from sitl.results import MavResult
from sitl.world.collision import CollisionCounter
from sitl.world.payload import CommandAck, Payload, PayloadAnswer, PayloadScript, PayloadSite
from sitl.world.scenario import Scenario
from sitl.world.visits import LEAVING_MARGIN_M, Circle, VisitCounter

AWAY, INSIDE = (10.0, 0.0, -2.0), (0.2, 0.0, -2.0)
USER_1 = dialect.MAV_CMD_USER_1
OPERATOR, OTHER = (1, 191), (255, 190)


@pytest.mark.parametrize("visit", [1, 2, 3])
def test_staying_is_one_visit_and_leaving_ends_it(visit: int) -> None:
    visits = VisitCounter(Circle((0.0, 0.0), 1.0), AWAY)
    for _ in range(visit):
        for position in (INSIDE, INSIDE, AWAY):
            visits.update(position)
    assert visits.count == visit


def test_being_there_at_the_start_is_no_visit() -> None:
    visits = VisitCounter(Circle((0.0, 0.0), 1.0), INSIDE)
    counts = []
    for position in (INSIDE, AWAY, INSIDE):
        visits.update(position)
        counts.append(visits.count)
    assert counts == [0, 0, 1]


@given(st.lists(st.floats(0.0, 1.0 + LEAVING_MARGIN_M)))
def test_wavering_on_the_edge_is_one_visit(distances_m: list[float]) -> None:
    visits = VisitCounter(Circle((0.0, 0.0), 1.0), AWAY)
    visits.update(INSIDE)
    for away_m in distances_m:
        visits.update((away_m, 0.0, -2.0))
    assert visits.count == 1


SCRIPT = PayloadScript(
    25,
    USER_1,
    (
        PayloadSite((0.0, 0.0), 1.0, PayloadAnswer(MavResult.FAILED, 2.0)),
        PayloadSite((0.0, 0.0), 3.0, PayloadAnswer(MavResult.ACCEPTED, 0.5)),
    ),
    MavResult.DENIED,
)


@pytest.mark.parametrize(
    ("north_m", "result", "after_s"),
    [(0.5, MavResult.FAILED, 2.0), (2.0, MavResult.ACCEPTED, 0.5), (9.0, MavResult.DENIED, 1.0)],
)
def test_the_first_circle_that_holds_the_vehicle_answers(
    north_m: float, result: MavResult, after_s: float
) -> None:
    payload = Payload(SCRIPT)
    assert payload.receive(OPERATOR, USER_1, (north_m, 0, 0), 10.0) == CommandAck(
        OPERATOR, MavResult.IN_PROGRESS
    )
    assert payload.step(10.0 + after_s - 0.01) is None
    assert payload.step(10.0 + after_s) == CommandAck(OPERATOR, result)
    assert payload.step(10.0 + after_s) is None


def test_a_repeated_command_is_one_command_and_a_second_asker_waits() -> None:
    payload = Payload(SCRIPT)
    payload.receive(OPERATOR, USER_1, (2.0, 0, 0), 0.0)
    assert payload.receive(OPERATOR, USER_1, (2.0, 0, 0), 0.4) == CommandAck(
        OPERATOR, MavResult.IN_PROGRESS
    )
    assert payload.receive(OTHER, USER_1, (2.0, 0, 0), 0.4) == CommandAck(
        OTHER, MavResult.TEMPORARILY_REJECTED
    )
    assert payload.step(0.5) == CommandAck(OPERATOR, MavResult.ACCEPTED)
    assert payload.receive(OTHER, USER_1, (2.0, 0, 0), 0.6) == CommandAck(
        OTHER, MavResult.IN_PROGRESS
    )


def test_a_repetition_is_answered_the_same_soon_after_the_answer_and_done_anew_later() -> None:
    """Its first sending may have been lost: the confirmation count alone tells them not apart."""
    payload = Payload(SCRIPT)
    payload.receive(OPERATOR, USER_1, (9.0, 0, 0), 0.0)
    denied = payload.step(1.0)
    assert denied == CommandAck(OPERATOR, MavResult.DENIED)
    assert payload.receive(OPERATOR, USER_1, (2.0, 0, 0), 4.0, is_repeated=True) == denied
    assert payload.receive(OPERATOR, USER_1, (2.0, 0, 0), 4.1, is_repeated=True) == CommandAck(
        OPERATOR, MavResult.IN_PROGRESS
    )
    assert payload.step(4.6) == CommandAck(OPERATOR, MavResult.ACCEPTED)


def test_the_payload_knows_one_command() -> None:
    reply = Payload(SCRIPT).receive(OPERATOR, USER_1 + 1, (0, 0, 0), 0.0)
    assert reply == CommandAck(OPERATOR, MavResult.UNSUPPORTED)


def test_devices_are_components_of_their_own_on_both_links() -> None:
    wire = Wire(Scenario(detector=26, payload=SCRIPT))
    wire.send(companion_heartbeat())
    wire.run(4.99)
    for link in LinkName:
        heard = [h.message for h in wire.named("HEARTBEAT", link)]
        beats = [m.get_srcComponent() for m in heard if m.get_srcComponent() in (25, 26)]
        assert (beats.count(25), beats.count(26)) == (5, 5)
        reports = [h.message for h in wire.named("NAMED_VALUE_INT", link)]
        assert [(m.name, m.value) for m in reports] == [("target", 0)] * 10
    wire.command(USER_1, component=25)
    wire.run(3.0)
    acks = [h.message for h in wire.named("COMMAND_ACK")]
    assert [m.result for m in acks] == [MavResult.IN_PROGRESS, MavResult.FAILED]
    assert {m.get_srcComponent() for m in acks} == {25}
    assert wire.named("COMMAND_ACK", LinkName.GCS) == []


def walled() -> OccupancyGrid:
    """20 m by 20 m around home with a wall 5 m to the north."""
    occupied = np.zeros((200, 200), dtype=np.bool_)
    occupied[150:152, :] = True
    return OccupancyGrid(occupied, 0.1, (-10.0, -10.0))


def test_collisions_are_counted_when_they_begin() -> None:
    watch = CollisionCounter(walled(), 0.35)
    begins = [watch.update((north, 0.0, -2.0)) for north in (0.0, 4.5, 4.82, 4.9, 4.0, 4.9)]
    assert begins == [False, False, True, False, False, True]
    assert watch.count == 2
    assert not CollisionCounter(None, 0.35).update((1e6, 1e6, 0.0))


def test_a_vehicle_that_falls_over_is_a_wreck_that_lies_still() -> None:
    wire = Wire()
    wire.send(gcs_heartbeat())
    wire.fly_offboard(0.0, 0.0, -4.0)
    wire.run(1.5, send=lambda: wire.setpoint(30.0, 0.0, -4.0))
    wire.arm(False, 21196)  # at speed, so that it tumbles
    wire.run(20.0)
    assert "Crash detected" in wire.texts()
    assert wire.simulation.flight.velocity == (0.0, 0.0, 0.0)
    assert wire.simulation.flight.time_s == pytest.approx(wire.now_s)
    assert wire.simulation.collisions == 0
    assert wire.arm() == [MavResult.TEMPORARILY_REJECTED]


def test_flying_into_a_wall_stops_the_motors_and_is_told_once() -> None:
    wire = Wire(grid=walled())
    wire.send(gcs_heartbeat())
    wire.fly_offboard(0.0, 0.0, -2.0)
    assert wire.simulation.collisions == 0
    wire.run(10.0, send=lambda: wire.setpoint(8.0, 0.0, -2.0))
    assert wire.simulation.collisions == 1
    assert wire.texts().count("Collision with a wall") == 1
    assert not wire.simulation.is_armed
    assert wire.simulation.flight.position[2] == pytest.approx(0.0, abs=0.12)  # lies there
    assert wire.simulation.flight.velocity == pytest.approx((0.0, 0.0, 0.0), abs=0.01)
    assert wire.arm() == [MavResult.TEMPORARILY_REJECTED]
