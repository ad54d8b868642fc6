"""A client of MAVLink FTP that says exactly what a test wants, packed by hand from the spec."""

from __future__ import annotations

import struct
from typing import NamedTuple

from companion.ground.ftp import FtpServer
from companion.mavlink.ftp_frames import Nak, Opcode

ACK = 128


class Reply(NamedTuple):
    sequence: int
    session: int
    opcode: int
    size: int
    asked: int
    ends_burst: int
    offset: int
    data: bytes

    @property
    def nak(self) -> Nak | None:
        return None if self.opcode == ACK else Nak(self.data[0])


def pack(
    sequence: int,
    opcode: int,
    data: bytes = b"",
    *,
    session: int = 0,
    offset: int = 0,
    size: int | None = None,
) -> bytes:
    head = struct.pack(
        "<HBBBBBBI", sequence, session, opcode, len(data) if size is None else size, 0, 0, 0, offset
    )
    return (head + data).ljust(251, b"\0")


def unpack(payload: bytes) -> Reply:
    assert len(payload) == 251
    sequence, session, opcode, size, asked, burst, _, offset = struct.unpack_from(
        "<HBBBBBBI", payload
    )
    return Reply(sequence, session, opcode, size, asked, burst, offset, payload[12 : 12 + size])


class Client:
    """Asks one request after the other; time passes only if told."""

    def __init__(self, server: FtpServer, address: tuple[int, int] = (255, 190)) -> None:
        self.server, self.address = server, address
        self.now_s = 0.0
        self.sequence = 0

    def burst(self, opcode: Opcode, data: bytes | str = b"", **fields: int) -> list[Reply]:
        raw = data.encode() if isinstance(data, str) else data
        self.sequence += 1
        return self.send(pack(self.sequence, opcode, raw, **fields))

    def send(self, payload: bytes) -> list[Reply]:
        return [unpack(p) for p in self.server.receive(self.now_s, self.address, payload)]

    def ask(self, opcode: Opcode, data: bytes | str = b"", **fields: int) -> Reply:
        (reply,) = self.burst(opcode, data, **fields)
        assert reply.sequence == self.sequence + 1
        assert reply.asked == opcode
        return reply

    def put(self, path: str, content: bytes) -> None:
        opened = self.ask(Opcode.CREATE_FILE, path)
        assert opened.nak is None
        for start in range(0, len(content), 239):
            part = content[start : start + 239]
            session = opened.session
            assert not self.ask(Opcode.WRITE_FILE, part, session=session, offset=start).nak
        assert self.ask(Opcode.TERMINATE_SESSION, session=opened.session).nak is None

    def get(self, path: str) -> bytes:
        opened = self.ask(Opcode.OPEN_FILE_RO, path)
        assert opened.nak is None
        content = b""
        while True:
            part = self.ask(Opcode.READ_FILE, session=opened.session, offset=len(content), size=239)
            if part.nak is not None:
                assert part.nak is Nak.EOF
                break
            content += part.data
        assert self.ask(Opcode.TERMINATE_SESSION, session=opened.session).nak is None
        assert len(content) == int.from_bytes(opened.data, "little")
        return content
