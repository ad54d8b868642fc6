"""A simulated vehicle with a key: as PX4, on all its links."""

from __future__ import annotations

import pytest

from companion.mavlink.framing import MavlinkCodec, Message, dialect
from companion.mavlink.px4_modes import MODES
from companion.mavlink.signing import Signing, SigningKey
from sitl.link.routing import LinkName
from sitl.simulation import Simulation
from sitl.world.scenario import Scenario

KEY = SigningKey.from_passphrase("hall")
NOW_S = 1.8e9
GCS, OFFBOARD = LinkName.GCS, LinkName.OFFBOARD
STATION, COMPANION = MavlinkCodec(255, 190), MavlinkCodec(1, 191)


class Vehicle:
    """With a key, and a station and a companion that have it too."""

    def __init__(self) -> None:
        self.signing = Signing(KEY, NOW_S)
        self.simulation = Simulation(Scenario(), None, seed=1, signing=self.signing)
        self.ear = Signing(KEY, NOW_S)
        self.now_s = 0.0

    def hears(self, link: LinkName, *frames: bytes) -> list[tuple[LinkName, bytes]]:
        self.now_s += 0.02
        return self.simulation.step(self.now_s, [(link, frame) for frame in frames])


def arm() -> bytes:
    return STATION.pack(dialect.MAVLink_command_long_message(1, 1, 400, 0, 1, *(0.0,) * 6))


def hold() -> bytes:
    command = dialect.MAVLink_command_long_message(
        1, 1, 176, 0, 1, *MODES["AUTO.LOITER"], 0, 0, 0, 0
    )
    return STATION.pack(command)


def answers(out: list[tuple[LinkName, bytes]]) -> list[Message]:
    parsed = [m for _, frame in out for m in MavlinkCodec(0, 0).parse(frame)]
    return [m for m in parsed if m.get_type() == "COMMAND_ACK"]


def test_all_that_it_says_is_signed_and_its_peers_accept_it() -> None:
    vehicle = Vehicle()
    out = [each for _ in range(100) for each in vehicle.hears(GCS)]
    assert {link for link, _ in out} == {GCS, OFFBOARD}
    frames = [frame for _, frame in out]
    assert vehicle.ear.receive(0.0, frames) == frames
    assert not any(vehicle.ear.refused)


@pytest.mark.parametrize("link", [GCS, OFFBOARD])
def test_a_command_without_a_signature_changes_nothing(link: LinkName) -> None:
    vehicle, other = Vehicle(), Signing(SigningKey(bytes(32)), NOW_S)
    for frame in (arm(), hold(), *other.send(0.0, [arm(), hold()])):
        assert answers(vehicle.hears(link, frame)) == []
    assert not vehicle.simulation.is_armed
    assert vehicle.signing.refused[:2] == (2, 2)


def test_a_signed_command_is_answered_once_on_whichever_link_it_comes() -> None:
    vehicle, station = Vehicle(), Signing(KEY, NOW_S)
    (frame,) = station.send(0.0, [hold()])
    assert len(answers(vehicle.hears(GCS, frame))) >= 1
    for link in (GCS, OFFBOARD):
        assert answers(vehicle.hears(link, frame)) == []
    assert vehicle.signing.refused.old == 2


def test_what_is_forwarded_keeps_its_sender_s_signature() -> None:
    vehicle, station = Vehicle(), Signing(KEY, NOW_S)
    beat = COMPANION.pack(dialect.MAVLink_heartbeat_message(18, 8, 0, 0, 4, 3))
    companion = Signing(KEY, NOW_S)
    vehicle.hears(OFFBOARD, *companion.send(0.0, [beat]))
    start = STATION.pack(dialect.MAVLink_command_long_message(1, 191, 300, 0, *(0.0,) * 7))
    (signed,) = station.send(0.0, [start])
    assert (OFFBOARD, signed) in vehicle.hears(GCS, signed)


def test_an_unsigned_heartbeat_is_heard_and_forwarded_as_it_is() -> None:
    vehicle = Vehicle()
    beat = STATION.pack(dialect.MAVLink_heartbeat_message(6, 8, 0, 0, 4, 3))
    assert (OFFBOARD, beat) in vehicle.hears(GCS, beat)


@pytest.mark.parametrize("is_signed", [True, False])
def test_a_key_is_never_forwarded(is_signed: bool) -> None:
    signing = Signing(KEY, NOW_S)
    setup = STATION.pack(dialect.MAVLink_setup_signing_message(0, 0, [7] * 32, 0))
    sent = signing.send(0.0, [setup]) if is_signed else [setup]
    simulation = Simulation(Scenario(), None, seed=1)  # without a key it would forward anything
    vehicle = Vehicle()
    out = [*vehicle.hears(GCS, *sent), *simulation.step(0.02, [(GCS, f) for f in sent])]
    assert not any(bytes([7] * 32) in frame for _, frame in out)
