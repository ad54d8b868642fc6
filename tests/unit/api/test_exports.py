"""What `import companion` brings, and what it leaves for later."""

from __future__ import annotations

import ast
import subprocess
import sys
import typing
from pathlib import Path

import pytest

import companion

SOURCE = Path(companion.__file__).read_text(encoding="utf-8")
SLOW_TO_IMPORT = {"jsbsim", "lark", "matplotlib", "networkx", "numpy", "pydantic", "pymavlink"}
WITHOUT_JSBSIM = """
import sys
from importlib.abc import MetaPathFinder

class Missing(MetaPathFinder):
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] == "jsbsim":
            raise ImportError(name)

import importlib.util
find_spec = importlib.util.find_spec
importlib.util.find_spec = lambda name, *rest: None if name == "jsbsim" else find_spec(name, *rest)
sys.meta_path.insert(0, Missing())
"""


def run(script: str) -> str:
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, timeout=120, check=False
    )
    assert (done.returncode, done.stderr) == (0, "")
    return done.stdout


def test_the_import_loads_nothing_that_is_slow() -> None:
    imported = set(run("import sys, companion; print(*sys.modules)").split())
    assert "companion" in imported
    assert not SLOW_TO_IMPORT & imported
    assert not [name for name in imported if name.startswith("companion.")]


def test_one_name_does_not_load_all() -> None:
    script = "import sys; from companion import parse_formula; parse_formula('G F p')"
    imported = set(run(f"{script}; print(*sys.modules)").split())
    assert "lark" in imported
    assert not {"matplotlib", "numpy", "pymavlink"} & imported


@pytest.mark.slow
def test_it_works_where_jsbsim_is_missing() -> None:
    out = run(
        WITHOUT_JSBSIM + "import companion\n"
        "for name in companion.__all__: getattr(companion, name)\n"
        "mission = companion.load_mission('missions/surveillance.yaml')\n"
        "print(companion.Planner(mission).plan())\n"
        "try: companion.simulate(mission)\n"
        "except companion.CompanionError as error: print(error)\n"
        "print('jsbsim' in sys.modules)\n"
    )
    plan, why, _, has_jsbsim = out.splitlines()
    assert plan == "move(Home, A), (move(A, B), move(B, C), move(C, A))^w"
    assert why.startswith("the simulator needs jsbsim")
    assert has_jsbsim == "False"


def test_the_list_is_short() -> None:
    assert len(SOURCE.splitlines()) <= 84


def test_types_and_table_of_the_exports_agree() -> None:
    typed = {
        (node.module, name.name)
        for node in ast.walk(ast.parse(SOURCE))
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("companion.")
        for name in node.names
    }
    assert typed == {(module, name) for name, module in companion._MODULES.items()}
    assert dir(companion) == sorted(companion.__all__)
    assert not typing.TYPE_CHECKING


@pytest.mark.parametrize("name", companion.__all__)
def test_a_name_is_there_and_documented(name: str) -> None:
    thing = getattr(companion, name)
    assert thing.__name__ == name
    assert thing.__doc__
    is_verb = not isinstance(thing, type)
    if is_verb or name == "Planner":
        assert ">>> " in thing.__doc__, "a public function shows its use"


def test_another_name_is_none_of_them() -> None:
    with pytest.raises(AttributeError, match="has no attribute 'plan_mission'"):
        companion.plan_mission  # type: ignore[attr-defined]  # noqa: B018
