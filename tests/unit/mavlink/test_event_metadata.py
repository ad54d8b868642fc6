"""The rules of event metadata as cases of our own, and files that nobody should have written."""

from __future__ import annotations

import json
import lzma
import struct
from typing import Any

import pytest
from drawn import drawn
from hypothesis import example, given
from hypothesis import strategies as st

from companion.mavlink.event_metadata import (
    MOST_BYTES,
    MOST_TEXT,
    EventMetadata,
    MetadataError,
    events_file,
    read_events,
)

ENUMS = {
    "reason_t": {
        "type": "uint8_t",
        "entries": {"0": {"name": "none", "description": "nothing"}, "7": {"name": "seven"}},
    },
    "parts_t": {
        "type": "uint16_t",
        "is_bitfield": True,
        "separator": ", ",
        "entries": {
            "1": {"name": "a", "description": "arms"},
            "4": {"name": "m", "description": "motors"},
        },
    },
}


def file_with(message: str, types: list[str], **more: Any) -> dict[str, Any]:
    """Metadata of one event, 1:5, with an argument of each type."""
    arguments = [{"name": f"a{i}", "type": of_type} for i, of_type in enumerate(types)]
    event = {"name": "one", "message": message, "arguments": arguments} | more
    own = {"namespace": "own", "event_groups": {"default": {"events": {"5": event}}}}
    return {"version": 2, "components": {"0": {"namespace": "all", "enums": ENUMS}, "1": own}}


def read(about: dict[str, Any]) -> EventMetadata:
    return read_events(json.dumps(about).encode())


def told(message: str, types: list[str], layout: str, *values: float) -> str:
    definition = read(file_with(message, types)).events[1 << 24 | 5]
    return definition.in_words(struct.pack("<" + layout, *values).ljust(40, b"\0"))


@pytest.mark.parametrize(
    ("message", "types", "layout", "values", "text"),
    [
        ("Low battery", [], "", (), "Low battery"),
        ("{1} {2} {3}", ["uint8_t", "int8_t", "uint16_t"], "BbH", (200, -3, 60000), "200 -3 60000"),
        ("{2}, {1}", ["int64_t", "uint64_t"], "qQ", (-(2**60), 2**63), f"{2**63}, {-(2**60)}"),
        ("{1:.2}", ["float"], "f", (3.14159,), "3.14"),
        ("{1:.0} s", ["float"], "f", (4.6,), "5 s"),
        ("{1}", ["float"], "f", (0.5,), "0.5"),
        ("{1}", ["float"], "f", (float("nan"),), "nan"),
        ("up {1:.1m_v} of {2m}", ["float", "int32_t"], "fi", (2.25, 10), "up 2.2 m of 10 m"),
        ("{1:.1m/s} {1m^2} {1C}", ["float"], "f", (2.0,), "2.0 m/s 2 m^2 2 C"),
        ("{1:.1}%", ["float"], "f", (81.26,), "81.3%"),
        ("{1}", ["all::reason_t"], "B", (0,), "nothing"),
        ("{1}", ["all::reason_t"], "B", (7,), "seven"),
        ("{1}", ["all::reason_t"], "B", (9,), "(unknown: 9)"),
        ("{1}!", ["all::parts_t"], "H", (5,), "arms, motors!"),
        ("{1}!", ["all::parts_t"], "H", (0,), "!"),
        ("{1}", ["all::parts_t"], "H", (6,), "(unknown: 2), motors"),
        (r"a \< b, \{1}, \\", ["uint8_t"], "B", (1,), r"a < b, {1}, \ "),
        ("set <param>COM_X</param> or <a>px4.io</a>", [], "", (), "set COM_X or px4.io"),
        ('see <a href="https://px4.io">this</a>', [], "", (), "see this"),
        ('a<profile name="dev"> axis {1}</profile>', ["uint8_t"], "B", (1,), "a"),
        ('a <profile name="!dev">axis {1}</profile>', ["uint8_t"], "B", (1,), "a axis 1"),
        ("a <blink>b {1}</blink> c", ["uint8_t"], "B", (1,), "a c"),
        ("{3} {0} {x} <b", ["uint8_t"], "B", (1,), "{3} {0} {x} <b"),
        ("two\n\nlines", [], "", (), "two lines"),
        ("\x1b[2Jred", [], "", (), "\\x1b[2Jred"),
    ],
)
def test_a_message_in_words(
    message: str, types: list[str], layout: str, values: tuple[float, ...], text: str
) -> None:
    assert told(message, types, layout, *values) == text.strip()


def test_an_event_is_found_by_its_component_and_its_number_there() -> None:
    metadata = read(file_with("Low battery", [], type="summary"))
    (number,) = metadata.events
    assert (number >> 24, number & 0xFFFFFF) == (1, 5)
    assert (metadata.events[number].group, metadata.events[number].type) == ("default", "summary")


def test_an_enum_is_looked_for_in_its_own_namespace() -> None:
    about = file_with("{1}", ["reason_t"])
    assert not read(about).events
    about["components"]["1"]["enums"] = ENUMS
    assert read(about).events


def test_modes_have_the_bit_of_their_group() -> None:
    about = file_with("a", [])
    groups = {"groups": {"4": [50593792, 5], "x": [7], "70": [8], "5": 3}}
    about["components"]["1"]["navigation_mode_groups"] = groups
    assert read(about).mode_groups == {50593792: 4, 5: 4}


@pytest.mark.parametrize(
    "spoilt",
    [
        {"message": 3},
        {"name": None},
        {"arguments": [{"type": "void"}]},
        {"arguments": [7]},
        {"arguments": [{"type": "uint64_t"}] * 6},
        {"type": []},
    ],
)
def test_a_spoilt_event_is_left_out_and_the_others_stay(spoilt: dict[str, Any]) -> None:
    about = file_with("good", [])
    events = about["components"]["1"]["event_groups"]["default"]["events"]
    events["6"] = events["5"] | spoilt
    assert [definition.name for definition in read(about).events.values()] == ["one"]


def test_packed_and_plain_are_the_same() -> None:
    raw = json.dumps(file_with("good {1}", ["float"])).encode()
    assert read_events(lzma.compress(raw)) == read_events(raw)


def nested(depth: int) -> bytes:
    return b"[" * depth


@pytest.mark.parametrize(
    "content",
    [
        pytest.param(b" " * (MOST_BYTES + 1), id="too long"),
        pytest.param(lzma.compress(b"{}")[:-9], id="cut off"),
        pytest.param(b"\xfd7zXZ\0 and no more", id="no xz"),
        pytest.param(b"{", id="no JSON"),
        pytest.param(b"\xff", id="no UTF-8"),
        pytest.param(nested(200_000), id="deep"),
        pytest.param(b"1" * 10_000, id="a long number"),
    ],
)
def test_what_cannot_be_read_is_refused(content: bytes) -> None:
    with pytest.raises(MetadataError):
        read_events(content)


@pytest.mark.slow
def test_a_bomb_is_refused() -> None:
    with pytest.raises(MetadataError):
        read_events(lzma.compress(bytes(50_000_000)))


def test_where_the_file_of_events_is() -> None:
    def general(*entries: Any) -> bytes:
        return json.dumps({"metadataTypes": entries}).encode()

    on_board, elsewhere = "mftp://etc/extras/events.json.xz", "https://example.org/events.json.xz"
    parameters = {"type": 1, "uri": "mftp://p"}
    events = {"type": 4, "uri": elsewhere, "uriFallback": on_board}
    assert events_file(general(parameters, events)) == on_board
    assert events_file(general({"type": 4, "uri": elsewhere})) == elsewhere
    for content in (general(), general(parameters), general({"type": 4}), b"[]", b"{}"):
        with pytest.raises(MetadataError, match="names no file"):
            events_file(content)


values = st.recursive(
    st.none()
    | st.booleans()
    | st.integers(-9, 2**65)
    | st.floats()
    | st.text(max_size=8)
    | st.sampled_from(["own::x_t", "x_t", "float", "uint8_t", "summary", "default"]),
    lambda inner: (
        st.lists(inner, max_size=3)
        | st.dictionaries(st.text("0159_", max_size=4), inner, max_size=3)
    ),
    max_leaves=8,
)
KEYS = [
    "type",
    "is_bitfield",
    "separator",
    "entries",
    "message",
    "arguments",
    "name",
    "description",
]
objects = st.dictionaries(st.sampled_from(KEYS), values, max_size=8)
numbers = st.sampled_from(["0", "1", "255", "256", "-1", "x", "\u0663", "9" * 30])
templates = st.text(alphabet='{}<>:.1239m_v/"\\ aprofile=dev!', max_size=60)
events = objects | st.fixed_dictionaries(
    {
        "name": st.just("e"),
        "message": templates,
        "arguments": st.lists(
            st.fixed_dictionaries(
                {"type": st.sampled_from(["x_t", "float", "int8_t", "own::x_t"])}
            ),
            max_size=4,
        ),
    }
)
groups = st.dictionaries(
    st.text(max_size=3),
    st.fixed_dictionaries({"events": st.dictionaries(numbers, events, max_size=3)}) | values,
    max_size=2,
)
components = st.fixed_dictionaries(
    {
        "namespace": st.just("own") | values,
        "enums": st.fixed_dictionaries({"x_t": objects}) | values,
        "event_groups": groups | values,
        "navigation_mode_groups": st.fixed_dictionaries(
            {"groups": st.dictionaries(numbers, values, max_size=3) | values}
        )
        | values,
    }
)
files = st.fixed_dictionaries({"components": st.dictionaries(numbers, components, max_size=3)})


@drawn(50)
@given(files | values, st.binary(max_size=45))
def test_no_file_and_no_arguments_raise(about: Any, raw: bytes) -> None:
    metadata = read_events(json.dumps(about).encode())
    for definition in metadata.events.values():
        assert len(definition.in_words(raw)) <= MOST_TEXT
        assert len(definition.arguments(raw)) == len(definition.choices)


@given(st.binary(max_size=200))
@example(b"\xfd7zXZ\0\0\4")
def test_no_bytes_raise_anything_else(raw: bytes) -> None:
    try:
        read_events(raw)
        events_file(raw)
    except MetadataError:
        pass
