"""Behaviour trees as text, DOT and XML, held against the rules that BehaviorTree.CPP checks."""

from __future__ import annotations

import re
from pathlib import Path
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import pytest
from synthetic import command, mission

from companion.api.trees import BehaviourTree, behaviour_tree
from companion.errors import CompanionError, MissionError
from companion.flight_events.tree import LeafType, NodeType
from companion.mission.loader import load_mission
from companion.mission.model import Mission

MISSIONS = Path(__file__).parents[3] / "missions"
SHIPPED = sorted(p.stem for p in MISSIONS.glob("*.yaml") if not p.stem.endswith(".sim"))
LIKE_OTHERS = {
    *("corridor", "endless_patrol", "field", "hall_of_20", "open_field", "orchard"),
    *("paper_section_v", "persistent_patrol", "return_home"),
}
"""Their trees have no node that no other has."""
DECORATORS = {"Inverter", "Repeat", "RetryUntilSuccessful", "Timeout"}
CONTROLS = {"Sequence", "ReactiveSequence", "Fallback", "Parallel"}
LEAVES = {"Action", "Condition"}
ATTRIBUTES = {
    "RetryUntilSuccessful": {"num_attempts"},
    "Repeat": {"num_cycles"},
    "Timeout": {"msec"},
    "Parallel": {"success_count", "failure_count"},
}
"""Ports of the library's nodes that are written, by its documentation."""
BUILT_IN = DECORATORS | CONTROLS | {"Precondition", "Delay", "Sleep", "ForceSuccess", "SubTree"}
"""Some of the names that the library has registered."""

EVERY_KIND = """
tree:
  - {subtree: look}
  - parallel: [[wait(1), "move(*, A)"], "!found"]
  - inverter: [found]
  - {timeout: [upload(A)], duration_s: 2.5}
  - {retry: [{subtree: look}, {subtree: Sequence}], times: 3}
  - {repeat: [{fallback: [found, upload(A)]}], times: 2}
  - watch: "!found & !low"
    do: [{repeat: [{subtree: MainTree}]}]
subtrees:
  look: ["move(*, A)", {subtree: MainTree}]
  Sequence: [upload(A)]
  MainTree: [found]
"""


@pytest.fixture
def every_kind() -> Mission:
    text = (MISSIONS / "by_hand.yaml").read_text(encoding="utf-8")
    head = text[: text.index("# A list is done")].replace("targetFound", "found")
    low = '  low: {when: "BATTERY_STATUS.battery_remaining < 30"}\nskills:'
    head = head.replace("UploadSite: [r1, r2]", "UploadSite: [r1, A]").replace("skills:", low)
    return load_mission(head + EVERY_KIND, MISSIONS)


def verified(xml: str) -> Element:
    """The document, if it keeps the rules: those of VerifyXML, and of the schematron file."""
    root = ElementTree.fromstring(xml)
    assert (root.tag, root.attrib["BTCPP_format"]) == ("root", "4")
    trees = {tree.attrib["ID"]: tree for tree in root.findall("BehaviorTree")}
    assert len(trees) == len(root.findall("BehaviorTree"))
    assert root.attrib["main_tree_to_execute"] in trees
    (model,) = root.findall("TreeNodesModel")
    declared = {node.attrib["ID"]: node.tag for node in model}
    assert len(declared) == len(model)
    assert not BUILT_IN & {*declared, *trees}
    assert len(root) == len(trees) + 1
    for tree in trees.values():
        assert len(tree) == 1
        for node in list(tree.iter())[1:]:
            own = set(node.attrib) - {"name", "ID"}
            assert own == ATTRIBUTES.get(node.tag, set()), node.tag
            if node.tag == "SubTree":
                assert len(node) == 0 and node.attrib["ID"] in trees
            elif node.tag in LEAVES:
                assert len(node) == 0 and declared[node.attrib["ID"]] == node.tag
            elif node.tag in DECORATORS:
                assert len(node) == 1
            else:
                assert node.tag in CONTROLS and len(node) > 0
    return root


def all_formats_agree(tree: BehaviourTree) -> None:
    lines = tree.to_text().splitlines()
    assert len(lines) == len(tree.nodes)
    assert [len(line) - len(line.lstrip(" ")) for line in lines] == [
        2 * n.depth for n in tree.nodes
    ]
    drawn = tree.to_dot()
    assert len(re.findall(r"^  n\d+ \[label=", drawn, re.M)) == len(lines)
    edges = re.findall(r"^  n(\d+) -> n(\d+)$", drawn, re.M)
    assert [int(child) for _, child in edges] == list(range(1, len(lines)))
    assert all(tree.nodes[int(a)].depth + 1 == tree.nodes[int(b)].depth for a, b in edges)
    root = verified(tree.to_xml())
    if not any(node.type is NodeType.SUBTREE for node in tree.nodes):
        (only,) = root.findall("BehaviorTree")
        assert [node.attrib["name"] for node in list(only.iter())[1:]] == [
            node.name for node in tree.nodes
        ]


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=[pytest.mark.long] if name in LIKE_OTHERS else [])
        for name in SHIPPED
    ],
)
def test_the_trees_of_shipped_missions_keep_the_rules(name: str) -> None:
    all_formats_agree(behaviour_tree(load_mission(MISSIONS / f"{name}.yaml")))


def test_every_kind_of_node_keeps_the_rules(every_kind: Mission) -> None:
    tree = behaviour_tree(every_kind)
    assert {node.type for node in tree.nodes} == set(NodeType)
    all_formats_agree(tree)


def test_numbers_are_written_as_the_library_reads_them(every_kind: Mission) -> None:
    root = verified(behaviour_tree(every_kind).to_xml())

    def values(tag: str, attribute: str) -> set[str]:
        return {node.attrib[attribute] for node in root.iter(tag)}

    assert values("Timeout", "msec") == {"2500"}
    assert values("Repeat", "num_cycles") == {"2", "-1"}
    assert values("RetryUntilSuccessful", "num_attempts") == {"3"}


def test_a_subtree_is_written_once_whatever_its_name(every_kind: Mission) -> None:
    root = verified(behaviour_tree(every_kind).to_xml())
    ids = [tree.attrib["ID"] for tree in root.findall("BehaviorTree")]
    assert sorted(ids) == ["MainTree", "subtree_MainTree", "subtree_Sequence", "subtree_look"]
    used = [node.attrib["name"] for node in root.iter("SubTree")]
    assert sorted(used) == ["MainTree", "MainTree", "Sequence", "look", "look"]


def test_every_leaf_that_there_is_has_a_node_of_its_own() -> None:
    from companion.api.tree_xml import LEAVES as written

    assert set(written) == set(LeafType)
    names = [name for _, name in written.values()]
    assert len(set(names)) == len(names)
    assert not BUILT_IN & set(names)
    assert all(re.fullmatch(r"[A-Za-z]+", name) for name in names)


def test_names_are_escaped(every_kind: Mission) -> None:
    tree = behaviour_tree(every_kind)
    assert "watch !found &amp; !low" in tree.to_xml()


def test_without_a_plan_the_reason_is_raised() -> None:
    with pytest.raises(CompanionError, match="no plan: task cannot hold"):
        behaviour_tree(mission("F gone", skills=[command("do", "", "done")]))


def test_what_is_no_run_folder_is_refused(tmp_path: Path) -> None:
    with pytest.raises(MissionError, match="is not a run folder"):
        behaviour_tree(tmp_path)
