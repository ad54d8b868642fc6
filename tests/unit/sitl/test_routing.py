"""Which link a message goes out on: the rules of the MAVLink routing guide."""

from typing import Any

from hypothesis import given
from hypothesis import strategies as st

from companion.mavlink.framing import MavlinkCodec, dialect
from sitl.link.routing import LinkName, Router, is_for

GCS, OFFBOARD = LinkName.GCS, LinkName.OFFBOARD
LOCAL = [(1, 1), (1, 25)]


def received(message: Any, sender: tuple[int, int]) -> Any:
    """A message as it comes out of a parser."""
    return MavlinkCodec(0, 0).parse(MavlinkCodec(*sender).pack(message))[0]


def command(system: int, component: int, sender: tuple[int, int] = (255, 190)) -> Any:
    return received(
        dialect.MAVLink_command_long_message(system, component, 400, 0, *(0.0,) * 7), sender
    )


def heartbeat(sender: tuple[int, int], mav_type: int) -> Any:
    return received(dialect.MAVLink_heartbeat_message(mav_type, 8, 0, 0, 4, 3), sender)


def connected() -> Router:
    router = Router(LinkName, LOCAL)
    router.learn(OFFBOARD, heartbeat((1, 191), 18))
    router.learn(GCS, heartbeat((255, 190), 6))
    return router


def test_broadcasts_and_messages_without_target_go_to_the_other_link() -> None:
    router = connected()
    assert router.destinations(command(0, 0), GCS) == [OFFBOARD]
    assert router.destinations(heartbeat((1, 191), 18), OFFBOARD) == [GCS]


def test_what_is_for_a_component_on_board_stays() -> None:
    router = connected()
    assert [router.destinations(command(*address), GCS) for address in LOCAL] == [[], []]


def test_a_component_is_reached_where_it_was_heard() -> None:
    router = connected()
    assert router.destinations(command(1, 191), GCS) == [OFFBOARD]
    assert router.destinations(command(1, 0), GCS) == [OFFBOARD]  # and the autopilot too
    assert router.destinations(command(1, 77), GCS) == []
    assert router.destinations(command(9, 0), GCS) == []


def test_components_on_board_reach_both_links_or_the_one_that_asked() -> None:
    router = connected()
    assert set(router.destinations(heartbeat((1, 25), 18), None)) == {GCS, OFFBOARD}
    ack = received(dialect.MAVLink_command_ack_message(31010, 0, 0, 0, 1, 191), (1, 25))
    assert router.destinations(ack, None) == [OFFBOARD]


@given(
    system=st.integers(0, 255),
    component=st.integers(0, 255),
    origin=st.sampled_from(LinkName),
    heard=st.lists(st.tuples(st.sampled_from(LinkName), st.integers(0, 255), st.integers(0, 255))),
)
def test_nothing_ever_goes_back_where_it_came_from(
    system: int, component: int, origin: LinkName, heard: list[tuple[LinkName, int, int]]
) -> None:
    router = Router(LinkName, LOCAL)
    for link, *sender in heard:
        router.learn(link, heartbeat((sender[0], sender[1]), 18))
    assert origin not in router.destinations(command(system, component), origin)


def test_a_ground_station_is_noticed_by_its_heartbeat_alone() -> None:
    router = Router(LinkName, LOCAL)
    router.learn(OFFBOARD, heartbeat((1, 191), 18))
    assert not any(router.has_ground_station(link) for link in LinkName)
    router.learn(GCS, heartbeat((255, 190), 6))
    assert all(router.has_ground_station(link) for link in LinkName)  # it is forwarded


def test_addressing() -> None:
    assert is_for((1, 1), command(1, 1))
    assert is_for((1, 1), command(0, 0))
    assert is_for((1, 1), command(1, 0))
    assert not is_for((1, 1), command(1, 25))
    assert not is_for((1, 1), command(2, 1))
