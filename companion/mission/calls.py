"""Reads calls, such as the steps `fly(to)` and `python(weigh, r, limit_kg=2)`, by `calls.lark`.

What a call means is the subject of others: execution.py for steps, python_call.py for functions,
tree.py for actions.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from lark import Token, Transformer, v_args

from companion.errors import FormulaError
from companion.grammars import END, Grammar, Misfit, error_at


@dataclass(frozen=True, slots=True)
class WrittenArgument:
    """An argument as it is written; the type of its token says whether it is a name or a number.

    Attributes:
        name: its name, if it is given by name.
    """

    value: Token
    name: Token | None = None


@dataclass(frozen=True, slots=True)
class WrittenCall:
    """A call as it is written.

    >>> call = read_call("wait(5)", "not a step", {})
    >>> str(call.name), [str(argument.value) for argument in call.arguments]
    ('wait', ['5'])
    """

    name: Token
    arguments: tuple[WrittenArgument, ...]
    text: str = ""

    @property
    def words(self) -> tuple[str, ...]:
        """The arguments, as they are written."""
        return tuple(str(argument.value) for argument in self.arguments)

    def refuse_names(self, form: str) -> None:
        """Refuses arguments by name.

        Args:
            form: how the call is written, for advice.

        Raises:
            FormulaError: an argument is given by name.
        """
        for argument in self.arguments:
            if argument.name is not None:
                what = f"{self.name} takes no argument by name"
                raise self.error(argument.name, what, f"write {form}")

    def error(self, token: Token, what: str, advice: str) -> FormulaError:
        """An error that underlines a token of the call."""
        return error_at(token, what, advice, self.text)


@v_args(inline=True)
class _CallBuilder(Transformer[Token, WrittenCall]):
    def by_position(self, value: Token) -> WrittenArgument:
        return WrittenArgument(value)

    def by_name(self, name: Token, value: Token) -> WrittenArgument:
        return WrittenArgument(value, name)

    def call(self, name: Token, *arguments: WrittenArgument) -> WrittenCall:
        return WrittenCall(name, arguments)


_CALLS = Grammar("call", "calls.lark", __file__, _CallBuilder(), ["call"])


def read_call(text: str, otherwise: str, forms: Mapping[str, str]) -> WrittenCall:
    """Reads a call.

    Args:
        text: e.g. `fly(to)`.
        otherwise: what is wrong with a text that is no call, e.g. `not something to execute`.
        forms: how each call that may stand here is written, by its name; for advice.

    Raises:
        FormulaError: it is no call.
    """
    call = _CALLS.read(text)
    if isinstance(call, Misfit):
        raise _explained(call, text, otherwise, forms)
    return replace(call, text=text)


def _explained(misfit: Misfit, text: str, otherwise: str, forms: Mapping[str, str]) -> FormulaError:
    name = text.partition("(")[0].split()
    form = forms.get(name[0]) if name else None
    meant = form or ", ".join(forms.values())
    offset, length, before = misfit.offset, max(1, len(misfit.word)), text[: misfit.offset]
    if "(" not in before:
        return FormulaError(otherwise, text, 0, len(text), f"write {meant}")
    if misfit.kind == END:
        quoted = f'"{form}"' if form else meant
        hint = f"its parenthesis is not closed; inside {{ }} and [ ] put quotes around {quoted}"
        return FormulaError(otherwise, text, 0, len(text), hint)
    if END in misfit.expected:
        hint = f"a call ends at its parenthesis; write several as a list: [{before.strip()}, ...]"
        if misfit.word == ",":
            hint = f"write a list: [{text.strip()}]"
        return FormulaError(otherwise, text, offset, length, hint)
    hint = "write names, numbers, true, false, or texts in quotes, with commas between"
    if misfit.kind == "":
        hint = "a text in quotes ends with the same quote" if misfit.word in "\"'" else hint
    return FormulaError("not an argument", text, offset, length, hint)
