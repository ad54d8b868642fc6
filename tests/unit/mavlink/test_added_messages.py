"""Messages that pymavlink lacks, or has without newer fields, against its own reader of XML."""

from __future__ import annotations

from pathlib import Path

import pytest
from pymavlink.dialects.v20 import common as pymavlinks
from pymavlink.generator import mavparse

from companion.mavlink.added_messages import DEFINITIONS
from companion.mavlink.framing import MavlinkCodec, decode, dialect

COMMON = """<?xml version="1.0"?>
<mavlink><version>3</version><messages>
<message id="42" name="MISSION_CURRENT"><description/>
  <field type="uint16_t" name="seq"/>
  <extensions/>
  <field type="uint16_t" name="total"/>
  <field type="uint8_t" name="mission_state"/>
  <field type="uint8_t" name="mission_mode"/>
  <field type="uint32_t" name="mission_id"/>
  <field type="uint32_t" name="fence_id"/>
  <field type="uint32_t" name="rally_points_id"/>
</message>
<message id="397" name="COMPONENT_METADATA"><description/>
  <field type="uint32_t" name="time_boot_ms" units="ms"/>
  <field type="uint32_t" name="file_crc"/>
  <field type="char[100]" name="uri"/>
</message>
<message id="410" name="EVENT"><description/>
  <field type="uint8_t" name="destination_component"/>
  <field type="uint8_t" name="destination_system"/>
  <field type="uint32_t" name="id"/>
  <field type="uint32_t" name="event_time_boot_ms" units="ms"/>
  <field type="uint16_t" name="sequence"/>
  <field type="uint8_t" name="log_levels"/>
  <field type="uint8_t[40]" name="arguments"/>
</message>
<message id="411" name="CURRENT_EVENT_SEQUENCE"><description/>
  <field type="uint16_t" name="sequence"/>
  <field type="uint8_t" name="flags"/>
</message>
<message id="412" name="REQUEST_EVENT"><description/>
  <field type="uint8_t" name="target_system"/>
  <field type="uint8_t" name="target_component"/>
  <field type="uint16_t" name="first_sequence"/>
  <field type="uint16_t" name="last_sequence"/>
</message>
<message id="413" name="RESPONSE_EVENT_ERROR"><description/>
  <field type="uint8_t" name="target_system"/>
  <field type="uint8_t" name="target_component"/>
  <field type="uint16_t" name="sequence"/>
  <field type="uint16_t" name="sequence_oldest_available"/>
  <field type="uint8_t" name="reason"/>
</message>
</messages></mavlink>
"""


@pytest.fixture(scope="module")
def common(tmp_path_factory: pytest.TempPathFactory) -> mavparse.MAVXML:
    path: Path = tmp_path_factory.mktemp("xml") / "common.xml"
    path.write_text(COMMON)
    return mavparse.MAVXML(str(path), mavparse.PROTOCOL_2_0)


def test_layout_and_checksum_are_those_of_the_generator(common: mavparse.MAVXML) -> None:
    assert [d.number for d in DEFINITIONS] == sorted(common.message_crcs)
    for message in common.message:
        kind = dialect.mavlink_map[message.id]
        assert kind.msgname == message.name
        assert kind.crc_extra == common.message_crcs[message.id]
        assert kind.fieldnames == message.fieldnames
        assert kind.ordered_fieldnames == message.ordered_fieldnames
        assert kind.unpacker.size == message.wire_length
        assert kind.array_lengths == [field.array_length for field in message.ordered_fields]


def test_fields_are_given_by_place_or_by_name() -> None:
    kind = dialect.MAVLink_current_event_sequence_message
    assert (kind(7, 1).sequence, kind(sequence=7, flags=1).flags) == (7, 1)
    with pytest.raises(TypeError, match="has no number"):
        kind(7, 1, number=3)


def test_pymavlink_s_own_dialect_stays_as_it_is() -> None:
    for definition in DEFINITIONS:
        kind = dialect.mavlink_map[definition.number]
        assert pymavlinks.mavlink_map.get(definition.number) is not kind
    assert not hasattr(pymavlinks, "MAVLink_event_message")


def test_extensions_may_be_missing_and_pymavlink_reads_the_rest() -> None:
    short = decode(MavlinkCodec(1, 1).pack(pymavlinks.MAVLink_mission_current_message(3, 9, 1, 2)))
    assert short is not None
    assert (short.seq, short.total, short.mission_mode, short.fence_id) == (3, 9, 2, 0)
    frame = MavlinkCodec(1, 1).pack(dialect.MAVLink_mission_current_message(3, fence_id=7))
    assert getattr(decode(frame), "fence_id", None) == 7
    assert pymavlinks.MAVLink(None).parse_buffer(frame)[0].seq == 3
