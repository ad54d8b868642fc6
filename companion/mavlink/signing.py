"""Signs and verifies frames with a key, so that nobody without the key commands the vehicle.

It is a layer between the link and those who read messages: bytes in, accepted frames out. The
rules:

1. The signature is verified first. Only a frame with a right signature changes any state here.
2. A stream is what a component sends on one of its links. Its time stamps increase strictly,
   whichever of our links they arrive on. A new stream may be up to a minute behind our own time
   stamp.
3. Our own time stamp is the clock's, but never less than any accepted one. It grows with each frame
   that is signed. A frame of ours that is sent back to us counts as old in its stream.
4. The newest time stamp of each stream is kept from run to run. After a start `KEPT_EVERY_S` is
   added to each, so that nothing sent before the end of the previous run is accepted again.
5. Only a few kinds of unsigned frames are accepted (`MayBeUnsigned`), and no MAVLink 1 frames.
6. The number of streams is bounded. A stream beyond `STREAMS` replaces one that is a minute old,
   which then only has to catch up. If there is none, the new stream is refused.

Source: https://mavlink.io/en/guide/message_signing.html and PX4's list of what may be unsigned,
https://docs.px4.io/main/en/mavlink/message_signing. Left out: SETUP_SIGNING, which sends a key over
the link that it is to protect. No I/O: `key_file.py` handles the files.
"""

from __future__ import annotations

import hashlib
import hmac
from collections.abc import Callable, Mapping
from functools import cache
from operator import add
from typing import NamedTuple

from companion.errors import RequestError
from companion.mavlink.framing import checksum, dialect, message_id, split_frames
from companion.mavlink.intake import is_news

KEY_BYTES = 32
UNITS_PER_S = 100_000
"""A time stamp counts 10 us."""
EPOCH_UNIX_S = 1_420_070_400  # 2015-01-01, where time stamps begin
BEHIND = 60 * UNITS_PER_S
LATEST = 1 << 47
"""In the year 2059. A component that accepts a stamp at the end of the range cannot sign any
more."""
KEPT_EVERY_S = 2
KEPT_EVERY = KEPT_EVERY_S * UNITS_PER_S
STREAMS = 256

_SIGNED: int = dialect.MAVLINK_IFLAG_SIGNED
_MAGIC_2 = 0xFD
_AUTOPILOT: int = dialect.MAV_COMP_ID_AUTOPILOT1
_COMPANION: int = dialect.MAV_COMP_ID_ONBOARD_COMPUTER
_HEARTBEAT: int = dialect.MAVLINK_MSG_ID_HEARTBEAT

HARMLESS = frozenset(
    {
        _HEARTBEAT,
        dialect.MAVLINK_MSG_ID_RADIO_STATUS,
        dialect.MAVLINK_MSG_ID_ADSB_VEHICLE,
        dialect.MAVLINK_MSG_ID_COLLISION,
    }
)
"""Messages that PX4 accepts unsigned."""
REQUESTS = frozenset(
    {
        dialect.MAVLINK_MSG_ID_COMMAND_LONG,
        dialect.MAVLINK_MSG_ID_COMMAND_INT,
        dialect.MAVLINK_MSG_ID_PARAM_REQUEST_LIST,
        dialect.MAVLINK_MSG_ID_PARAM_REQUEST_READ,
        dialect.MAVLINK_MSG_ID_PARAM_SET,
        dialect.MAVLINK_MSG_ID_PING,
        dialect.MAVLINK_MSG_ID_FILE_TRANSFER_PROTOCOL,
        dialect.MAVLINK_MSG_ID_SETUP_SIGNING,
    }
)
"""Requests to the companion; never accepted unsigned."""

Stream = tuple[int, int, int]
"""System id and component id of the sender, and the id of its link."""
Stamps = Mapping[Stream, int]
"""The newest time stamp of each stream."""
MayBeUnsigned = Callable[[bytes], bool]
"""Whether an unsigned MAVLink 2 frame is accepted."""


def harmless(frame: bytes) -> bool:
    """Accepts unsigned what PX4 accepts."""
    return message_id(frame) in HARMLESS


def of_signed_vehicle(frame: bytes) -> bool:
    """Accepts the same, but no HEARTBEAT of an autopilot: it decides who has control."""
    return harmless(frame) and (message_id(frame), frame[6]) != (_HEARTBEAT, _AUTOPILOT)


def of_unsigned_vehicle(frame: bytes) -> bool:
    """Accepts everything except requests to the companion, and messages in the companion's name."""
    return message_id(frame) not in REQUESTS and frame[6] != _COMPANION


class SigningKey:
    """The secret that both ends have; it is neither printed nor logged.

    >>> SigningKey.from_passphrase("correct horse")
    SigningKey(...)
    """

    def __init__(self, secret: bytes) -> None:
        if len(secret) != KEY_BYTES:
            raise RequestError(f"a signing key has {KEY_BYTES} bytes, not {len(secret)}")
        self.secret = secret

    @classmethod
    def from_passphrase(cls, passphrase: str) -> SigningKey:
        """The key that QGroundControl makes of a passphrase: its SHA-256."""
        return cls(hashlib.sha256(passphrase.encode()).digest())

    @classmethod
    def from_hex(cls, text: str) -> SigningKey:
        """The key of 64 hexadecimal digits.

        Raises:
            CompanionError: it is something else.
        """
        try:
            return cls(bytes.fromhex(text))
        except ValueError:
            raise RequestError(f"a signing key is {2 * KEY_BYTES} hexadecimal digits") from None

    def __repr__(self) -> str:
        return "SigningKey(...)"


class Refused(NamedTuple):
    """How many frames were refused, by reason.

    Attributes:
        unsigned: without a signature, or MAVLink 1.
        forged: with a wrong signature: damaged, or made with another key.
        old: with a right signature, but a time stamp that is too old.
    """

    unsigned: int = 0
    forged: int = 0
    old: int = 0

    def __str__(self) -> str:
        return f"{self.unsigned} unsigned, {self.forged} with another key, {self.old} too old"


class Signing:
    """Signs outgoing frames, and accepts incoming ones that are signed.

    >>> key = SigningKey.from_passphrase("correct horse")
    >>> ours, theirs = Signing(key, 1.7e9), Signing(key, 1.7e9)
    >>> heartbeat = bytes.fromhex("fd09000000f5be0000000000000006080000037aea")
    >>> signed = ours.send(0.0, [heartbeat])
    >>> theirs.receive(0.0, signed) == signed, theirs.receive(0.0, signed), theirs.refused
    (True, [], Refused(unsigned=0, forged=0, old=1))

    Args:
        key: the secret.
        start_unix_s: the clock at the start, seconds since 1970.
        may_be_unsigned: decides which frames need no signature.
        heard: the streams of the previous run.
        keep: called with all streams when they have to be stored; it may not block.

    Attributes:
        refused: frames refused so far.
    """

    def __init__(
        self,
        key: SigningKey,
        start_unix_s: float,
        may_be_unsigned: MayBeUnsigned = harmless,
        heard: Stamps | None = None,
        keep: Callable[[Stamps], None] = lambda stamps: None,
    ) -> None:
        self.refused = Refused()
        self._told = 0
        self._hash = hashlib.sha256(key.secret)
        self._may_be_unsigned = may_be_unsigned
        self._keep = keep
        self._streams = {s: stamp + KEPT_EVERY for s, stamp in (heard or {}).items()}
        self._kept: Stamps = {}
        clock = max(0, int((start_unix_s - EPOCH_UNIX_S) * UNITS_PER_S))
        self._start = self._stamp = max([clock, *self._streams.values()])

    def receive(self, now_s: float, datagrams: list[bytes]) -> list[bytes]:
        """Returns the accepted frames, in order, each as a datagram.

        Args:
            now_s: time since the start; a time before an earlier one has no effect.
            datagrams: as they arrived.
        """
        self._advance(now_s)
        return [f for d in datagrams for f in split_frames(d) if self._accepts(f)]

    def send(self, now_s: float, frames: list[bytes], link: int = 0) -> list[bytes]:
        """Returns MAVLink 2 frames with signatures; frames that are signed already are not changed.

        Args:
            now_s: as for `receive`.
            frames: one in each datagram.
            link: id of our link on which they are sent.
        """
        self._advance(now_s)
        return [frame if frame[2] & _SIGNED else self._sign(frame, link) for frame in frames]

    def news(self) -> Refused | None:
        """What was refused so far, if it has doubled since it was last reported."""
        if not is_news(count := sum(self.refused), self._told):
            return None
        self._told = count
        return self.refused

    def _advance(self, now_s: float) -> None:
        self._stamp = max(self._stamp, self._start + int(now_s * UNITS_PER_S))

    def _sign(self, frame: bytes, link: int) -> bytes:
        stamp = self._stamp + 1
        crc = int.from_bytes(frame[-2:], "little") ^ _checksum_of_flag(frame[1])
        flags = bytes([frame[2] | _SIGNED])
        trailer = crc.to_bytes(2, "little") + bytes([link]) + stamp.to_bytes(6, "little")
        signed = frame[:2] + flags + frame[3:-2] + trailer
        self._learn((frame[5], frame[6], link), stamp)
        return signed + self._signature(signed)

    def _accepts(self, frame: bytes) -> bool:
        """Whether a frame is accepted; counts it if not."""
        refused = self._judge(frame)
        self.refused = Refused(*map(add, self.refused, refused))
        return not any(refused)

    def _judge(self, frame: bytes) -> Refused:
        """Why a frame is refused, as a count of one; all counts are 0 if it is accepted."""
        if frame[0] != _MAGIC_2:
            return Refused(unsigned=1)
        if not frame[2] & _SIGNED:
            return Refused() if self._may_be_unsigned(frame) else Refused(unsigned=1)
        if not hmac.compare_digest(self._signature(frame[:-6]), frame[-6:]):
            return Refused(forged=1)
        stream, stamp = (frame[5], frame[6], frame[-13]), int.from_bytes(frame[-12:-6], "little")
        if not self._is_new(stream, stamp):
            return Refused(old=1)
        self._learn(stream, stamp)
        return Refused()

    def _signature(self, signed: bytes) -> bytes:
        digest = self._hash.copy()
        digest.update(signed)
        return digest.digest()[:6]

    def _is_new(self, stream: Stream, stamp: int) -> bool:
        last = self._streams.get(stream, self._stamp - BEHIND - 1)
        return last < stamp < LATEST and (stream in self._streams or self._has_room())

    def _has_room(self) -> bool:
        """Whether a stream can be added; removes one that is old enough if necessary."""
        if len(self._streams) < STREAMS:
            return True
        oldest = min(self._streams, key=self._streams.__getitem__)
        is_old = self._streams[oldest] < self._stamp - BEHIND
        if is_old:
            del self._streams[oldest]
        return is_old

    def _learn(self, stream: Stream, stamp: int) -> None:
        """Takes over a time stamp; stores all streams if a later start would accept this stamp
        again.
        """
        self._streams[stream] = stamp
        self._stamp = max(self._stamp, stamp)
        if stamp - self._kept.get(stream, -KEPT_EVERY) >= KEPT_EVERY:
            self._kept = dict(self._streams)
            self._keep(self._kept)


@cache
def _checksum_of_flag(size: int) -> int:
    """The change of the checksum caused by the flag of signed frames: a CRC is linear.

    So a frame can be signed even if its message is unknown, and with it the last byte of its
    checksum.

    Args:
        size: of the payload.
    """
    return int(checksum(bytes([_SIGNED]) + bytes(size + 8), 0))
