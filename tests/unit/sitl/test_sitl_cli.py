"""The simulator's door: options, ports."""

import socket
from contextlib import closing
from importlib import metadata
from pathlib import Path
from types import SimpleNamespace

import pytest
import typer

from companion.errors import LinkError
from companion.mavlink.intake import LONGEST, SENDER_FRAMES, STRANGERS_FRAMES
from companion.vehicle.report_port import ReportPort
from sitl.cli import default_home, main, parse_home
from sitl.link.report_sender import ReportSender
from sitl.link.routing import LinkName
from sitl.link.server import LOCAL_PORTS, Server
from sitl.world.scenario import PX4_HOME


def test_home_of_the_environment_and_of_the_option() -> None:
    assert default_home({}) == PX4_HOME
    assert default_home({"PX4_HOME_ALT": "12"}).altitude_m == 12.0
    assert parse_home("47.5,8.5,400").latitude_deg == 47.5
    for text in ("47.5,8.5", "a,b,c", "95,0,0", "nan,0,0"):
        with pytest.raises(typer.BadParameter):
            parse_home(text)


def test_a_wrong_scenario_ends_with_code_2(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "a.sim.yaml"
    path.write_text("version: 2\n")
    with pytest.raises(SystemExit) as end:
        main(["--scenario", str(path)])
    assert end.value.code == 2
    assert f"{path}:1:10" in capsys.readouterr().err


def test_the_version_needs_no_scenario_and_no_port(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as end:
        main(["--version"])
    assert end.value.code == 0
    assert capsys.readouterr().out == f"sitl {metadata.version('mav-companion')}\n"


def test_a_machine_without_jsbsim(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("sitl.installed.find_spec", lambda name: None)
    with pytest.raises(SystemExit) as end:
        main([])
    assert end.value.code == 2
    assert "pip install jsbsim" in capsys.readouterr().err


@pytest.fixture
def instance() -> int:
    """One whose local ports are free."""
    for number in range(100, 200):
        try:
            Server(number).close()
        except LinkError:
            continue
        return number
    raise AssertionError("no free ports")


def test_the_server_answers_whoever_speaks_and_ignores_deaf_peers(instance: int) -> None:
    with (
        Server(instance) as server,
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as client,
    ):
        server.send([(LinkName.GCS, b"nobody")] * 3)  # ECONNREFUSED comes back to the socket
        client.bind(("127.0.0.1", 0))
        client.settimeout(60.0)
        client.sendto(b"hello", ("127.0.0.1", LOCAL_PORTS[LinkName.OFFBOARD] + instance))
        assert server.receive(60.0) == [(LinkName.OFFBOARD, b"hello")]
        server.send([(LinkName.OFFBOARD, b"answer")])
        assert client.recvfrom(100)[0] == b"answer"


def test_the_server_takes_in_so_much_at_once_and_nothing_that_is_too_long(instance: int) -> None:
    with Server(instance) as server:
        senders = [socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in range(2)]
        with closing(senders[0]), closing(senders[1]):
            address = ("127.0.0.1", LOCAL_PORTS[LinkName.OFFBOARD] + instance)
            senders[0].sendto(bytes(65_507), address)
            for _ in range(STRANGERS_FRAMES):  # the first one makes it the peer
                senders[0].sendto(b"flood", address)
            senders[1].sendto(b"one", address)
            received = [datagram for _, datagram in server.receive(60.0)]
            assert received.count(b"flood") == SENDER_FRAMES
            assert b"one" in received and bytes(LONGEST + 1) not in received


def test_a_taken_port_is_told(instance: int) -> None:
    with Server(instance), pytest.raises(LinkError, match="choose another instance"):
        Server(instance)


@pytest.mark.parametrize("kind", ["unix", "udpin"])
def test_reports_arrive_where_the_companion_listens_and_else_are_lost(
    kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    address = "unix:events" if kind == "unix" else f"udpin:127.0.0.1:{port}"
    with closing(ReportSender(address)) as sender:
        sender.send([b"nobody hears it"] * 2)
        with closing(ReportPort(address)) as heard:
            sender.send([b"first", b"second"])
            assert heard.receive() == [b"first", b"second"]
        sender.send([b"nobody hears it any more"] * 2)


@pytest.mark.parametrize("address", ["udpout:127.0.0.1:9", "unix:", "udpin:here", "udpin::70000"])
def test_a_wrong_address_of_reports_ends_with_an_advice(
    address: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as end:
        main(["--reports", address, "-i", "199"])
    assert end.value.code == LinkError("").exit_code
    assert "write unix:PATH or udpin:HOST:PORT" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("happens", "is_told"), [("report: {alarm: 1}", True), ("wind: {east_mps: 2}", False)]
)
def test_reports_that_nobody_gets_are_told_at_the_start(
    happens: str,
    is_told: bool,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    instance: int,
) -> None:
    path = tmp_path / "a.sim.yaml"
    path.write_text(f"version: 1\nhappens:\n  - {{at_s: 900, {happens}}}\n")
    monkeypatch.setattr("sitl.cli._Stop", lambda is_attended: SimpleNamespace(is_set=True))
    with pytest.raises(SystemExit) as end:
        main(["--scenario", str(path), "-i", str(instance)])
    assert end.value.code == 0
    assert ("--reports says where" in capsys.readouterr().out) is is_told
