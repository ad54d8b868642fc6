"""Nothing is read or written outside the root, and there is an end to what fits into it."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable
from pathlib import Path

import pytest
from ftp_client import Client, pack, unpack
from hypothesis import given
from hypothesis import strategies as st

from companion.ground.ftp import FtpServer
from companion.ground.mission_store import (
    MAX_FILES,
    MAX_FOLDERS,
    MAX_TOTAL_BYTES,
    VERDICT,
    MissionStore,
)
from companion.mavlink.ftp_frames import FtpRefusal, Nak, Opcode

SECRET = b"SECRET-OUTSIDE"
NASTY = (
    "../outside/secret.yaml",
    "/../outside/secret.yaml",
    "a/../../outside/secret.yaml",
    "..\\outside\\secret.yaml",
    "../incoming_x/secret.yaml",
    "link.yaml",
    "linked/secret.yaml",
    "a.yaml\0../outside/secret.yaml",
    "./a.yaml",
    ".new",
    "-rf.yaml",
    "a\n.yaml",
    "ä.yaml",
    "x" * 65 + ".yaml",
    "pipe.yaml",
    "1/2/3/4/a.yaml",
)


@pytest.fixture
def store(tmp_path: Path) -> MissionStore:
    return with_surroundings(tmp_path)


def with_surroundings(folder: Path) -> MissionStore:
    """A store beside files that are none of its business, and with ways to them in it."""
    store = MissionStore(folder / "incoming")
    for name in ("outside", "incoming_x"):
        (folder / name).mkdir()
        (folder / name / "secret.yaml").write_bytes(SECRET)
    (store.root / "link.yaml").symlink_to(folder / "outside" / "secret.yaml")
    (store.root / "linked").symlink_to(folder / "outside")
    os.mkfifo(store.root / "pipe.yaml")
    store.write("a.yaml", b"inside")
    return store


def surroundings(store: MissionStore) -> dict[str, bytes]:
    folder = store.root.parent
    return {
        str(path.relative_to(folder)): path.read_bytes()
        for path in folder.rglob("*")
        if path.is_file() and not path.is_relative_to(store.root)
    }


@pytest.mark.parametrize("path", NASTY)
def test_no_path_leads_out(store: MissionStore, path: str) -> None:
    before = surroundings(store)
    for attempt in (
        lambda: store.read(path),
        lambda: store.write(path, b"broken"),
        lambda: store.entries(path),
        lambda: store.make_folder(f"{path}/new"),
        lambda: store.rename("a.yaml", path),
        lambda: store.remove_folder(path),
    ):
        with pytest.raises(FtpRefusal):
            attempt()
    assert surroundings(store) == before
    assert store.entries("/") == ["Fa.yaml\t6"]


names = st.sampled_from([*NASTY, "a.yaml", "b.yaml", "maps", "maps/a.yaml", "/", "", VERDICT])
requests = st.one_of(
    st.binary(max_size=260),
    st.builds(
        pack,
        st.integers(0, 65535),
        st.integers(0, 20),
        st.one_of(
            st.binary(max_size=239),
            names.map(str.encode),
            st.tuples(names, names).map(lambda pair: "\0".join(pair).encode()),
        ),
        session=st.integers(0, 3),
        offset=st.one_of(st.integers(0, 300), st.integers(0, 2**32 - 1)),
        size=st.one_of(st.none(), st.integers(0, 255)),
    ),
)


@pytest.mark.slow
@given(st.lists(st.tuples(st.floats(0, 40), st.integers(1, 3), requests), max_size=30))
def test_any_bytes_are_answered_and_touch_nothing_outside(
    asked: list[tuple[float, int, bytes]],
) -> None:
    with tempfile.TemporaryDirectory() as folder:
        store = with_surroundings(Path(folder))
        server, now_s = FtpServer(store), 0.0
        before = surroundings(store)
        for passed_s, system, payload in asked:
            now_s += passed_s
            replies = server.receive(now_s, (system, 190), payload)
            is_request = len(payload) >= 12 and payload[3] < 128
            assert bool(replies) == is_request
            for nth, reply in enumerate(map(unpack, replies)):
                assert reply.sequence == (int.from_bytes(payload[:2], "little") + 1 + nth) % 65536
                assert SECRET not in reply.data
        assert surroundings(store) == before
        assert len([p for p in store.root.rglob("*") if p.is_file()]) <= MAX_FILES + 1


def test_files_folders_and_bytes_have_a_limit(store: MissionStore) -> None:
    client = Client(FtpServer(store))
    for i in range(MAX_FILES - 1):
        store.write(f"{i}.yaml", b"x")
    assert client.ask(Opcode.CREATE_FILE, "more.yaml").nak is Nak.FAIL_ERRNO
    store.write("0.yaml", b"replaced")  # is no more
    store.remove("1.yaml")
    store.write("more.yaml", b"x")
    for i in range(MAX_FOLDERS):
        assert client.ask(Opcode.CREATE_DIRECTORY, f"f{i}").nak is None
    assert client.ask(Opcode.CREATE_DIRECTORY, "more").nak is Nak.FAIL_ERRNO


def test_all_files_together_have_a_limit(store: MissionStore) -> None:
    part = bytes(256 * 1024)
    for i in range(MAX_TOTAL_BYTES // len(part) - 1):
        store.write(f"{i}.pgm", part)
    with pytest.raises(FtpRefusal) as refused:
        store.write("more.pgm", part)
    assert refused.value.nak is Nak.FAIL_ERRNO
    with pytest.raises(FtpRefusal):
        store.write("large.pgm", part + b"x")


def test_the_verdict_is_read_only(store: MissionStore) -> None:
    store.publish(b"{}")
    assert store.read(VERDICT) == b"{}"
    attempts: list[Callable[[], object]] = [
        lambda: store.write(VERDICT, b"x"),
        lambda: store.remove(VERDICT),
        lambda: store.rename(VERDICT, "a2.yaml"),
        lambda: store.rename("a.yaml", VERDICT),
    ]
    for attempt in attempts:
        with pytest.raises(FtpRefusal) as refused:
            attempt()
        assert refused.value.nak is Nak.FILE_PROTECTED


def test_no_folder_stands_where_the_verdict_will(store: MissionStore) -> None:
    with pytest.raises(FtpRefusal) as refused:
        store.make_folder(VERDICT)
    assert refused.value.nak is Nak.FILE_PROTECTED
    store.publish(b"{}")
    assert store.read(VERDICT) == b"{}"


def test_a_copy_stays_as_it_was(store: MissionStore, tmp_path: Path) -> None:
    store.make_folder("maps")
    store.write("maps/m.yaml", b"old")
    store.publish(b"{}")
    copy = tmp_path / "copy"
    store.copy_to(copy)
    store.write("maps/m.yaml", b"new")
    files = {str(p.relative_to(copy)): p.read_bytes() for p in copy.rglob("*") if p.is_file()}
    assert files == {"a.yaml": b"inside", "maps/m.yaml": b"old"}
