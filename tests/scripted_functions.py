"""Functions of packages that do what a test says: fulfils `acting.function_port.FunctionPort`."""

from __future__ import annotations

from collections.abc import Iterable

from companion.outcomes import Failed
from companion.skills.calls import Answer, CallRequest, CommandAsked, Function, Returned


class ScriptedFunctions:
    """Answers as a script says, the n-th call by the n-th of its entries; the last one is kept.

    Args:
        script: of each call: after how many seconds it answers what. A call that waits for the
            reply about a command answers nothing before it has come.

    Attributes:
        requests: the calls that were begun.
        replies: what was replied about commands.
        cancelled: tickets of calls that were left before their end.
        loading: what `awaited` says.
    """

    def __init__(self, *script: list[tuple[float, Answer]]) -> None:
        self.requests: list[CallRequest] = []
        self.replies: list[str | None] = []
        self.cancelled: list[int] = []
        self.prepared: tuple[Function, ...] = ()
        self.loading: tuple[str, ...] | Failed = ()
        self._script = script or ([],)
        self._left: dict[int, list[tuple[float, Answer]]] = {}
        self._begun_s: dict[int, float] = {}
        self._asking: set[int] = set()

    def prepare(self, functions: Iterable[Function]) -> None:
        self.prepared = tuple(functions)

    def awaited(self) -> tuple[str, ...] | Failed:
        return self.loading

    def begin(self, request: CallRequest) -> int:
        self.requests.append(request)
        ticket = len(self.requests)
        self._left[ticket] = list(self._script[min(ticket, len(self._script)) - 1])
        return ticket

    def take(self, ticket: int, now_s: float) -> list[Answer]:
        begun_s = self._begun_s.setdefault(ticket, now_s)
        left, answers = self._left[ticket], []
        while left and ticket not in self._asking and now_s - begun_s >= left[0][0] - 1e-6:
            answers.append(left.pop(0)[1])
            if isinstance(answers[-1], CommandAsked):
                self._asking.add(ticket)
            if isinstance(answers[-1], Returned | Failed):
                del self._left[ticket]
                break
        return answers

    def reply(self, ticket: int, failure: str | None) -> None:
        self._asking.discard(ticket)
        self.replies.append(failure)

    def cancel(self, ticket: int) -> None:
        if self._left.pop(ticket, None) is not None:
            self.cancelled.append(ticket)

    def end_calls(self) -> None:
        for ticket in list(self._left):
            self.cancel(ticket)
