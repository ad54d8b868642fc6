"""The socket at which other programs report: who may write to it, and what is left of it."""

from __future__ import annotations

import socket
import stat
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path

import pytest

from companion.errors import LinkError
from companion.vehicle.detections import LONGEST, MOST
from companion.vehicle.report_port import ReportPort


@contextmanager
def program() -> Iterator[socket.socket]:
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as unix:
        unix.setblocking(False)
        yield unix


def test_its_file_is_for_its_owner_and_group_and_goes_with_it(tmp_path: Path) -> None:
    path = tmp_path / "events"
    with closing(ReportPort(f"unix:{path}")) as port, program() as detector:
        assert stat.S_IMODE(path.stat().st_mode) == 0o660
        detector.sendto(b"one", str(path))
        detector.sendto(b"two", str(path))
        assert port.receive() == [b"one", b"two"]
        assert port.receive() == []
    assert not path.exists()


def test_what_a_killed_program_has_left_is_replaced(tmp_path: Path) -> None:
    path = tmp_path / "events"
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as killed:
        killed.bind(str(path))
    assert path.exists()
    ReportPort(f"unix:{path}").close()


def test_a_path_in_use_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "events"
    with closing(ReportPort(f"unix:{path}")) as port:
        with pytest.raises(LinkError, match="already in use"):
            ReportPort(f"unix:{path}")
        with program() as detector:
            detector.sendto(b"still heard", str(path))
        assert port.receive() == [b"still heard"]


def test_a_file_that_is_no_socket_is_kept(tmp_path: Path) -> None:
    path = tmp_path / "events"
    path.write_text("precious", encoding="utf-8")
    with pytest.raises(LinkError, match="cannot hear reports"):
        ReportPort(f"unix:{path}")
    assert path.read_text(encoding="utf-8") == "precious"


@pytest.mark.parametrize(
    "address",
    [
        *("", "events", "unix:", "unix:/no/such/folder/events", "tcp:127.0.0.1:1"),
        *("udpin:127.0.0.1", "udpin:127.0.0.1:99999", "udpin:no.such.host.invalid:1"),
    ],
)
def test_an_address_that_is_none_is_refused_with_what_to_write(address: str) -> None:
    with pytest.raises(LinkError, match="write unix:/run/companion/events"):
        ReportPort(address)


@pytest.mark.parametrize("prefix", ["udpin:", "udpin://"])
def test_a_udp_port_of_this_machine(prefix: str) -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", 0))
        number = free.getsockname()[1]
    with (
        closing(ReportPort(f"{prefix}127.0.0.1:{number}")) as port,
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as detector,
    ):
        for n in range(MOST + 10):
            detector.sendto(str(n).encode(), ("127.0.0.1", number))
        detector.sendto(bytes(2 * LONGEST), ("127.0.0.1", number))
        first, rest = port.receive(), port.receive()
    assert first == [str(n).encode() for n in range(MOST)]
    assert rest[:10] == [str(n).encode() for n in range(MOST, MOST + 10)]
    assert len(rest[10]) == LONGEST + 1
