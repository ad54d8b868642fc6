"""What is quoted from outside cannot steer a terminal, wherever it is told."""

from __future__ import annotations

import logging
import unicodedata
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from companion.cli.log_lines import UnblockingHandler
from companion.cli.terminal import Terminal
from companion.errors import CompanionError, FormulaError, LinkError, MissionError, printable
from companion.ground.texts import StatusTextQueue
from companion.ground.watching import StatusTextAssembler
from companion.ltl.parser import parse
from companion.mavlink.framing import MavlinkCodec, dialect
from companion.mission.loader import load_mission
from companion.vehicle.endpoints import parse_url
from companion.vehicle.telemetry import Telemetry

ESCAPE = "\x1b[2J\x9b31m\r\x07\x7f"
ESCAPED = r"\x1b[2J\x9b31m\x0d\x07\x7f"


def is_harmless(text: str) -> bool:
    return not [c for c in text if unicodedata.category(c) == "Cc" and c not in "\t\n"]


@given(st.text())
def test_what_is_printable_stays_and_the_rest_can_still_be_told_apart(text: str) -> None:
    shown = printable(text)
    assert is_harmless(shown) and printable(shown) == shown
    assert (shown == text) == is_harmless(text)


@pytest.mark.parametrize(
    "error",
    [
        CompanionError(ESCAPE),
        MissionError(f"an unknown key {ESCAPE}", hint=f"one line {ESCAPE}\nand another"),
        FormulaError(f"what {ESCAPE}", f"F {ESCAPE} p", 2, len(ESCAPE), hint=ESCAPE),
    ],
    ids=lambda error: type(error).__name__,
)
def test_no_error_has_control_characters(error: CompanionError) -> None:
    assert is_harmless(str(error)) and ESCAPED in str(error)


def test_the_caret_stays_under_the_token() -> None:
    for text in (f"F {ESCAPE}p", f"G '{ESCAPE}' & & p", f"F at({ESCAPE})", "F p & \x1b q"):
        with pytest.raises(FormulaError) as error:
            parse(text)
        _, line, caret = str(error.value).splitlines()
        start, end = caret.index("^"), caret.rindex("^") + 1
        at, length = error.value.offset, error.value.length
        assert line[start:end] == printable(text[at : at + length])


def test_neither_files_nor_urls_steer_the_terminal(tmp_path: Path) -> None:
    path = tmp_path / f"a{ESCAPE}.yaml"
    for text in (None, f'version: "{ESCAPE}"', 'name: "a\\e[2Jb"', f"version: 1\nna{ESCAPE}me: a"):
        if text is not None:
            path.write_text(text, encoding="utf-8")
        with pytest.raises(MissionError) as error:
            load_mission(path)
        assert is_harmless(str(error.value))
    with pytest.raises(LinkError) as refused:
        parse_url(f"udp:{ESCAPE}")
    assert is_harmless(str(refused.value))


def test_texts_of_the_wire_are_printable() -> None:
    said = MavlinkCodec(1, 1).pack(dialect.MAVLink_statustext_message(3, f"no {ESCAPE}".encode()))
    (message,) = MavlinkCodec(0, 0).parse(said)
    telemetry = Telemetry()
    telemetry.take(0.0, message)
    said_lately = telemetry.words.lately(0.0)
    assert all(map(is_harmless, said_lately)) and said_lately
    (line,) = StatusTextAssembler().take(f"no {ESCAPE}", 0, 0)
    assert line == f"no {ESCAPED}"
    texts = StatusTextQueue()
    texts.tell(0.0, 0, f"one {ESCAPE}\ntwo")
    assert b"".join(bytes(m._text_raw) for m in texts.rest()) == f"one {ESCAPED}; two".encode()


def test_lines_of_flights_and_of_logs_are_printable(capfd: pytest.CaptureFixture[str]) -> None:
    terminal = Terminal()
    terminal.say(f"mission {ESCAPE}")
    terminal.close()
    record = logging.LogRecord("companion", logging.DEBUG, "", 0, "heard %s", (ESCAPE,), None)
    UnblockingHandler().emit(record)
    printed = capfd.readouterr()
    assert printed.out == f"mission {ESCAPED}\n"
    assert printed.err == f"heard {ESCAPED}\n"
