"""The sender's side of the command protocol: repeats a command until its final answer. No I/O.

Rules (https://mavlink.io/en/services/command.html):
1. A command is repeated every 0.5 s until it is answered, with `confirmation` counted up.
2. No answer at all within 5 s is a failure.
3. IN_PROGRESS extends the wait to 10 s from the last one. The command is not repeated then, as it
   might take effect twice.
4. After TEMPORARILY_REJECTED the command is tried again after 1 s, at most ten times. If it comes
   after IN_PROGRESS, it answers an earlier repetition of ours, and changes nothing.
5. ACCEPTED is success. Every other result is final and a failure.
6. If the sender gives a time for the final answer, that time replaces the 5 s, the 10 s and the ten
   tries: it is waited for whatever is heard meanwhile.
7. A sender that is interrupted leaves its command, and may come back to it. Meanwhile the command
   is not sent; its time passes, and its answer counts.
8. While a component still works on an abandoned command (IN_PROGRESS), no other command with the
   same number is sent to it, and that one's time does not pass. It might take effect twice, and the
   answer to the first would be taken for its own.

An answer belongs to the command with that number that was sent to the component last. A second
answer may follow (PX4 accepts DO_SET_MODE at once and refuses it 10 ms later), so an accepted
command still listens: a later failure replaces the success.
"""

from __future__ import annotations

import logging
import math
from dataclasses import dataclass

from companion.mavlink.framing import Message, dialect, source
from companion.outcomes import Refusal

RESEND_S = 0.5
SILENCE_S = 5.0
PROGRESS_S = 10.0
REJECTION_PAUSE_S = 1.0
MAX_REJECTIONS = 10
CANCELLED = 6  # MAV_RESULT_CANCELLED of common.xml, which the dialect lacks

Parameters = tuple[float, float, float, float, float, float, float]
"""param1 to param7 of COMMAND_LONG."""

log = logging.getLogger(__name__)


@dataclass
class Exchange:
    """One command under way.

    Attributes:
        timeout_s: the sender's time for the final answer; None for rules 2 to 4.
        result: name of the final MAV_RESULT without its prefix; None while there is none,
            "NO_ANSWER" for silence, "REFUSED" if the command is not sent at all.
        refusal: why it is not sent.
        is_left: nobody waits for it now (rule 7).
    """

    system: int
    component: int
    command: int
    parameters: Parameters
    next_send_s: float
    timeout_s: float | None = None
    deadline_s: float = math.inf
    confirmation: int = 0
    rejections: int = 0
    result: str | None = None
    is_answered: bool = False
    is_in_progress: bool = False
    refusal: Refusal | None = None
    is_left: bool = False

    @property
    def addressee(self) -> tuple[int, int, int]:
        """The key by which an answer is assigned to the command."""
        return (self.system, self.component, self.command)

    @property
    def has_failed(self) -> bool:
        """Whether there is a final answer other than ACCEPTED."""
        return self.result not in (None, "ACCEPTED")

    @property
    def in_words(self) -> str:
        """The final answer in words."""
        if self.refusal is not None:
            return self.refusal.reason
        if self.result == "NO_ANSWER":
            kind = "final answer" if self.is_in_progress else "answer"
            return f"no {kind}" + ("" if self.timeout_s is None else f" in {self.timeout_s:g} s")
        return (self.result or "no answer yet").replace("_", " ").lower()

    def receive(self, now_s: float, ack: Message) -> None:
        """Takes a COMMAND_ACK for this command."""
        result = result_name(ack.result)
        log.debug("command %d to %d/%d: %s", self.command, self.system, self.component, result)
        if result == "IN_PROGRESS":
            self.is_answered = self.is_in_progress = True
            self._wait(now_s + PROGRESS_S)
        elif result == "TEMPORARILY_REJECTED" and self._may_ask_again:
            if not self.is_in_progress:
                self.rejections += 1
                self.next_send_s = now_s + REJECTION_PAUSE_S
                self._wait(self.next_send_s + SILENCE_S)
        else:
            self.is_answered = True
            self.result = result

    @property
    def _may_ask_again(self) -> bool:
        is_unlimited = self.is_in_progress or self.timeout_s is not None
        return is_unlimited or self.rejections < MAX_REJECTIONS

    def _wait(self, deadline_s: float) -> None:
        """Sets until when to wait for the next answer, unless the sender has given a time."""
        if self.timeout_s is None:
            self.deadline_s = deadline_s

    def start_clock(self, now_s: float) -> None:
        """Counts the time for an answer from now on."""
        patience_s = SILENCE_S if self.timeout_s is None else self.timeout_s
        self.deadline_s = now_s + patience_s

    def due(self, now_s: float) -> Message | None:
        """Returns the COMMAND_LONG to send now, if any."""
        if self.result is not None:
            return None
        if now_s >= self.deadline_s:
            self.result = "NO_ANSWER"
            log.debug("command %d to %d/%d: no answer", self.command, self.system, self.component)
            return None
        if self.is_answered or self.is_left or now_s < self.next_send_s:
            return None
        message = dialect.MAVLink_command_long_message(
            self.system, self.component, self.command, self.confirmation, *self.parameters
        )
        log.debug(
            "command %d to %d/%d: sent, confirmation %d, parameters %s",
            self.command,
            self.system,
            self.component,
            self.confirmation,
            self.parameters,
        )
        self.confirmation = min(255, self.confirmation + 1)
        self.next_send_s = now_s + RESEND_S
        return message


class CommandSender:
    """All commands under way, by the ticket that `start` returned for each."""

    def __init__(self) -> None:
        self._exchanges: dict[int, Exchange] = {}
        self._abandoned: list[Exchange] = []
        self._tickets = 0

    def start(
        self,
        now_s: float,
        target: tuple[int, int],
        command: int,
        parameters: Parameters,
        timeout_s: float | None = None,
    ) -> int:
        """Begins a command to (system, component) and returns its ticket.

        Args:
            timeout_s: time for the final answer; None for the protocol's own times.
        """
        self._tickets += 1
        exchange = Exchange(*target, command, parameters, now_s, timeout_s)
        exchange.start_clock(now_s)
        self._exchanges[self._tickets] = exchange
        return self._tickets

    def refuse(self, ticket: int, refusal: Refusal) -> None:
        """Ends a command before it is sent, as a failure with a reason."""
        exchange = self._exchanges[ticket]
        exchange.result, exchange.refusal = "REFUSED", refusal

    def forget(self, ticket: int) -> None:
        """Drops a command: nothing more is sent, and answers are ignored."""
        self._exchanges.pop(ticket, None)

    def abandon(self, ticket: int) -> None:
        """Drops a command like `forget`, but applies rule 8 while its component works on it."""
        exchange = self._exchanges.pop(ticket, None)
        if exchange is not None and exchange.is_in_progress and exchange.result is None:
            exchange.is_left = True
            self._abandoned.append(exchange)

    def leave(self, ticket: int) -> None:
        """Stops sending a command for now; its answer still counts."""
        self._exchanges[ticket].is_left = True

    def leave_all(self) -> None:
        """Stops sending all commands for now."""
        for exchange in self._exchanges.values():
            exchange.is_left = True

    def come_back(self, ticket: int) -> None:
        """Resumes a command that was left."""
        self._exchanges[ticket].is_left = False

    def __getitem__(self, ticket: int) -> Exchange:
        return self._exchanges[ticket]

    def receive(self, now_s: float, ack: Message) -> None:
        """Passes a COMMAND_ACK to the newest command that it answers."""
        answered = (*source(ack), ack.command)
        sent = [each for _, each in sorted(self._exchanges.items()) if each.confirmation]
        for exchange in reversed([*self._abandoned, *sent]):
            if exchange.addressee == answered:
                exchange.receive(now_s, ack)
                return

    def due(self, now_s: float) -> list[Message]:
        """Returns the messages to send now."""
        for each in self._abandoned:
            each.due(now_s)
        self._abandoned = [each for each in self._abandoned if each.result is None]
        at_work = {each.addressee for each in self._abandoned}
        messages = []
        for exchange in self._exchanges.values():
            has_to_wait = exchange.is_left or exchange.addressee in at_work
            if has_to_wait and not exchange.confirmation:
                exchange.start_clock(now_s)
            elif (message := exchange.due(now_s)) is not None:
                messages.append(message)
        return messages


def result_name(result: int) -> str:
    """Returns the name of a MAV_RESULT without its prefix.

    >>> result_name(2)
    'DENIED'
    """
    if result == CANCELLED:
        return "CANCELLED"
    entry = dialect.enums["MAV_RESULT"].get(result)
    return entry.name.removeprefix("MAV_RESULT_") if entry else f"result {result}"
