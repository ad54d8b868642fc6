"""Writes docs/mission-keys.md and docs/scenario-keys.md: every key of the files that people write.

Everything comes from the JSON schemas of the models: the value of a key, its limits, its default
and its description. A unit is the ending of a key's name, or is in UNITS. An example is the value
of the key in a file of missions/, or is in EXAMPLES if no file has the key.

Run it after a change of a schema; a test compares the pages.

Usage: python scripts/make_reference.py
"""

from __future__ import annotations

import json
import re
from collections import defaultdict
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from reference_values import EXAMPLES, UNITS, unit_of
from ruamel.yaml import YAML
from schema_keys import KeyTable, Schema, inlined, name_of, named, references, tables, values

from companion import vehicle_files as vehicle
from companion.mission import schema as mission
from sitl.world import schema as scenario

ROOT = Path(__file__).parent.parent
MISSION_PAGE, SCENARIO_PAGE = "mission-keys.md", "scenario-keys.md"
HEAD = ("key", "value", "unit", "default", "what it says", "example")
LONGEST = 64
"""Longer examples, in characters, are left out; the tables of their keys have shorter ones."""
Values = Mapping[tuple[str, str], list[Any]]


class KeyPage(NamedTuple):
    """A page with its kinds of files.

    Attributes:
        name: the name of the page in docs/.
        title: with the text above the tables.
        files: for each kind, the heading, the schema, and the files of missions/ with examples.
    """

    name: str
    title: str
    files: tuple[tuple[str, Schema, str], ...]


PAGES = (
    KeyPage(
        MISSION_PAGE,
        "# Keys of a mission\n\n"
        "This page lists every key of `NAME.yaml` and of a vehicle profile.\n"
        "[missions.md](missions.md) says what the keys are for, and what they do together.\n",
        (
            ("The mission file", inlined(mission.json_schema()), "*[!m].yaml"),
            ("A vehicle profile", inlined(vehicle.json_schema()), "vehicles/*.yaml"),
        ),
    ),
    KeyPage(
        SCENARIO_PAGE,
        "# Keys of a scenario\n\n"
        "This page lists every key of `NAME.sim.yaml`, which says what the simulated world does.\n"
        "[scenario.md](scenario.md) says how things are there, and how they happen.\n",
        (("The scenario file", inlined(scenario.json_schema()), "*.sim.yaml"),),
    ),
)
NOTE = """
The page is generated from the models that read the files (`scripts/make_reference.py`). A key that
is not required may be left out. In a path such as `places.NAME`, `NAME` is a name of yours, and
`[]` is an entry of a list. An example is from a file in `missions/`, if one of them has the key.
"""


# -- examples ------------------------------------------------------------------------------------


def examples(kinds: Iterable[tuple[str, Schema, str]]) -> Values:
    """The values of each key in the shipped files."""
    found: dict[tuple[str, str], list[Any]] = defaultdict(list)
    for _, schema, pattern in kinds:
        root = KeyTable("", str(schema["title"]), schema)
        for path in sorted((ROOT / "missions").glob(pattern)):
            content = YAML(typ="safe").load(path.read_text(encoding="utf-8"))
            for where, value in values(content, root, schema):
                found[where].append(value)
    return found


def written(value: Any) -> str:
    """A value as one line of YAML."""
    match value:
        case dict():
            return "{" + ", ".join(f"{key}: {written(each)}" for key, each in value.items()) + "}"
        case list():
            return "[" + ", ".join(map(written, value)) + "]"
        case str() if re.search(r"[:#{}\[\],&*!|>'\"%@`-]", value) or value == "":
            return json.dumps(value, ensure_ascii=False)
        case str():
            return value
        case float() if value.is_integer():
            return str(int(value))
    return json.dumps(value)


# -- the page ------------------------------------------------------------------------------------


def page(about: KeyPage) -> str:
    """A page with a table for each mapping of its files."""
    found = examples(about.files)
    sections = [about.title, NOTE]
    places = _places(about)
    for heading, schema, _ in about.files:
        sections.append(f"\n## {heading}\n")
        for table in tables(schema, str(schema["title"])):
            if places[table.model].startswith("#"):
                sections.append(_section(table, found, places))
    return "".join(sections)


def _places(about: KeyPage) -> dict[str, str]:
    """Where the table of each model is; tables of the mission page are not repeated."""
    found: dict[str, str] = {}
    for other in (PAGES[0], about):
        for _, schema, _ in other.files:
            for table in tables(schema, str(schema["title"])):
                anchor = "#" + re.sub(r"[^\w -]", "", table.path.lower()).replace(" ", "-")
                found.setdefault(table.model, anchor if other is about else other.name + anchor)
    return found


def _section(table: KeyTable, found: Values, places: Mapping[str, str]) -> str:
    title = f"\n### {table.path}\n" if table.path else ""
    about = str(table.schema.get("description", "")).partition("\n\n")[0].replace("\n", " ")
    rows = [
        _row(table, key, value, found, places) for key, value in table.schema["properties"].items()
    ]
    lines = [HEAD, ("---",) * len(HEAD), *rows]
    body = "".join(f"| {' | '.join(cells)} |\n" for cells in lines)
    return f"{title}\n{about}{_alternatives(table.schema)}\n\n{body}"


def _alternatives(schema: Schema) -> str:
    """Which keys must be given together, and which are alternatives."""
    for word, opening in {"oneOf": " Either ", "anyOf": " At least one of "}.items():
        if word in schema:
            groups = [" and ".join(f"`{k}`" for k in each["required"]) for each in schema[word]]
            return f"{opening}{', or '.join(groups)}."
    return ""


def _row(
    table: KeyTable, key: str, value: Schema, found: Values, places: Mapping[str, str]
) -> tuple[str, ...]:
    description = str(value.get("description", "")).replace("|", "\\|")
    kind = _kind(value, places)
    inner = next((places[model] for model, _ in references(value) if model in places), "")
    return (
        f"`{key}`",
        kind,
        UNITS.get((table.model, key), "" if kind.startswith("[keys]") else unit_of(key)),
        _default(table, key, value),
        _sentence(description),
        _example(table, key, found, inner),
    )


def _sentence(description: str) -> str:
    word, _, _ = description.partition(" ")
    opening = word.capitalize() if word.strip(",;").isalpha() and word.islower() else word
    return (opening + description.removeprefix(word)).rstrip(".") + "."


def _default(table: KeyTable, key: str, value: Schema) -> str:
    if key in table.schema.get("required", []):
        return "required"
    default = value.get("default")
    return "" if default in (None, [], {}) or isinstance(default, dict) else f"`{written(default)}`"


def _example(table: KeyTable, key: str, found: Values, inner: str) -> str:
    given = _given(table, key, found)
    texts = sorted(
        {written(value) for value in given if value not in (None, [], {})}, key=_by_length
    )
    fitting = [text for text in texts if len(text) <= LONGEST]
    if fitting:
        return "`" + fitting[len(fitting) // 2].replace("|", "\\|") + "`"
    return f"[its keys]({inner})" if inner else ""


def _by_length(text: str) -> tuple[int, str]:
    return len(text), text


def _given(table: KeyTable, key: str, found: Values) -> list[Any]:
    """Candidates for an example: of this key, of one with its name and unit, or its default."""
    where = (table.model, key)
    if where in EXAMPLES:
        return [EXAMPLES[where]]
    value = table.schema["properties"][key]
    if where in found:
        return found[where]
    if value.get("type") == "boolean":
        return [not value.get("default")]
    if "enum" in value:
        return list(value["enum"][-1:])
    alike = [each for (_, other), given in found.items() if other == key for each in given]
    return alike if unit_of(key) and alike else [value.get("default", [])]


def _kind(value: Schema, places: Mapping[str, str]) -> str:
    """The type of a value, in words."""
    if "const" in value or "enum" in value:
        return " or ".join(f"`{written(each)}`" for each in value.get("enum", [value.get("const")]))
    if "$ref" in value:
        return f"[keys]({places[name_of(value)]})" if name_of(value) in places else "a name below"
    if "anyOf" in value:
        kinds = [_kind(each, places) for each in value["anyOf"]]
        return " or ".join(dict.fromkeys(kinds))
    return _typed(value, places)


def _typed(value: Schema, places: Mapping[str, str]) -> str:
    match value.get("type"):
        case "array" if "prefixItems" in value:
            return "[" + ", ".join(str(each["type"]) for each in value["prefixItems"]) + "]"
        case "array":
            return f"list of {_kind(value['items'], places)}{_limits(value)}"
        case "object":
            inner = named(value)
            return "mapping" if inner is None else f"NAME: {_kind(inner, places)}"
        case "string":
            return "name" if "pattern" in value else "text"
        case "boolean":
            return "`true` or `false`"
        case "integer":
            return f"whole number{_limits(value)}"
        case "number":
            return f"number{_limits(value)}"
    return "anything"


def _limits(value: Schema) -> str:
    words = {
        "minimum": "from",
        "exclusiveMinimum": "above",
        "maximum": "to",
        "minItems": "from",
        "maxItems": "to",
    }
    limits = [f"{word} {value[key]:g}" for key, word in words.items() if key in value]
    return f", {' '.join(limits)}" if limits else ""


def pages() -> dict[Path, str]:
    """The pages as generated."""
    return {ROOT / "docs" / about.name: page(about) for about in PAGES}


if __name__ == "__main__":
    for path, text in pages().items():
        path.write_text(text, encoding="utf-8")
        print(f"wrote {path}")
