"""Uploads of a stranger: mutants of the shipped missions, hostile formulas, hostile time bounds.

`hostile_checks.py` checks them as uploads are checked.
"""

from __future__ import annotations

import json
import random
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from ruamel.yaml import YAML

SHIPPED = Path(__file__).parents[2] / "missions"
MISSION = "mission.yaml"
Files = dict[str, bytes]
Chance = random.Random
Data = dict[str, Any]


@dataclass(frozen=True)
class Hostile:
    """An upload of a stranger: its files, of which MISSION is the mission."""

    name: str
    files: Files

    def write(self, folder: Path) -> None:
        for name, content in self.files.items():
            path = folder / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(content)


def hostile(kind: str, seed: int) -> Hostile:
    """The upload of a seed: a `mission`, or one with a hostile `formula`, or hostile `bounds`."""
    makers = {"mission": _mission, "formula": _formula_mission, "bounds": _bounds_mission}
    made = makers[kind](random.Random(f"{kind} {seed}"))
    return Hostile(f"{kind} {seed}", made)


# -- the shipped missions ----------------------------------------------------------------------


@cache
def _shipped() -> dict[str, str]:
    """Texts of the shipped missions by name."""
    paths = sorted(SHIPPED.glob("*.yaml"))
    return {p.stem: p.read_text("utf-8") for p in paths if not p.name.endswith(".sim.yaml")}


def _others() -> Files:
    """What missions need: maps, vehicles, PDDL files."""
    kinds = ("maps/*", "vehicles/*", "*.pddl")
    return {
        str(path.relative_to(SHIPPED)): path.read_bytes()
        for kind in kinds
        for path in sorted(SHIPPED.glob(kind))
    }


def _data(text: str) -> Data:
    read: Data = YAML(typ="safe", pure=True).load(text)
    return read


def _written(data: object) -> str:
    """YAML in the flow style, with all the numbers that YAML has."""
    text = json.dumps(data, ensure_ascii=False)
    for spelled, yaml in (("NaN", ".nan"), ("-Infinity", "-.inf"), ("Infinity", ".inf")):
        text = text.replace(f" {spelled}", f" {yaml}").replace(f"[{spelled}", f"[{yaml}")
    return text + "\n"


# -- mutations of data -------------------------------------------------------------------------

ODD_VALUES: tuple[Any, ...] = (
    1e308, -1e308, float("nan"), float("inf"), -0.0, 1e-320, 0, -1, 10**400, 2**63, 0.1 + 0.2,
    "", " ", "1e308", "~", "null", "\u202e", "\U0001f6f8" * 40, "é", "a" * 5000, "0x7f", "!!python",
    None, True, False, [], {}, [[]], {"": None}, ["Home"] * 300, {"A": {"A": {"A": {}}}},
)  # fmt: skip
WRONG_UNITS = (1000.0, 100.0, 0.001, 57.29578, 3.28084, -1.0, 1e6, 3.6)


def _slots(data: Any) -> list[tuple[Any, Any]]:
    """Every container with each of its keys or indices."""
    if isinstance(data, dict):
        keys: list[Any] = list(data)
    elif isinstance(data, list):
        keys = list(range(len(data)))
    else:
        return []
    inner = [slot for key in keys for slot in _slots(data[key])]
    return [(data, key) for key in keys] + inner


def _numbers(data: Data) -> list[tuple[Any, Any]]:
    return [(c, k) for c, k in _slots(data) if type(c[k]) in (int, float)]


def drop(data: Data, chance: Chance) -> None:
    container, key = chance.choice(_slots(data))
    del container[key]


def rename(data: Data, chance: Chance) -> None:
    container, key = chance.choice([s for s in _slots(data) if isinstance(s[0], dict)])
    new = chance.choice(("", "at", "X", "U", "G", "true", "here", f"{key}{key}", "ключ", "a b"))
    container[new] = container.pop(key)


def replace(data: Data, chance: Chance) -> None:
    container, key = chance.choice(_slots(data))
    container[key] = chance.choice(ODD_VALUES)


def swap(data: Data, chance: Chance) -> None:
    (one, i), (other, j) = chance.sample(_slots(data), 2)
    try:
        one[i], other[j] = other[j], one[i]
    except (KeyError, IndexError):
        return  # one of them lay in the other


def wrong_unit(data: Data, chance: Chance) -> None:
    for container, key in chance.sample(_numbers(data), min(3, len(_numbers(data)))):
        container[key] *= chance.choice(WRONG_UNITS)


def any_number(data: Data, chance: Chance) -> None:
    if numbers := _numbers(data):
        container, key = chance.choice(numbers)
        container[key] = chance.choice((chance.uniform(-1e3, 1e3), chance.lognormvariate(0, 20)))


def nest(data: Data, chance: Chance) -> None:
    container, key = chance.choice(_slots(data))
    for _ in range(chance.choice((3, 15, 40, 100))):
        wrapped = container[key]
        container[key] = [wrapped] if chance.random() < 0.5 else {"a": wrapped}


def lengthen(data: Data, chance: Chance) -> None:
    if lists := [c[k] for c, k in _slots(data) if isinstance(c[k], list) and c[k]]:
        made = chance.choice(lists)
        copies = 30_000 // len(str(made))
        made.extend(made * min(chance.choice((1, 10, 100, 2000)), copies))


def other_mission(data: Data, chance: Chance) -> None:
    """A part of another shipped mission under the same key."""
    other = _data(chance.choice([*_shipped().values()]))
    key = chance.choice([*other])
    data[key] = other[key]


def formula(data: Data, chance: Chance) -> None:
    task = data.get("task")
    if isinstance(task, dict) and task:
        line = chance.choice([*task])
        task[line] = mutated(str(task[line]), chance)
    else:
        data["task"] = {"line": random_formula(chance, _facts(data))}
        data.pop("goal", None)


def more_lines(data: Data, chance: Chance) -> None:
    count, facts = chance.choice((5, 20, 60)), _facts(data)
    lines = {f"l{i}": random_formula(chance, facts, chance.choice((2, 5))) for i in range(count)}
    for line in chance.sample(sorted(lines), count // 3):
        lines[line] = {"formula": lines[line], "priority": chance.randint(1, 9)}  # type: ignore[assignment]
    data["task"] = lines


def more_places(data: Data, chance: Chance) -> None:
    """Up to 2,000 places, all of them members of a set, on a map of their own."""
    count, side = chance.choice((30, 100, 220, 600, 2000)), chance.choice((20.0, 60.0))
    places = data.get("places")
    if not isinstance(places, dict) or not places:
        return
    names = [f"p{i}" for i in range(count)]
    for name in names:
        east, north = (round(chance.uniform(0, side), 2) for _ in range(2))
        places[name] = {"east_m": east, "north_m": north, "up_m": 2}
    data["map"] = {"east_m": [-2, side + 2], "north_m": [-2, side + 2], "cell_m": 0.1}
    edge = side + 1
    if isinstance(data.get("limits"), dict):
        data["limits"]["fence"] = [[-1.5, -1.5], [edge, -1.5], [edge, edge], [-1.5, edge]]
    sets = data.get("sets")
    if isinstance(sets, dict) and sets:
        sets[chance.choice([*sets])] = names + ["Home"] * ("Home" in places)
    if chance.random() < 0.5:
        asked = names[: chance.choice((3, 12, 60, 2000))]
        data["task"] = {"sites": " & ".join(f"G F at({name})" for name in asked)}


def big_map(data: Data, chance: Chance) -> None:
    side, cell = chance.choice(((20, 0.01), (40, 0.01), (400, 0.1), (4000, 1), (39, 0.05)))
    walls = [
        {"east_m": [i, i + 0.5], "north_m": [j, j + 0.5]}
        for i in range(3, 39, 4)
        for j in range(3, chance.choice((3, 20, 39)), 4)
    ]
    ranges = {"east_m": [-2, side - 2], "north_m": [-2, side - 2]}
    data["map"] = ranges | {"cell_m": cell, "walls": walls}


def more_parameters(data: Data, chance: Chance) -> None:
    """A skill whose instances are the product of many sets."""
    skills, sets = data.get("skills"), data.get("sets")
    if isinstance(skills, dict) and isinstance(sets, dict) and skills and sets:
        skill = skills[chance.choice([*skills])]
        if isinstance(skill, dict):
            of = chance.choice([*sets])
            count = chance.choice((1, 2, 4, 8, 20))
            skill["parameters"] = skill.get("parameters", {}) | {f"x{i}": of for i in range(count)}


def more_facts(data: Data, chance: Chance) -> None:
    """Switches, each of them free: as many states as sets of them."""
    skills = data.setdefault("skills", {})
    if isinstance(skills, dict):
        count = chance.choice((4, 10, 20, 60))
        for i in range(count):
            skills[f"on{i}"] = {"effect": f"lamp{i}", "execute": "wait(1)"}
            skills[f"off{i}"] = {"effect": f"!lamp{i}", "execute": "wait(1)"}
        lamps = [f"lamp{i}" for i in range(count)]
        line = {"lamps": "G F (" + " & ".join(lamps) + ")"}
        task = data.get("task")
        data["task"] = task | line if isinstance(task, dict) else line


def deep_tree(data: Data, chance: Chance) -> None:
    tree: Any = chance.choice(("move(*, A)", "move(Home, A)", "targetFound", "wait(1)"))
    for _ in range(chance.choice((2, 10, 300))):
        kind = chance.choice(("fallback", "parallel", "inverter", "repeat", "retry", "timeout"))
        more = {"repeat": {"times": 10**9}, "retry": {"times": 100}, "timeout": {"duration_s": 5}}
        tree = {kind: [tree] * chance.choice((1, 1, 2)), **more.get(kind, {})}
        if len(str(tree)) > 50_000:
            break
    data.pop("task", None)
    data["tree"] = [tree]


def refined(data: Data, chance: Chance) -> None:
    """Skills that are done by others, each of them twice."""
    skills = data.get("skills")
    if isinstance(skills, dict) and skills:
        count = chance.choice((3, 20, 40))
        for i in range(count):
            inner = f"s{i + 1}()" if i < count - 1 else chance.choice(("wait(1)", "s0()"))
            skills[f"s{i}"] = {"execute": [inner, inner], "effect": "done"}


OF_DATA = (
    drop, rename, replace, swap, wrong_unit, any_number, nest, lengthen, other_mission, formula,
    formula, more_lines, more_places, big_map, more_parameters, more_facts, deep_tree, refined,
)  # fmt: skip


# -- mutations of texts ------------------------------------------------------------------------

YAML_PIECES = (
    "&a ", "*a ", "!!python/object:os.system ", "!!binary ", "<<: *a", "? ", "- ", "--- ", "...",
    "%YAML 1.1\n", "%TAG ! tag:x,2000:\n", "|\n", ">-\n", "\t", "{", "[", "]", "}", "'", '"', ": ",
    "#", "\u0000", "\ufeff", "\u2028", "\u202e", "\ud83d", "\\U7fffffff", "@", "`", "0o17", "1_000",
    "2024-01-01", "~", ".inf", "-.inf", ".nan", "1e999", "0x" + "f" * 300, "(" * 200, "[" * 2000,
    "a" * 9_000, "{a: " * 100, "\n" * 500, "é" * 3000,
)  # fmt: skip
LAUGHS = "".join(f"a{i + 1}: &a{i + 1} [{', '.join([f'*a{i}'] * 9)}]\n" for i in range(9))


def _text_mutated(text: str, chance: Chance) -> str:
    """One mutation of a text, of lines or of characters."""
    lines = text.splitlines(keepends=True) or [""]
    i = chance.randrange(len(lines))
    match chance.randrange(8):
        case 0:
            lines.insert(i, lines[chance.randrange(len(lines))])
        case 1:
            lines[i : i + chance.randint(1, 5)] = []
        case 2:
            one, other = chance.randrange(len(lines)), chance.randrange(len(lines))
            lines[one], lines[other] = lines[other], lines[one]
        case 3:
            lines.insert(i, "a0: &a0 [x]\n" + LAUGHS)
        case 4:
            lines = lines * chance.choice((2, 2, 8))
        case 5:
            lines[i] = "  " * chance.randint(1, 4) + lines[i]
        case _:
            at = chance.randrange(len(lines[i]) + 1)
            lines[i] = lines[i][:at] + chance.choice(YAML_PIECES) + lines[i][at:]
    return "".join(lines)


def _bytes_mutated(content: bytes, chance: Chance) -> bytes:
    made = bytearray(content)
    for _ in range(chance.choice((1, 4, 40))):
        at = chance.randrange(max(1, len(made)))
        made[at : at + chance.randint(0, 3)] = chance.randbytes(chance.randint(0, 3))
    return bytes(made)


def _image(chance: Chance) -> bytes:
    """An image that says to be larger than it is, or is as large as an upload may be."""
    width, height = chance.choice(((512, 500), (4000, 4000), (4001, 1), (1, 1), (10**9, 10**9)))
    return f"P5\n{width} {height}\n255\n".encode() + b"\xff" * chance.choice((0, 256_000))


def _png(chance: Chance) -> bytes:
    """A PNG of 4000 x 4000 free cells in some kilobytes."""
    from io import BytesIO

    from PIL import Image

    side = chance.choice((1000, 2000, 4000))
    stream = BytesIO()
    Image.new("L", (side, side), 255).save(stream, "PNG")
    return stream.getvalue()


def _mission(chance: Chance) -> Files:
    files = _others()
    text = _shipped()[chance.choice(sorted(_shipped()))]
    data = _data(text)
    for _ in range(chance.choice((0, 1, 1, 1, 2, 3))):
        if _slots(data):
            chance.choice(OF_DATA)(data, chance)
    kind = chance.random()
    written = text if kind < 0.2 else _written(data)
    if kind < 0.35:
        for _ in range(chance.choice((1, 1, 2, 6))):
            written = _text_mutated(written, chance)
    content = written.encode("utf-8", "surrogatepass")
    if kind > 0.97:
        content = _bytes_mutated(content, chance)
    if chance.random() < 0.25:
        _mutate_other(files, chance)
    return files | {MISSION: content}


def _mutate_other(files: Files, chance: Chance) -> None:
    """A file that the mission needs is another one."""
    name = chance.choice(sorted(files))
    if name.endswith(".pgm"):
        files[name] = chance.choice((_image, _png))(chance)
    elif chance.random() < 0.3:
        files[name] = _bytes_mutated(files[name], chance)
    elif chance.random() < 0.1:
        del files[name]
    else:
        text = files[name].decode()
        for _ in range(chance.choice((1, 2, 6))):
            text = _text_mutated(text, chance)
        files[name] = text.encode("utf-8", "surrogatepass")[: 256 * 1024]


# -- formulas ----------------------------------------------------------------------------------

UNARY = ("!", "X ", "F ", "G ", "G F ", "F G ")
BINARY = (" U ", " W ", " R ", " & ", " | ", " -> ", " <-> ")
NAMES = ("Home", "A", "B", "C", "r1", "r2", "r3")
FACTS = (*(f"at({name})" for name in NAMES), "targetFound", "targetReported")
Family = Callable[[int, Chance], str]


def _facts(data: Data) -> tuple[str, ...]:
    places, events = data.get("places"), data.get("events")
    named = [f"at({name})" for name in places] if isinstance(places, dict) else []
    return (*named, *(events if isinstance(events, dict) else ())) or FACTS


def random_formula(chance: Chance, facts: tuple[str, ...] = FACTS, depth: int = 4) -> str:
    if depth == 0 or chance.random() < 0.1:
        return chance.choice(facts)
    if chance.random() < 0.45:
        return f"{chance.choice(UNARY)}({random_formula(chance, facts, depth - 1)})"
    one, other = (random_formula(chance, facts, depth - 1) for _ in range(2))
    return f"({one}{chance.choice(BINARY)}{other})"


def mutated(text: str, chance: Chance) -> str:
    """A formula with other operators."""
    for _ in range(chance.choice((1, 2, 5))):
        at = chance.randrange(len(text) + 1)
        match chance.randrange(6):
            case 0:
                text = f"{chance.choice(UNARY)}({text})"
            case 1:
                text = f"({text}){chance.choice(BINARY)}({random_formula(chance)})"
            case 2:
                old, new = chance.sample(("F", "G", "X", "&", "|", "->"), 2)
                text = text.replace(old, new)
            case 3:
                text = (
                    text[:at] + chance.choice((")", "(", "U", "!", "X", "@", "é", " ")) + text[at:]
                )
            case 4:
                text = text[:at] + text[at + chance.randint(1, 9) :]
            case _:
                text = chance.choice(("X ", "F ", "G ")) * chance.choice((3, 30, 200)) + f"({text})"
    return text


def _joined(operator: str, parts: Iterator[str]) -> str:
    return operator.join(f"({part})" for part in parts)


def _of(chance: Chance, count: int, scheme: str) -> Iterator[str]:
    """A scheme with facts for its `a`, `b` and `c`."""
    for _ in range(count):
        yield scheme.format(**{letter: chance.choice(FACTS) for letter in "abc"})


def _chain(operators: tuple[str, ...], count: int, chance: Chance, is_left: bool) -> str:
    text = chance.choice(FACTS)
    for _ in range(count):
        operator, fact = chance.choice(operators), chance.choice(FACTS)
        text = f"({text}{operator}{fact})" if is_left else f"({fact}{operator}{text})"
    return text


SCHEMES = (
    "F {a}", "G F {a}", "F G {a}", "{a} U {b}", "G ({a} -> F {b})", "G F {a} -> G F {b}",
    "G ({a} -> X {b})", "F ({a} & X F {b})", "X X X {a}", "{a} W ({b} R {c})", "G ({a} | F {b})",
    "F ({a} & F ({b} & F {c}))", "G ({a} -> X X X (!{b} U {c}))", "{a} <-> X {b}",
)  # fmt: skip
FAMILIES: tuple[Family, ...] = (
    lambda n, c: "X " * n + c.choice(FACTS),
    lambda n, c: "X " * n + f"({random_formula(c)})",
    lambda n, c: "G F " * n + c.choice(FACTS),
    lambda n, c: "!" * n + c.choice(FACTS),
    lambda n, c: "(" * n + c.choice(FACTS) + ")" * n,
    lambda n, c: "(" * n + c.choice(FACTS),
    lambda n, c: _chain((" U ", " R "), n, c, c.random() < 0.5),
    lambda n, c: _chain((" -> ", " <-> "), n, c, c.random() < 0.5),
    lambda n, c: _chain((" & ", " | "), n, c, c.random() < 0.5),
    lambda n, c: _chain(BINARY, n, c, c.random() < 0.5),
    lambda n, c: _joined(" & ", _of(c, n, c.choice(SCHEMES))),
    lambda n, c: _joined(" | ", _of(c, n, c.choice(SCHEMES))),
    lambda n, c: "G (" + _joined(" & ", _of(c, n, c.choice(SCHEMES))) + ")",
    lambda n, c: "F (" + _joined(" & ", _of(c, n, c.choice(SCHEMES))) + ")",
    lambda n, c: _joined(" <-> ", _of(c, n, c.choice(SCHEMES))),
    lambda n, c: f"G ({c.choice(FACTS)} -> {'X ' * n}{c.choice(FACTS)})",
    lambda n, c: "G F (" + _joined(" & X ", _of(c, n, "{a} | {b}")) + ")",
    lambda n, c: f"patrolling({', '.join(c.choice(NAMES) for _ in range(n))})",
    lambda n, c: f"ordered_patrolling({', '.join(c.sample(NAMES, min(n, 7)))})",
    lambda n, c: f"strict_ordered_visit({', '.join(c.choice(NAMES) for _ in range(n))})",
    lambda n, c: random_formula(c, depth=min(n, 10)),
    lambda n, c: " & ".join(f"unknown{i}" for i in range(n)),
    lambda n, c: " ".join(c.choice((*BINARY, *UNARY, *FACTS, "(", ")")) for _ in range(n)),
    lambda n, c: c.choice(("U", "at()", "at(A, B)", "\u202e", "é" * n, "a" * n, "1", "", "X", "@")),
)
SIZES = (1, 2, 3, 5, 8, 12, 20, 40, 100, 200, 700, 3000)
LONGEST = 60_000
"""Characters; a mission of more than 64 KiB is refused for its size."""


def hostile_formula(chance: Chance) -> str:
    text = chance.choice(FAMILIES)(chance.choice(SIZES), chance)
    if chance.random() < 0.2:
        text = mutated(text, chance)
    return text[:LONGEST]


def _formula_mission(chance: Chance) -> Files:
    """The surveillance mission with a hostile line."""
    data = _data(_shipped()["surveillance"])
    line = {"hostile": hostile_formula(chance)}
    data["task"] = line if chance.random() < 0.5 else data["task"] | line
    return _others() | {MISSION: _written(data).encode("utf-8", "surrogatepass")}


# -- time bounds -------------------------------------------------------------------------------

BOUNDED = (
    "F[<={t}] {a}", "G({a} -> F[<={t}] {b})", "revisit({p}) <= {t}", "revisit({a} | {b}) <= {t}",
    "revisit({a} & X {b}) <= {t}", "G F[<={t}] {a}", "F[<={t}] ({a} & F[<={t}] {b})",
    "!F[<={t}] {a}", "X F[<={t}] {a}", "({a}) U (F[<={t}] {b})", "F[>={t}] {a}", "G[<={t}] {a}",
    "G({a} -> F[<={t}] ({b} & F {c}))", "revisit({p})", "revisit() <= {t}", "F[<={t}, 3 s] {a}",
)  # fmt: skip
KEPT = BOUNDED[:4]
"""Those that have a meaning."""
ODD_TIMES = ("0 s", "-5 s", "1e9 s", "3 s", "nan s", "10", "5 min", "1 h", "1e308min", "0x5s", "")


def _bounds_mission(chance: Chance) -> Files:
    """A shipped mission with lines that are bounded in time, some of them `ready` for an event."""
    names = [name for name, text in _shipped().items() if "\ntask:" in text]
    data = _data(_shipped()[chance.choice(sorted(names))])
    if chance.random() < 0.3:
        more_places(data, chance)
    facts, places = _facts(data), [*data["places"]]
    schemes = BOUNDED if chance.random() < 0.3 else KEPT
    lines: dict[str, Any] = {}
    for number in range(chance.choice((1, 2, 3, 4, 6, 12, 40))):
        a, b, c = (chance.choice(facts) for _ in range(3))
        is_odd = chance.random() < 0.05
        time = chance.choice(ODD_TIMES) if is_odd else f"{chance.lognormvariate(4, 1):.3g} s"
        line = chance.choice(schemes).format(a=a, b=b, c=c, p=chance.choice(places), t=time)
        is_optional = chance.random() < 0.15
        lines[f"l{number}"] = {"formula": line, "priority": 1} if is_optional else line
    data["task"] = lines if chance.random() < 0.3 else data["task"] | lines
    if chance.random() < 0.3:
        data["ready"] = chance.sample([*lines], min(2, len(lines)))
    if chance.random() < 0.2:
        chance.choice(OF_DATA)(data, chance)
    return _others() | {MISSION: _written(data).encode("utf-8", "surrogatepass")}
