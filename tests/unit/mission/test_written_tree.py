"""Trees in a mission file: what each node means, and mistakes."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from synthetic import facts_of

from companion.errors import MissionError
from companion.mission.model import Mission
from companion.mission.tree_nodes import Act, Check, Fallback, Repeat, Retry, Steps, Watch

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
        ("upload(here)", "here is not in Site"),
        ("[move(Home, A)]", "half an action"),
        ("{fallbak: [found]}", "unknown node fallbak"),
        ("{repeat: [found], time: 2}", "repeat has no key time"),
        ("{retry: [found]}", "retry needs times"),
        ("{repeat: [found], times: 0}", "repeat needs times"),
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
