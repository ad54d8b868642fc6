"""Which functions are installed, as values: names, packages, parameters."""

from __future__ import annotations

import inspect
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from companion.skills.authoring import FunctionKind
from companion.skills.calls import Function

_KINDS = {kind.name: kind for kind in inspect._ParameterKind}
GIVEN = {FunctionKind.SKILL: 1, FunctionKind.SUGGESTER: 2, FunctionKind.PLACE_TEST: 3}
"""Number of parameters that the companion fills in itself: run, place, waypoint."""


@dataclass(frozen=True, slots=True)
class Parameter:
    """A parameter of an installed function.

    Attributes:
        kind: its name in `inspect`.
        default: as Python writes it; None if there is none.
        annotation: as its author has written it; "" if there is none.
    """

    name: str
    kind: str
    default: str | None
    annotation: str


@dataclass(frozen=True, slots=True)
class Installed:
    """A function that a package offers.

    Attributes:
        source: the package and its version.
        parameters: None if the function was not loaded, or could not be.
        failure: why it could not be loaded; "" if it could.
    """

    function: Function
    source: str
    parameters: tuple[Parameter, ...] | None = None
    failure: str = ""

    @property
    def signature(self) -> inspect.Signature:
        """Its parameters except those that the companion fills in."""
        own = (self.parameters or ())[GIVEN[self.function.kind] :]
        return inspect.Signature(
            [
                inspect.Parameter(
                    each.name,
                    _KINDS[each.kind],
                    default=inspect.Parameter.empty if each.default is None else _As(each.default),
                    annotation=_As(each.annotation) if each.annotation else inspect.Parameter.empty,
                )
                for each in own
            ]
        )

    @property
    def in_words(self) -> str:
        """A call of it as a mission writes it, with its parameters."""
        own = ", ".join(map(str, self.signature.parameters.values()))
        return f"python({self.function.name}{', ' if own else ''}{own})"


class _As:
    """A value whose `repr` is a given text."""

    def __init__(self, text: str) -> None:
        self._text = text

    def __repr__(self) -> str:
        return self._text


Catalogue = Mapping[Function, Sequence[Installed]]
"""Function -> the packages that offer it: one, none, or several in conflict."""


def as_json(catalogue: Catalogue) -> list[dict[str, Any]]:
    """A catalogue as JSON values."""
    return [
        {
            "group": each.function.kind.value,
            "name": each.function.name,
            "source": each.source,
            "parameters": each.parameters
            and [[p.name, p.kind, p.default, p.annotation] for p in each.parameters],
            "failure": each.failure,
        }
        for offers in catalogue.values()
        for each in offers
    ]


def from_json(values: list[dict[str, Any]]) -> dict[Function, list[Installed]]:
    """The catalogue in JSON values.

    >>> weigh = Installed(Function(FunctionKind.SKILL, "weigh"), "scale 1.0", ())
    >>> from_json(as_json({weigh.function: [weigh]})) == {weigh.function: [weigh]}
    True
    """
    catalogue: dict[Function, list[Installed]] = {}
    for value in values:
        parameters = value["parameters"]
        installed = Installed(
            Function(FunctionKind(value["group"]), str(value["name"])),
            str(value["source"]),
            None if parameters is None else tuple(Parameter(*each) for each in parameters),
            str(value["failure"]),
        )
        catalogue.setdefault(installed.function, []).append(installed)
    return catalogue
