"""The simulated autopilot's events: what is told is what their metadata says, as on PX4."""

from __future__ import annotations

import struct

import pytest
from wire import Wire, gcs_heartbeat

from companion.mavlink.event_metadata import EventMetadata, events_file, read_events
from companion.mavlink.framing import dialect
from companion.mavlink.ftp_frames import Opcode, crc32
from companion.mavlink.ftp_reading import FileReading, ReadingState
from sitl.autopilot.arming import REASONS
from sitl.autopilot.failsafes import FailsafeCause
from sitl.autopilot.status_texts import FLOAT, TEMPLATES, Severity, told
from sitl.link.events import DETAILS, GENERAL, KEPT, EventService
from sitl.link.routing import LinkName
from sitl.world.scenario import read_scenario

REFUSED = {"version": 1, "happens": [{"at_s": 1, "arming": {"refused": "no blades"}}]}


def words_of(message: object, metadata: EventMetadata) -> str:
    event = metadata.events[message.id]  # type: ignore[attr-defined]
    return event.in_words(bytes(message.arguments))  # type: ignore[attr-defined]


@pytest.mark.parametrize("template", TEMPLATES)
@pytest.mark.parametrize("word", [*REASONS, *FailsafeCause, "no blades"])
def test_an_event_says_what_the_text_says(template: str, word: str) -> None:
    service = EventService(["no blades"])
    metadata = read_events(service.files[DETAILS])
    arguments = [2.6 if of_type == FLOAT else str(word) for of_type in TEMPLATES[template]]
    text = told(Severity.CRITICAL, template, *arguments)
    assert text.event is not None
    assert words_of(service.told(text.severity, text.event, 1), metadata) == text.text


def read_file(wire: Wire, path: str) -> bytes:
    reading = FileReading(path, 10_000, 7)
    while reading.state is not ReadingState.ENDED:
        before = len(wire.heard)
        for payload in reading.due(wire.now_s):
            wire.send(dialect.MAVLink_file_transfer_protocol_message(0, 1, 1, list(payload)))
        wire.run(0.02)
        for heard in wire.heard[before:]:
            if heard.name == "FILE_TRANSFER_PROTOCOL" and heard.link is wire.link:
                reading.take(bytes(heard.message.payload))
    assert reading.content is not None, reading.why_not
    return reading.content


def test_the_files_are_where_the_autopilot_says() -> None:
    wire = Wire()
    wire.command(dialect.MAV_CMD_REQUEST_MESSAGE, 397)
    wire.run(0.02)
    told_where = wire.last("COMPONENT_METADATA")
    assert told_where.uri == f"mftp://{GENERAL}"
    general = read_file(wire, told_where.uri.removeprefix("mftp://"))
    assert crc32(general) == told_where.file_crc
    assert events_file(general) == f"mftp://{DETAILS}"
    assert read_events(read_file(wire, f"/{DETAILS}")).events


def test_a_burst_has_the_same_parts() -> None:
    wire = Wire()
    content = read_file(wire, DETAILS)
    request = struct.Struct("<HBBBBBxI")
    path = DETAILS.encode()
    for sequence, opcode, data in (
        (1, Opcode.OPEN_FILE_RO, path),
        (2, Opcode.BURST_READ_FILE, b""),
    ):
        head = request.pack(sequence, 0, opcode, len(data) or 239, 0, 0, 0)
        wire.heard.clear()
        payload = (head + data).ljust(251, b"\0")
        wire.send(dialect.MAVLink_file_transfer_protocol_message(0, 1, 1, list(payload)))
    parts, ends = b"", []
    for heard in wire.named("FILE_TRANSFER_PROTOCOL"):
        raw = bytes(heard.message.payload)
        _, _, opcode, size, _, ends_burst, offset = request.unpack_from(raw)
        assert (opcode, offset) == (128, len(parts))
        parts += raw[12 : 12 + size]
        ends.append(ends_burst)
    assert parts == content
    assert ends == [0] * (len(ends) - 1) + [1]


def test_a_report_comes_when_it_changes_and_when_it_is_asked_for() -> None:
    wire = Wire(read_scenario(REFUSED)[0])
    wire.run(0.5)
    assert wire.named("EVENT") == []
    wire.run(1.0)
    metadata = read_events(read_file(wire, DETAILS))
    summary, check, health = (heard.message for heard in wire.named("EVENT"))
    groups = [metadata.events[m.id].group for m in (summary, check, health)]
    assert groups == ["arming_check", "arming_check", "health"]
    assert words_of(check, metadata) == "no blades"
    assert [m.log_levels & 0xF for m in (summary, check, health)] == [8, 2, 8]
    wire.run(3.0)
    assert len(wire.named("EVENT")) == 3
    assert wire.command(dialect.MAV_CMD_RUN_PREARM_CHECKS) == [0]
    assert len(wire.named("EVENT")) == 6


def test_texts_are_for_links_with_a_ground_station_and_events_for_all() -> None:
    wire = Wire(read_scenario(REFUSED)[0])
    wire.run(1.5)
    wire.arm()
    wire.run(0.1)
    assert wire.texts() == wire.texts(LinkName.GCS) == []
    assert len(wire.named("EVENT")) == len(wire.named("EVENT", LinkName.GCS)) == 4
    wire.send(gcs_heartbeat())
    wire.arm()
    wire.run(0.1)
    assert wire.texts() == ["Arming denied: no blades"]


def test_what_was_sent_is_sent_again_while_it_is_kept() -> None:
    wire = Wire()
    for _ in range(KEPT):  # two events each
        wire.command(dialect.MAV_CMD_RUN_PREARM_CHECKS)
    wire.run(4.0)
    newest = wire.last("CURRENT_EVENT_SEQUENCE").sequence
    assert (newest, wire.last("CURRENT_EVENT_SEQUENCE").flags) == (2 * KEPT - 1, 0)
    first = {heard.message.sequence: heard.message for heard in wire.named("EVENT")}
    wire.heard.clear()
    wire.send(dialect.MAVLink_request_event_message(1, 1, newest - 1, newest))
    again = [heard.message for heard in wire.named("EVENT")]
    assert [m.sequence for m in again] == [newest - 1, newest]
    assert all(m.arguments == first[m.sequence].arguments for m in again)
    wire.send(dialect.MAVLink_request_event_message(1, 1, 3, 3))
    error = wire.last("RESPONSE_EVENT_ERROR")
    assert (error.target_system, error.target_component) == (1, 191)
    assert (error.sequence, error.sequence_oldest_available) == (3, newest - KEPT + 1)
    wire.heard.clear()
    wire.send(dialect.MAVLink_request_event_message(1, 1, 0, 65535))
    assert len(wire.named("RESPONSE_EVENT_ERROR")) <= KEPT
