"""Diagnostics of a document in plain words, made from pydantic's list of errors.

They are in the order of the file, except unknown keys, which come first: a misspelt key is the
reason why the right one is missing, which is then not reported. The advice comes from the JSON
Schema of the model: the existing keys, and the description of the field.
"""

from __future__ import annotations

import difflib
import json
import re
from collections.abc import Callable, Container, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from pydantic import BaseModel, ValidationError

from companion.documents.model_schema import Schema, alone, schema_at
from companion.documents.numbers import number_meant
from companion.errors import Keys

Detail = Mapping[str, Any]

NO_NAME = "[key]"
"""What pydantic adds to the location of an invalid key."""
_SIMILAR = 0.6  # difflib's own cutoff for close matches
_ELSEWHERE = {
    **dict.fromkeys(("x", "east", "easting"), ("east_m", "east_mps")),
    **dict.fromkeys(("y", "north", "northing"), ("north_m", "north_mps")),
    **dict.fromkeys(("z", "alt", "altitude", "height", "down"), ("up_m", "altitude_m")),
    **dict.fromkeys(("lat", "latitude"), ("lat_deg", "latitude_deg")),
    **dict.fromkeys(("lon", "lng", "longitude"), ("lon_deg", "longitude_deg")),
    **dict.fromkeys(("yaw", "heading"), ("heading_deg",)),
    **dict.fromkeys(("percent", "level", "soc"), ("charge",)),
    "event": ("report",),
    **dict.fromkeys(("when", "time", "t", "at"), ("at_s",)),
    **dict.fromkeys(("mode", "command"), ("operator",)),
    **dict.fromkeys(("velocity", "max_speed", "cruise_speed"), ("speed_mps",)),
    **dict.fromkeys(("max_alt", "max_altitude", "ceiling", "min_altitude"), ("up_m",)),
    **dict.fromkeys(("no_fly", "no_fly_zones", "exclusion", "obstacles"), ("keep_out",)),
    "geofence": ("fence",),
    **dict.fromkeys(("waypoints", "home"), ("places",)),
    "actions": ("skills",),
}
"""Key of another program -> ours."""


@dataclass(frozen=True, slots=True)
class Diagnostic:
    """What is wrong, where, and what to do about it.

    Attributes:
        what: the mistake, in one line.
        keys: its place in the document.
        hint: what to do; may be empty.
        is_about_key: whether the key is wrong, not its value.
    """

    what: str
    keys: Keys
    hint: str
    is_about_key: bool


def most_similar(word: str, known: Iterable[str]) -> str:
    """Returns the most similar known word; empty if none is similar.

    >>> most_similar("palces", ["places", "sets"])
    'places'
    """

    def similarity(name: str) -> float:
        return difflib.SequenceMatcher(None, word[:80].lower(), name.lower()).ratio()

    best = max(known, key=similarity, default="")  # the first one among equals
    return best if similarity(best) >= _SIMILAR else ""


def did_you_mean(word: str, known: Iterable[str]) -> str:
    """Returns a question with the most similar known word; empty if none is similar.

    >>> did_you_mean("palces", ["places", "sets"])
    'Did you mean places?'
    """
    best = most_similar(word, known)
    return f"Did you mean {best}?" if best else ""


def diagnostics(
    error: ValidationError,
    model: type[BaseModel],
    data: object,
    position: Callable[..., tuple[int, ...]],
    refused: Container[Keys] = (),
) -> list[Diagnostic]:
    """The mistakes of a document, each once.

    Args:
        error: what pydantic found.
        model: that was validated.
        data: the document as plain values.
        position: sort key of the value at some keys.
        refused: keys of values that are reported already and are not in the data.
    """
    details: list[tuple[Keys, Detail]] = [
        (existing_keys(detail["loc"], data), dict(detail))
        for detail in error.errors(include_url=False)
    ]
    details = [each for each in details if not _is_other_kind(*each, details, data)]
    details = [each for each in details if not _is_misspelt(*each, details)]
    details = [each for each in details if not _is_long_enough(*each, data)]
    details = [each for each in details if (*each[0], *each[1]["loc"][-1:]) not in refused]
    details.sort(key=lambda item: (item[1]["type"] != "extra_forbidden", position(*item[0])))
    schema = model.model_json_schema()
    alike: dict[tuple[Keys, str], list[Detail]] = {}  # branches of a union belong together
    for keys, detail in details:
        name = str(detail["loc"][-1]) if detail["type"] == "missing" else ""
        alike.setdefault((keys, name), []).append(detail)
    told: dict[Keys, Diagnostic] = {}
    for (keys, name), group in alike.items():
        is_item = bool(keys) and isinstance(keys[-1], int) and not name
        alike_items = (*keys[:-1], group[0]["type"]) if is_item else keys  # reported once
        told.setdefault((*alike_items, name), _diagnostic(group, keys, schema, data))
    return list(told.values())


def _is_misspelt(keys: Keys, detail: Detail, details: Sequence[tuple[Keys, Detail]]) -> bool:
    """Whether a missing key is explained by an unknown one, which is reported."""
    return detail["type"] == "missing" and any(
        other["type"] == "extra_forbidden" and where[:-1] == keys for where, other in details
    )


def _is_long_enough(keys: Keys, detail: Detail, data: object) -> bool:
    """Whether a list is too short only because of invalid entries, which are reported."""
    there = _at(data, keys)
    if detail["type"] != "too_short" or not isinstance(there, list):
        return False
    return len(there) >= int(detail["ctx"]["min_length"])


def _is_other_kind(
    keys: Keys, detail: Detail, details: Sequence[tuple[Keys, Detail]], data: object
) -> bool:
    """Whether a mapping is called no text although another alternative says what it lacks."""
    if not isinstance(_at(data, keys), dict) or detail["type"] in ("missing", "extra_forbidden"):
        return False
    return any(
        where[: len(keys)] == keys and (len(where) > len(keys) or other["type"] == "missing")
        for where, other in details
    )


def existing_keys(loc: Sequence[str | int], data: object) -> Keys:
    """The document's keys in pydantic's location, which also names branches of unions."""
    keys: list[str | int] = []
    for part in loc:
        if isinstance(data, dict) and part in data:
            data = data[part]
        elif isinstance(data, list) and isinstance(part, int) and part < len(data):
            data = data[part]
        else:
            continue
        keys.append(part)
    return tuple(keys)


def _diagnostic(details: list[Detail], keys: Keys, root: Schema, data: object) -> Diagnostic:
    detail = details[0]
    kind, name = detail["type"], detail["loc"][-1] if detail["loc"] else ""
    if kind == "missing" and isinstance(name, str):
        description = schema_at(root, (*keys, name)).get("description", "")
        hint = _sentence(name, description)
        return Diagnostic(f"the key {name} is missing{_of(keys)}", keys, hint, True)
    is_rest = kind == "extra_forbidden" or name == NO_NAME
    if is_rest and str(keys[-1]).endswith(")") and _at(data, keys) is None:
        hint = "a comma within { } ends an entry: put quotes around a text that has one"
        return Diagnostic(f"{_short(keys[-1])} is the rest of a text", keys, hint, True)
    if kind == "extra_forbidden" and (number := _cut_number(keys, data)):
        hint = f"a comma within {{ }} ends an entry: write {number}"
        return Diagnostic(f"{_short(keys[-1])} is the rest of a number", keys, hint, True)
    if kind == "extra_forbidden":
        known = list(schema_at(root, keys[:-1]).get("properties", ()))
        meant = meant_key(str(keys[-1]), known)
        question = f" Did you mean {meant}?" if meant else ""
        hint = f"known keys are {', '.join(known)}{alone(root, keys[:-1])}.{question}"
        return Diagnostic(f"unknown key {_short(keys[-1])}{_of(keys[:-1])}", keys, hint, True)
    if name == NO_NAME:
        expected = _RULES[kind](detail["ctx"]) if kind in _RULES else detail["msg"]
        better = re.sub(r"\W+", "_", str(keys[-1]), flags=re.ASCII).strip("_")
        hint = f"expected {expected}" + (f": write {better}" if better.isidentifier() else "")
        return Diagnostic(f"{_short(keys[-1])} is not a name", keys, hint, True)
    explained, keys_there = _explanation(root, keys), schema_at(root, keys).get("properties", ())
    if keys_there:
        explained = f"{explained.rstrip('.')}. keys are {', '.join(keys_there)}{alone(root, keys)}."
    is_share = schema_at(root, keys).get("maximum") == 1
    return _wrong_value(details, keys, explained, _at(data, keys), is_share)


def _cut_number(keys: Keys, data: object) -> str:
    """A number that a decimal comma within { } has cut in two, with a point; empty if it is none.

    >>> _cut_number(("Pond", "5"), {"Pond": {"east_m": 40, "5": None, "up_m": 3}})
    '40.5'
    """
    entries = _at(data, keys[:-1])
    if not isinstance(entries, dict) or not str(keys[-1]).isdecimal() or _at(data, keys):
        return ""
    before = None
    for key, value in entries.items():
        if key == keys[-1]:
            break
        before = value
    is_whole = isinstance(before, int) and not isinstance(before, bool)
    return f"{before}.{keys[-1]}" if is_whole else ""


def meant_key(word: str, known: Sequence[str]) -> str:
    """The key that was probably meant; empty if none is similar."""
    others = _ELSEWHERE.get(re.sub(r"_(m|deg|mps|kmh)$", "", word.lower()), ())
    ours = next((each for each in others if each in known), "")
    return ours or most_similar(word, known)


def _explanation(root: Schema, keys: Keys) -> str:
    """The description of a value, or of the nearest value around it that has one."""
    for length in range(len(keys), 0, -1):
        if description := schema_at(root, keys[:length]).get("description"):
            inner = keys[:length]
            return _sentence(
                str(inner[-1]) if isinstance(inner[-1], str) else _subject(inner), description
            )
    return _sentence(_subject(()), root.get("description", ""))


def _wrong_value(
    details: list[Detail], keys: Keys, explained: str, value: object, is_share: bool
) -> Diagnostic:
    subject = keys[-1] if keys and isinstance(keys[-1], str) else _subject(keys)
    kind, message = details[0]["type"], details[0]["msg"]
    if kind not in _RULES:  # a validator's own text
        return Diagnostic(f"{subject}: {message.removeprefix('Value error, ')}", keys, "", False)
    expected = dict.fromkeys(
        _RULES[d["type"]](d.get("ctx", {})) for d in details if d["type"] in _RULES
    )
    hint = explained
    if isinstance(value, str):
        words = [w for phrase in expected for w in phrase.replace(" or ", ", ").split(", ")]
        number = number_meant(value, keys, is_share) if "a number" in expected else ""
        hint = f"{number or did_you_mean(value, words)} {hint}".strip()
    elif isinstance(value, bool | int | float) and "a text" in expected:
        hint = f'put quotes around it: "{_short(value)}". {hint}'
    what = f"{subject} is {_describe(value)}, expected {' or '.join(expected)}"
    return Diagnostic(what, keys, hint, False)


_TEXTS = {
    r"^[A-Za-z_][A-Za-z0-9_]*$": "letters, digits and _, no digit first",
    r"^[A-Za-z0-9][A-Za-z0-9_-]*$": "letters, digits, - and _",
}
"""Patterns of names -> their description in words."""

_RULES: dict[str, Callable[[Schema], str]] = {
    **dict.fromkeys(("string_type", "string_sub_type"), lambda c: "a text"),
    **dict.fromkeys(("int_type", "int_from_float", "int_parsing"), lambda c: "a whole number"),
    **dict.fromkeys(("float_type", "float_parsing"), lambda c: "a number"),
    **dict.fromkeys(("bool_type", "bool_parsing"), lambda c: "true or false"),
    **dict.fromkeys(("list_type", "tuple_type", "set_type"), lambda c: "a list"),
    **dict.fromkeys(("dict_type", "model_type", "dataclass_type"), lambda c: "keys with values"),
    **dict.fromkeys(("literal_error", "enum"), lambda c: str(c["expected"]).replace("'", "")),
    "greater_than": lambda c: f"more than {c['gt']:g}",
    "greater_than_equal": lambda c: f"at least {c['ge']:g}",
    "less_than": lambda c: f"less than {c['lt']:g}",
    "less_than_equal": lambda c: f"at most {c['le']:g}",
    "finite_number": lambda c: "a finite number",
    "too_short": lambda c: f"at least {c['min_length']} entries",
    "too_long": lambda c: f"at most {c['max_length']} entries",
    "missing": lambda c: "more entries",
    "string_too_short": lambda c: f"at least {c['min_length']} characters",
    "string_too_long": lambda c: f"at most {c['max_length']} characters",
    "string_pattern_mismatch": lambda c: _TEXTS.get(
        c["pattern"], f"a text that matches {c['pattern']}"
    ),
}
"""Type of pydantic's error -> what was expected."""


def _at(data: object, keys: Keys) -> object:
    for key in keys:
        assert isinstance(data, dict | list)
        data = data[key]  # type: ignore[index]
    return data


def _describe(value: object) -> str:
    if value is None:
        return "empty"
    if isinstance(value, dict | list):
        return "a list" if isinstance(value, list) else "a mapping"
    return _short(value)


def _short(value: object) -> str:
    text = value if isinstance(value, str) else json.dumps(value)
    return repr(text if len(text) <= 40 else f"{text[:37]}...") if isinstance(value, str) else text


def _subject(keys: Keys) -> str:
    return f"entry {int(keys[-1]) + 1}{_of(keys[:-1])}" if keys else "the file"


def _of(keys: Keys) -> str:
    return f" in {'.'.join(str(key) for key in keys)}" if keys else ""


def _sentence(name: str, description: str) -> str:
    return f"{name}: {description}" if description else ""
