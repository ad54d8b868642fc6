"""Reports of other programs become readings; nothing in a datagram can raise."""

from __future__ import annotations

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from companion.flight_events.reports import ReportRefused, ReportUnknown
from companion.mission.signals import REPORT, Signal
from companion.vehicle.detections import LONGEST, MOST_NAMES_TOLD, Detections

PERSONS, DOOR = Signal(REPORT, "persons", ""), Signal(REPORT, "door", "")


def detections() -> Detections:
    return Detections([PERSONS, DOOR, Signal("NAMED_VALUE_INT", "persons", "value")])


@pytest.mark.parametrize(
    ("datagram", "value"),
    [
        (b'{"persons": 2}', 2.0),
        (b'{"persons": -0.5}', -0.5),
        (b'{"persons": true}', 1.0),
        (b'{"persons": false}', 0.0),
        (b' {"door": 0, "persons": 3} ', 3.0),
        (b'{"persons": 1, "persons": 4}', 4.0),
    ],
)
def test_a_number_or_a_truth_is_a_reading(datagram: bytes, value: float) -> None:
    heard = detections()
    assert dict(heard.read([datagram]))[PERSONS] == value
    assert heard.news() == []


def test_a_program_that_finds_nothing_is_heard() -> None:
    finding = Detections([PERSONS], placed={"persons"})
    assert finding.read([b'{"persons": 0}', b'{"persons": false}']) == [(PERSONS, 0.0)]
    assert finding.take_sightings() == {} and finding.news() == []


def test_of_a_tick_the_last_value_counts() -> None:
    datagrams = [json.dumps({"persons": n}).encode() for n in (1, 5, 3)]
    assert detections().read([*datagrams, b'{"door": true}']) == [(PERSONS, 3.0), (DOOR, 1.0)]


@pytest.mark.parametrize(
    ("datagram", "why"),
    [
        (b'{"persons": NaN}', "persons is neither a number nor a truth value: nan"),
        (b'{"persons": -Infinity}', "persons is neither a number nor a truth value: -inf"),
        (
            b'{"persons": 1' + b"0" * 400 + b"}",
            "persons is neither a number nor a truth value: 1000",
        ),
        (b'{"persons": "two"}', "persons is neither a number nor a truth value: two"),
        (b'{"persons": [2]}', "persons is neither a number nor a truth value: [2]"),
        (b'{"persons": null}', "persons is neither a number nor a truth value: None"),
        (b"[1]", "no JSON object: [1]"),
        (b"2", "no JSON object: 2"),
        (b'{"persons": ', 'no JSON: {"persons": '),
        (b"\xff\x1b[31m", "no JSON: "),
        (b"", "no JSON: "),
        (b"[" * LONGEST, "no JSON"),
        (b" " * (LONGEST + 1), "longer than 1024 bytes"),
    ],
)
def test_what_is_neither_is_refused_in_words(datagram: bytes, why: str) -> None:
    heard = detections()
    assert heard.read([datagram]) == []
    (refused,) = heard.news()
    assert isinstance(refused, ReportRefused)
    assert refused.reason.startswith(why) and refused.number == 1
    assert refused.reason.isprintable()


def test_a_flood_of_refusals_is_told_when_they_have_doubled() -> None:
    heard = detections()
    told = []
    for _ in range(100):
        heard.read([b"no"])
        told += [event.number for event in heard.news() if isinstance(event, ReportRefused)]
    assert told == [1, 2, 4, 8, 16, 32, 64]


def test_a_name_that_is_not_asked_for_is_told_once_and_not_without_end() -> None:
    heard = detections()
    assert heard.read([b'{"dogs": 1}', b'{"dogs": 2}']) == []
    assert heard.news() == [ReportUnknown("dogs", ("door", "persons"))]
    heard.read([json.dumps({f"n{n}": 1}).encode() for n in range(100)])
    assert len(heard.news()) == MOST_NAMES_TOLD - 1


@given(st.lists(st.binary(max_size=40) | st.text(max_size=40).map(str.encode), max_size=10))
def test_any_bytes_are_readings_or_nothing(datagrams: list[bytes]) -> None:
    assert all(signal in (PERSONS, DOOR) for signal, _ in detections().read(datagrams))


json_values = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner),
    max_leaves=5,
)


@given(st.dictionaries(st.sampled_from(["persons", "door", "x"]), json_values))
def test_any_object_gives_its_finite_numbers(report: dict[str, object]) -> None:
    readings = dict(detections().read([json.dumps(report).encode()]))
    for signal in (PERSONS, DOOR):
        value = report.get(signal.instance)
        is_number = isinstance(value, int | float) and abs(value) < 1e300
        assert (signal in readings) >= is_number
        if signal in readings:
            assert readings[signal] == value
