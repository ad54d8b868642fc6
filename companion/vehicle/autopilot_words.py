"""Reads what the autopilot says in words: STATUSTEXT, EVENT, and the report of its arming checks.

PX4 sends STATUSTEXT only on links where it hears a ground station's heartbeat, but EVENT on all. An
EVENT carries a number. The words for it are in metadata, which is fetched after the first event was
heard, while the vehicle stands disarmed (metadata_fetch.py).

Rules:
1. Anything below a warning is dropped. Events of the arming checks form a report; the newest report
   is told when arming is refused (arming_report.py). The companion asks for the report once.
2. What comes both ways is told once: PX4 appends a tab to a text that also comes as an event, and a
   text is not repeated within REPEAT_S.
3. Until it is clear whether words can be had, the newest events wait. Without words an event is
   told by its number, but is no news: checks of other modes cannot be told apart.
4. What was said more than LATELY_S ago does not explain a refusal.
5. What is said in flight is news, at most MOST_NEWS in NEWS_S.
6. An event that leaves its reason to the report is told together with the report's errors for the
   present mode. "Failsafe warning:" without a reason is dropped: PX4 v1.18 sends it after each
   landing.
"""

from __future__ import annotations

import math
from collections import deque
from typing import NamedTuple

from companion.errors import printable
from companion.mavlink.event_metadata import MOST_TEXT
from companion.mavlink.event_sequence import EventSequence
from companion.mavlink.framing import Message, dialect
from companion.mavlink.statustext import CHUNK_BYTES
from companion.vehicle.arming_report import WARNING, ArmingReport
from companion.vehicle.metadata_fetch import MetadataFetch
from companion.vehicle.wire import COMPONENT

MAX_TEXTS = 5
MOST_REASONS = 4
LATELY_S = 30.0
REPEAT_S = 10.0
MOST_NEWS, NEWS_S = 10, 10.0
MOST_WAITING = 64
REPORT_S, REPORT_TIMES = 1.0, 5
_GROUP, _EXPLAINED = "default", "append_health_and_arming_messages"
_ADDRESSED = frozenset({"FILE_TRANSFER_PROTOCOL", "RESPONSE_EVENT_ERROR"})

SPOKEN = frozenset(
    {"STATUSTEXT", "EVENT", "CURRENT_EVENT_SEQUENCE", "COMPONENT_METADATA"} | _ADDRESSED
)
"""The messages that are read here; each says something new, in whatever order they arrive."""


class _Event(NamedTuple):
    """The parts of an EVENT that are used here."""

    number: int
    level: int
    arguments: bytes


class AutopilotWords:
    """What one autopilot says.

    Attributes:
        custom_mode: that of its newest heartbeat.
    """

    def __init__(self) -> None:
        self.custom_mode = 0
        self._news: deque[str] = deque(maxlen=MOST_NEWS)
        self._said: deque[tuple[float, str]] = deque(maxlen=MAX_TEXTS)
        self._fetch = MetadataFetch()
        self._report = ArmingReport()
        self._sequence = EventSequence[_Event]()
        self._waiting: deque[_Event | None] = deque(maxlen=MOST_WAITING)
        self._chunks: tuple[int, str] = (0, "")
        self._is_flown = False
        self._news_s: deque[float] = deque([-math.inf] * MOST_NEWS, maxlen=MOST_NEWS)
        self._reports_asked = 0
        self._next_report_s = -math.inf

    def take(self, now_s: float, message: Message) -> None:
        """Takes one of the autopilot's messages in `SPOKEN`."""
        kind = message.get_type()
        if kind in _ADDRESSED and message.target_component not in (0, COMPONENT):
            return
        match kind:
            case "STATUSTEXT":
                self._take_text(now_s, message)
            case "EVENT":
                level = message.log_levels & 0xF  # for people; the other half is for logs
                event = _Event(message.id, level, bytes(message.arguments))
                self._sequence.take(message.sequence, event)
            case "CURRENT_EVENT_SEQUENCE":
                self._sequence.take_newest(message.sequence, bool(message.flags & 1))
            case "RESPONSE_EVENT_ERROR":
                self._sequence.pass_over(message.sequence)
            case _:
                self._fetch.take(now_s, message)
        self._take_events(now_s)

    def due(self, now_s: float, target: tuple[int, int], is_flown: bool) -> list[Message]:
        """The requests to send now.

        Args:
            target: system and component of the autopilot.
            is_flown: the vehicle is armed or in the air, so no metadata is fetched.
        """
        self._is_flown = is_flown
        questions: list[Message] = []
        if (lost := self._sequence.due(now_s)) is not None:
            questions.append(dialect.MAVLink_request_event_message(*target, *lost))
        if is_flown:
            self._fetch.interrupt()
        elif self._sequence.has_begun:
            questions += self._fetch.due(now_s, target)
            questions += self._ask_for_report(now_s, target)
        self._take_events(now_s)
        return questions

    def lately(self, now_s: float) -> list[str]:
        """What was said within LATELY_S, oldest first."""
        return [text for said_s, text in self._said if now_s - said_s <= LATELY_S]

    def take_news(self) -> list[str]:
        """What was said in flight since the last call."""
        news = list(self._news)
        self._news.clear()
        return news

    def why_not_armed(self, now_s: float) -> list[str]:
        """What prevents arming in the present mode, and what was said lately."""
        reasons = self._report.reasons(self._group)[:MOST_REASONS]
        said = [text for text in self.lately(now_s) if not any(r in text for r in reasons)]
        return reasons + said

    @property
    def _group(self) -> int | None:
        """The report's group of modes that the present mode belongs to; None where it is not
        known."""
        metadata = self._fetch.metadata
        return metadata.mode_groups.get(self.custom_mode) if metadata else None

    # -- in ------------------------------------------------------------------------------------

    def _take_text(self, now_s: float, message: Message) -> None:
        """Takes a STATUSTEXT, or one chunk of a long one."""
        text, number = message.text, message.id
        if number:
            before = self._chunks[1] if self._chunks[0] == number and message.chunk_seq else ""
            text = (before + text)[:MOST_TEXT]
            self._chunks = (number, text)
            if len(message.text.encode()) >= CHUNK_BYTES:
                return
        has_event = text.endswith("\t") and self._fetch.metadata is not None
        if message.severity <= WARNING and not has_event:
            self._say(now_s, text)

    def _take_events(self, now_s: float) -> None:
        """Handles events in order; they wait until it is clear whether their words can be had."""
        self._waiting += self._sequence.ready()
        if self._fetch.metadata is not None or self._fetch.has_given_up:
            while self._waiting:
                self._take_event(now_s, self._waiting.popleft())

    def _take_event(self, now_s: float, event: _Event | None) -> None:
        """Handles the next event; None stands for one that is lost."""
        if event is None:
            self._report.lose()
            return
        metadata = self._fetch.metadata
        definition = metadata.events.get(event.number) if metadata is not None else None
        if definition is None:
            if event.level <= WARNING:
                self._keep(now_s, f"event {event.number} (its words are not known)")
            return
        text = definition.in_words(event.arguments)
        arguments = definition.arguments(event.arguments)
        if self._report.take(definition, event.level, text, arguments):
            return
        if definition.group == _GROUP and event.level <= WARNING:
            self._say(now_s, self._explained(text) if definition.type == _EXPLAINED else text)

    def _explained(self, text: str) -> str:
        """Applies rule 6; returns "" if there is nothing to tell."""
        if reasons := self._report.errors(self._group)[:MOST_REASONS]:
            return f"{text.removesuffix(':')}: {', '.join(reasons)}"
        return "" if text.endswith(":") else text

    def _say(self, now_s: float, text: str) -> None:
        """Keeps a text, and applies rule 5."""
        if self._keep(now_s, text) and self._is_flown and now_s - self._news_s[0] > NEWS_S:
            self._news_s.append(now_s)
            self._news.append(self._said[-1][1])

    def _keep(self, now_s: float, text: str) -> bool:
        """Applies rules 2 and 4; returns whether the text is kept."""
        text = printable(" ".join(text.rstrip("\0").split()))
        if not text or any(now_s - s <= REPEAT_S and text == said for s, said in self._said):
            return False
        others = [(said_s, said) for said_s, said in self._said if said != text]
        self._said = deque([*others, (now_s, text)], maxlen=MAX_TEXTS)
        return True

    def _ask_for_report(self, now_s: float, target: tuple[int, int]) -> list[Message]:
        """Requests the arming checks until a report is heard; PX4 reports later changes unasked."""
        is_needed = self._fetch.metadata is not None and not self._report.is_known
        if not is_needed or self._reports_asked >= REPORT_TIMES or now_s < self._next_report_s:
            return []
        self._reports_asked += 1
        self._next_report_s = now_s + REPORT_S
        nothing = (0.0,) * 7
        command = dialect.MAV_CMD_RUN_PREARM_CHECKS
        return [dialect.MAVLink_command_long_message(*target, command, 0, *nothing)]
