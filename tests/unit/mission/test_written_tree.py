"""Trees in a mission file: what each node means, and mistakes."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from synthetic import facts_of

from companion.errors import MissionError
from companion.mission.model import Mission
from companion.mission.tree_nodes import (
    Act,
    Check,
    Fallback,
    Inverter,
    Parallel,
    Repeat,
    Retry,
    Steps,
    Subtree,
    Timeout,
    WaitFor,
    Watch,
)

Load = Callable[[str | bytes], Mission]
FOUND = Check("found & !low", facts_of("found"), facts_of("low"))


def with_tree(good: str, tree: str) -> str:
    return f"{good}tree:\n{tree}\n"


def test_every_kind_of_node(load: Load, good: str) -> None:
    text = """\
  - move(Home, A)
  - found & !low
  - fallback: [found & !low, upload(A)]
  - repeat:
      - "move(A,Home)"
  - {repeat: [upload(A)], times: 2}
  - {retry: [upload(A)], times: 3}
  - watch: found & !low
    do: [[upload(A)], "move(here, A)"]
  - {inverter: [found & !low]}
  - {timeout: ["move(*, A)"], duration_s: 2.5}
  - wait(5)
  - parallel:
      - found & !low
      - [upload(A), wait(0.5)]
"""
    upload = Act("upload(A)")
    assert load(with_tree(good, text)).tree == Steps(
        (
            Act("move(Home, A)"),
            FOUND,
            Fallback((FOUND, upload)),
            Repeat(Steps((Act("move(A, Home)"),)), None),
            Repeat(Steps((upload,)), 2),
            Retry(Steps((upload,)), 3),
            Watch(FOUND, Steps((Steps((upload,)), Act("move(here, A)")))),
            Inverter(Steps((FOUND,))),
            Timeout(Steps((Act("move(*, A)"),)), 2.5),
            WaitFor(5.0),
            Parallel((FOUND, Steps((upload, WaitFor(0.5))))),
        )
    )


def test_a_tree_needs_no_task(load: Load, good: str) -> None:
    start, end = good.index("task:"), good.index("otherwise:")
    mission = load(with_tree(good[:start] + good[end:], "  - move(Home, A)"))
    assert mission.task == {}


@pytest.mark.parametrize(
    ("node", "what"),
    [
        ("mov(Home, A)", "unknown fact mov"),
        ("move(Home)", "has not the arguments of move(from, to)"),
        ("move(Home, B)", "B is not in Place"),
        ("move(from=Home, to=A)", "move takes no argument by name"),
        ("move(Home, A) & found", "write several as a list: [move(Home, A), ...]"),
        ("move(Home A)", "not an argument"),
        ("upload(here)", "here is not in Site"),
        ("[move(Home, A)]", "half an action"),
        ("{fallbak: [found]}", "unknown node fallbak"),
        ("{repeat: [found], time: 2}", "repeat has no key time"),
        ("{retry: [found]}", "retry needs times"),
        ("{repeat: [found], times: 0}", "repeat needs times"),
        ("{timeout: [found]}", "timeout needs duration_s"),
        ("{timeout: [found], duration_s: 0}", "timeout needs duration_s"),
        ("{timeout: [found], duration_s: true}", "timeout needs duration_s"),
        ("{timeout: [found], duration_s: .inf}", "finite"),
        ("{inverter: [found], times: 2}", "inverter has no key times"),
        ("wait(-1)", "a time cannot be negative"),
        ("wait(soon)", "soon is not a number"),
        ("wait", "wait has no time"),
        ("move(A, *)", "* is not in Place"),
        ("upload(*)", "* is not in Site"),
        ("move(A, here)", "here is not in Place"),
        ("{subtree: nowhere}", "unknown subtree nowhere"),
        ("{subtree: [found]}", "unknown subtree"),
        ("{parallel: [upload(A), upload(no)]}", "upload(A) and upload(no)"),
        ("{parallel: [upload(A), found, {repeat: [upload(A)]}]}", "at the same time"),
        ("{watch: [found], do: [found]}", "watch needs facts"),
        ("{watch: found}", "not a node of a tree"),
        ("{fallback: []}", "not a node of a tree"),
        ("3", "not a node of a tree"),
        ("found | low", "neither a fact"),
    ],
)
def test_mistakes_are_placed_and_explained(load: Load, good: str, node: str, what: str) -> None:
    text = with_tree(good, f"  - {node}")
    with pytest.raises(MissionError) as caught:
        load(text)
    assert f":{text.count(chr(10))}:" in str(caught.value).splitlines()[0]
    assert what in str(caught.value)


# -- subtrees --------------------------------------------------------------------------------------


def with_subtrees(good: str, subtrees: str, tree: str) -> str:
    return f"{good}subtrees:\n{subtrees}\ntree:\n{tree}\n"


def test_a_subtree_is_defined_once_and_used_by_its_name(load: Load, good: str) -> None:
    subtrees = "  visit: [move(*, A), {subtree: see}]\n  see: [found & !low]".replace(
        "move(*, A)", '"move(*, A)"'
    )
    tree = load(with_subtrees(good, subtrees, "  - {subtree: visit}\n  - {subtree: see}")).tree
    see = Subtree("see", Steps((FOUND,)))
    assert tree == Steps((Subtree("visit", Steps((Act("move(*, A)"), see))), see))


@pytest.mark.parametrize("node", ["called", "{watch: '!called', do: [found]}"])
def test_what_is_there_for_a_moment_no_node_sees(load: Load, good: str, node: str) -> None:
    called = "events:\n  called: {when: COMMAND.MAV_CMD_USER_3%s}"
    latched = good.replace("events:", called % ", latch: true")
    assert load(with_tree(latched, f"  - {node}")).tree is not None
    with pytest.raises(MissionError, match="called is there for a moment"):
        load(with_tree(good.replace("events:", called % ""), f"  - {node}"))


@pytest.mark.parametrize(
    ("subtrees", "tree", "line", "what"),
    [
        ("  a: [{subtree: a}]", "[found]", -3, "the subtree a is a part of itself: a -> a"),
        (
            "  a: [{subtree: b}]\n  b: [found, {subtree: c}]\n  c: [{subtree: b}]",
            "[{subtree: a}]",
            -3,
            "the subtree b is a part of itself: b -> c -> b",
        ),
        ("  a: [foun]", "[found]", -3, "unknown fact foun"),  # though nothing uses it
        ("  a: [found]", "[{subtree: b}]", -1, "unknown subtree b"),
        ("  a: []", "[found]", -3, "not a node"),
        ("  a: [upload(A)]", "[{parallel: [{subtree: a}, {subtree: a}]}]", -1, "at the same time"),
    ],
)
def test_mistakes_in_subtrees_are_placed(
    load: Load, good: str, subtrees: str, tree: str, line: int, what: str
) -> None:
    text = f"{good}subtrees:\n{subtrees}\ntree:\n  - {tree}\n"
    with pytest.raises(MissionError) as caught:
        load(text)
    assert what in str(caught.value)
    number = int(str(caught.value).split(":")[1])
    assert number == text.count("\n") + line + 1


def test_subtrees_without_a_tree_are_refused(load: Load, good: str) -> None:
    with pytest.raises(MissionError, match="there are subtrees, and no tree"):
        load(f"{good}subtrees:\n  a: [found]\n")


def chain(length: int, inner: str = "found") -> str:
    """Subtrees each of which uses the one before."""
    rows = [f"  s0: [{inner}]"]
    rows += [f"  s{i}: [{{subtree: s{i - 1}}}]" for i in range(1, length)]
    return "\n".join(rows)


@pytest.mark.parametrize("is_reversed", [False, True])
def test_subtrees_may_not_be_nested_too_deep(load: Load, good: str, is_reversed: bool) -> None:
    def text(length: int) -> str:
        rows = chain(length)
        rows = "\n".join(reversed(rows.splitlines())) if is_reversed else rows
        return with_subtrees(good, rows, f"  - {{subtree: s{length - 1}}}")

    assert load(text(8)).tree is not None
    for length in (9, 500):
        with pytest.raises(MissionError, match="more than 8 nested subtrees"):
            load(text(length))


def test_subtrees_that_multiply_are_refused_before_they_do(load: Load, good: str) -> None:
    """Eight levels of 100 uses each would be more nodes than there are in the world."""
    rows = ["  s0: [found]"]
    rows += [f"  s{i}: [{', '.join([f'{{subtree: s{i - 1}}}'] * 100)}]" for i in range(1, 8)]
    with pytest.raises(MissionError, match="a tree has at most 2000"):
        load(with_subtrees(good, "\n".join(rows), "  - {subtree: s7}"))
