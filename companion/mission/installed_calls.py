"""Checks that the functions a mission calls are installed and accept their arguments."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

from companion.documents import Document, did_you_mean
from companion.errors import KeyPath, Keys, Location, MissionError
from companion.mission.model import Mission
from companion.mission.places import Place
from companion.mission.python_call import Argument, Named, PythonCall
from companion.mission.skills import Skill
from companion.skills.authoring import FunctionKind
from companion.skills.calls import Function
from companion.skills.catalogue import GIVEN, Catalogue, Installed
from companion.skills.installed import InstalledReader

WORDS = {
    FunctionKind.SKILL: "skill",
    FunctionKind.SUGGESTER: "suggester",
    FunctionKind.PLACE_TEST: "test of places",
}
_TAKES: Mapping[str, tuple[tuple[type, ...], str]] = {
    "str": ((str,), "a text"),
    "float": ((int, float), "a number"),
    "int": ((int,), "a whole number"),
    "bool": ((bool,), "true or false"),
}
"""The types that an annotated parameter accepts; the function itself checks all others."""


def calls_of(
    skills: Mapping[str, Skill], places: Mapping[str, Place]
) -> Iterator[tuple[PythonCall, Keys]]:
    """The calls in a mission, each with its place in the file."""
    for name, skill in skills.items():
        for index, step in enumerate(skill.execute):
            if isinstance(step, PythonCall):
                yield step, ("skills", name, "execute", index)
    for name, place in places.items():
        for key, calls in (("suggesters", place.suggesters), ("tests", place.tests)):
            for index, call in enumerate(calls):
                yield call, ("places", name, key, index)


def functions_of(mission: Mission) -> tuple[Function, ...]:
    """The functions that a mission calls, each once."""
    calls = calls_of(mission.skills, mission.places)
    return tuple(dict.fromkeys(call.function for call, _ in calls))


def check_installed(
    skills: Mapping[str, Skill],
    places: Mapping[str, Place],
    document: Document,
    read: InstalledReader,
) -> None:
    """Refuses a call of a function that is not installed or does not accept the arguments.

    Raises:
        MissionError: at the first such call.
    """
    calls = list(calls_of(skills, places))
    if not calls:
        return
    catalogue = read({call.function for call, _ in calls})
    for call, keys in calls:
        where = document.where(*keys)
        installed = _one(call.function, catalogue, where)
        _check_arguments(call, installed, where)


def _one(function: Function, catalogue: Catalogue, where: Location | KeyPath) -> Installed:
    """The only package that offers a function."""
    word, offers = WORDS[function.kind], catalogue.get(function, ())
    what = f"the {word} {function.name}"
    if not offers:
        raise MissionError(f"{what} is not installed", where, _advice(function, catalogue))
    if len(offers) > 1:
        sources = " and ".join(each.source for each in offers)
        hint = "neither is used; uninstall all but one"
        raise MissionError(f"{what} is claimed by {sources}", where, hint)
    if offers[0].failure:
        hint = "mend the package, or install it again; docs/skills.md says what it needs"
        raise MissionError(f"{what} of {offers[0].source}: {offers[0].failure}", where, hint)
    return offers[0]


def _advice(function: Function, catalogue: Catalogue) -> str:
    known = [each for each in catalogue if each.kind is function.kind]
    listing = ", ".join(f"{each.name} ({catalogue[each][0].source})" for each in known)
    question = did_you_mean(function.name, [each.name for each in known])
    how = (
        f"install the package that has it beside the companion, with an entry point "
        f"{function.name} in {function.kind.value} (docs/skills.md)"
    )
    return f"installed are: {listing or 'none'}. {question}".rstrip() + f"\n{how}"


def _check_arguments(call: PythonCall, installed: Installed, where: Location | KeyPath) -> None:
    signature, form = installed.signature, f"write {installed.in_words}"
    given, keywords = call.arguments, dict(call.keywords)
    filled = [each.name for each in (installed.parameters or ())[: GIVEN[call.function.kind]]]
    for name in keywords:
        if name in filled:
            what = f"{name} of {call.function.name} is filled in by the companion"
            raise MissionError(what, where, form)
    try:
        bound = signature.bind(*given, **keywords)
    except TypeError as error:
        strange = next((name for name in keywords if name not in signature.parameters), "")
        question = did_you_mean(strange, signature.parameters) if strange else ""
        what = f"{call.function.name}: {error}"
        raise MissionError(what, where, f"{form}. {question}".rstrip()) from None
    for name, argument in bound.arguments.items():
        annotation = str(signature.parameters[name].annotation).strip("'\"")
        if annotation in _TAKES and not isinstance(argument, dict | tuple):
            types, takes = _TAKES[annotation]
            if not _is_of(argument, types):
                written = argument.word if isinstance(argument, Named) else argument
                what = f"{name} of {call.function.name} takes {takes}, not {written}"
                raise MissionError(what, where, form)


def _is_of(argument: Argument, types: Iterable[type]) -> bool:
    value = argument.word if isinstance(argument, Named) else argument
    if isinstance(value, bool):
        return bool in types
    return isinstance(value, tuple(types))
