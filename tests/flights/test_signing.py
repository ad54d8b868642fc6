"""A whole flight with keys on both sides, and with somebody on the link who has none."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from lockstep import Lockstep, Said, World
from meadow import areas, start

from companion.flight_events.fence import FenceWritten
from companion.flight_events.skills import PlaceReached
from companion.flight_events.sortie import TaskSatisfied
from companion.mavlink.framing import MavlinkCodec, Message, dialect
from companion.mavlink.px4_modes import MODES
from companion.mavlink.signing import (
    MayBeUnsigned,
    Signing,
    SigningKey,
    of_signed_vehicle,
    of_unsigned_vehicle,
)
from companion.mission.model import Mission

KEY = SigningKey.from_passphrase("hall")
NOW_S = 1.8e9


class Attacker:
    """On the way to the companion: replays all it hears later, and forges what would take control.

    Args:
        companion: verifies what arrives.
    """

    AFTER = 40
    """Ticks until something is sent again."""

    def __init__(self, companion: Signing) -> None:
        self._companion = companion
        self._captured: list[list[bytes]] = []
        self._autopilot = MavlinkCodec(1, 1)
        self._station = MavlinkCodec(255, 190)
        self._other = Signing(SigningKey(bytes(32)), NOW_S + 3600.0)
        self.sent = 0

    def __call__(self, now_s: float, datagrams: list[bytes]) -> list[bytes]:
        self._captured.append(datagrams)
        replayed = self._captured[-self.AFTER] if len(self._captured) >= self.AFTER else []
        replayed = [d for d in replayed if d[2]]
        forged = self._forged()
        attacks = [*forged, *self._other.send(now_s, forged), *replayed]
        self.sent += len(attacks)
        return self._companion.receive(now_s, [*attacks, *datagrams, *attacks[::-1]])

    def _forged(self) -> list[bytes]:
        """The autopilot is in another mode, disarmed; the operator pauses."""
        main, sub = MODES["POSCTL"]
        custom = (int(sub) << 24) | (int(main) << 16)
        autopilot = dialect.MAVLink_heartbeat_message(2, 12, 1, custom, 4, 3)
        pause = dialect.MAVLink_command_long_message(1, 191, 193, 0, *(0.0,) * 7)
        return [self._autopilot.pack(autopilot), self._station.pack(pause)]


Fly = Callable[..., Lockstep]


def test_a_flight_with_keys_is_the_flight_without(
    surveillance: Mission, short_hall: World, undisturbed: Lockstep
) -> None:
    """The attacker on the link is refused each time, and changes no event."""
    companion = Signing(KEY, NOW_S, of_signed_vehicle)
    vehicle = Signing(KEY, NOW_S)
    attacker = Attacker(companion)
    flight = Lockstep(surveillance, short_hall, up=attacker, down=companion.send, vehicle=vehicle)
    flight.until_the_end()
    assert flight.exit_code == 0
    assert flight.events == undisturbed.events
    assert sum(companion.refused) == 2 * attacker.sent
    assert not any(vehicle.refused)


@pytest.mark.parametrize(
    ("may_be_unsigned", "is_heard"), [(of_signed_vehicle, False), (of_unsigned_vehicle, True)]
)
def test_an_unsigned_autopilot_is_heard_where_that_is_said(
    surveillance: Mission, short_hall: World, may_be_unsigned: MayBeUnsigned, is_heard: bool
) -> None:
    companion = Signing(KEY, NOW_S, may_be_unsigned)
    flight = Lockstep(surveillance, short_hall, up=companion.receive, down=companion.send)
    flight.run(8.0)
    assert bool(flight.said) is is_heard


def test_beside_an_unsigned_autopilot_operators_sign(
    surveillance: Mission, short_hall: World
) -> None:
    """An unsigned command gets no answer; a signed one is done."""
    companion, station = Signing(KEY, NOW_S, of_unsigned_vehicle), Signing(KEY, NOW_S)
    operator, heard = MavlinkCodec(255, 190), list[bytes]()

    def up(now_s: float, datagrams: list[bytes]) -> list[bytes]:
        arrived = companion.receive(now_s, heard + datagrams)
        heard.clear()
        return arrived

    flight = Lockstep(surveillance, short_hall, up=up, down=companion.send)
    flight.until_reported(PlaceReached, place="A")
    pause = operator.pack(dialect.MAVLink_command_long_message(1, 191, 193, 0, *(0.0,) * 7))
    heard.append(pause)
    flight.run(1.0)
    assert answers(flight.said) == []
    heard.extend(station.send(flight.now_s, [pause]))
    flight.run(1.0)
    assert [m.result for m in answers(flight.said)] == [0]


def answers(said: list[Said]) -> list[dialect.MAVLink_command_ack_message]:
    return [s.message for s in said if s.message.get_type() == "COMMAND_ACK"]


class FenceAttacker:
    """Says on both ways, without the key, what would end or change a transfer of the fence."""

    def __init__(self, companion: Signing) -> None:
        self._companion = companion
        self._autopilot, self._other = MavlinkCodec(1, 1), MavlinkCodec(1, 191)
        self._wrong = Signing(SigningKey(bytes(32)), NOW_S + 3600.0)
        self.sent = 0

    def up(self, now_s: float, datagrams: list[bytes]) -> list[bytes]:
        """As the autopilot: a refusal, an empty fence, a home elsewhere, an area left out."""
        to, kind = (1, 191), dialect.MAV_MISSION_TYPE_FENCE
        elsewhere = (480000000, 90000000, 0, 0.0, 0.0, 0.0, [1.0, 0.0, 0.0, 0.0], 0.0, 0.0, 0.0)
        said = [
            dialect.MAVLink_mission_ack_message(*to, dialect.MAV_MISSION_NO_SPACE, kind),
            dialect.MAVLink_mission_count_message(*to, 0, kind),
            dialect.MAVLink_mission_request_int_message(*to, 3, kind),
            dialect.MAVLink_home_position_message(*elsewhere),
            dialect.MAVLink_statustext_message(2, b"Geofence invalid, doesn't contain Home"),
        ]
        return self._companion.receive(now_s, self._mixed(now_s, self._autopilot, said, datagrams))

    def down(self, now_s: float, datagrams: list[bytes]) -> list[bytes]:
        """As the companion: the fence is cleared, or another one comes."""
        kind = dialect.MAV_MISSION_TYPE_FENCE
        said = [
            dialect.MAVLink_mission_clear_all_message(1, 1, kind),
            dialect.MAVLink_mission_count_message(1, 1, 0, kind),
        ]
        return self._mixed(now_s, self._other, said, self._companion.send(now_s, datagrams))

    def _mixed(
        self, now_s: float, codec: MavlinkCodec, said: list[Message], datagrams: list[bytes]
    ) -> list[bytes]:
        forged = [codec.pack(message) for message in said]
        attacks = [*forged, *self._wrong.send(now_s, forged)]
        self.sent += len(attacks)
        return [*attacks, *datagrams, *attacks]


@pytest.mark.long
def test_a_fence_is_uploaded_over_a_signed_link_whatever_others_answer() -> None:
    companion, vehicle = Signing(KEY, NOW_S, of_signed_vehicle), Signing(KEY, NOW_S)
    attacker = FenceAttacker(companion)
    flight = start(has_station=False, up=attacker.up, down=attacker.down, vehicle=vehicle)
    flight.until_the_end()
    quiet = start(has_station=False).until_the_end()
    assert flight.ending == quiet.ending == TaskSatisfied()
    assert flight.events == quiet.events and flight.of(FenceWritten)
    assert len(areas(flight)) == 2
    refused = sum(companion.refused) + sum(vehicle.refused)
    assert 0 <= 2 * attacker.sent - refused <= 8, "but for those of the last tick"
