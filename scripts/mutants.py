"""Mutants of a module: its source with one small mistake each. Pure functions.

Comparisons are shifted or negated; `and` and `or`, `+` and `-`, `*` and `/` are exchanged; numbers
are increased, truth values negated, pairs swapped; a name is dropped from a tuple, a call or a
result is left out. Texts, annotations, type aliases and decorators are not changed: a wrong word is
no wrong flight.
"""

from __future__ import annotations

import ast
import copy
from collections import Counter
from collections.abc import Iterator
from typing import Any, NamedTuple

SWAPS: dict[type[ast.AST], type[Any]] = {
    ast.Lt: ast.LtE,
    ast.LtE: ast.Lt,
    ast.Gt: ast.GtE,
    ast.GtE: ast.Gt,
    ast.Eq: ast.NotEq,
    ast.NotEq: ast.Eq,
    ast.Is: ast.IsNot,
    ast.IsNot: ast.Is,
    ast.In: ast.NotIn,
    ast.NotIn: ast.In,
    ast.And: ast.Or,
    ast.Or: ast.And,
    ast.Add: ast.Sub,
    ast.Sub: ast.Add,
    ast.Mult: ast.Div,
    ast.Div: ast.Mult,
    ast.Mod: ast.Mult,
    ast.Pow: ast.Mult,
    ast.BitAnd: ast.BitOr,
    ast.BitOr: ast.BitAnd,
    ast.BitXor: ast.BitAnd,
    ast.LShift: ast.RShift,
    ast.RShift: ast.LShift,
}
OPPOSITE: dict[type[ast.AST], type[Any]] = {
    ast.Lt: ast.Gt,
    ast.LtE: ast.GtE,
    ast.Gt: ast.Lt,
    ast.GtE: ast.LtE,
}


class Mutant(NamedTuple):
    """One mutant.

    Attributes:
        name: the mistake and its function; stable while its line in the source is.
        tree: the module with the mistake.
    """

    name: str
    tree: ast.Module


def mutants(source: str) -> list[Mutant]:
    """All mutants of a module.

    >>> [m.name for m in mutants("def f(a: int) -> bool: return a < 2")]
    ['f: return a < 2 -> return None', 'f: a < 2 -> a <= 2', 'f: a < 2 -> a > 2', 'f: 2 -> 20']
    """
    tree = ast.parse(source)
    return [Mutant(name, _with(tree, index, changed)) for name, index, changed in _mistakes(tree)]


def names(source: str) -> list[str]:
    """The names of all mutants of a module; making the mutants would take much longer.

    >>> names("a < 2")
    ['module: a < 2 -> a <= 2', 'module: a < 2 -> a > 2', 'module: 2 -> 20']
    """
    return [name for name, _, _ in _mistakes(ast.parse(source))]


def _mistakes(tree: ast.Module) -> Iterator[tuple[str, int, ast.AST]]:
    """The name of each mutant, the index of its node in `_nodes`, and the replacement."""
    seen: Counter[str] = Counter()
    for index, (where, node) in enumerate(_nodes(tree)):
        for changed in _changes(node):
            name = f"{where}: {_text(node)} -> {_text(changed)}"
            seen[name] += 1
            yield (name if seen[name] == 1 else f"{name} #{seen[name]}"), index, changed


def _nodes(tree: ast.Module) -> Iterator[tuple[str, ast.AST]]:
    """The nodes that may be mutated, in order, each with the name of its function."""

    def walk(node: ast.AST, where: str) -> Iterator[tuple[str, ast.AST]]:
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            where = node.name
        yield where, node
        match node:
            case ast.Assign(value=ast.Subscript(value=ast.Name())) if where == "module":
                return  # a type alias
        for field, value in ast.iter_fields(node):
            if field in ("annotation", "returns", "decorator_list", "bases"):
                continue
            for child in value if isinstance(value, list) else [value]:
                if isinstance(child, ast.AST):
                    yield from walk(child, where)

    return walk(tree, "module")


def _with(tree: ast.Module, index: int, changed: ast.AST) -> ast.Module:
    """The tree with one node replaced."""
    whole = copy.deepcopy(tree)
    for at, (_, node) in enumerate(_nodes(whole)):
        if at == index:
            node.__class__ = changed.__class__
            node.__dict__ = {**node.__dict__, **changed.__dict__}
    return ast.fix_missing_locations(whole)


def _changes(node: ast.AST) -> Iterator[ast.AST]:
    match node:
        case ast.Compare():
            for i, operator in enumerate(node.ops):
                for kinds in (SWAPS, OPPOSITE):
                    if type(operator) in kinds:
                        ops = [*node.ops[:i], kinds[type(operator)](), *node.ops[i + 1 :]]
                        yield ast.Compare(node.left, ops, node.comparators)
        case ast.BoolOp():
            yield ast.BoolOp(SWAPS[type(node.op)](), node.values)
        case ast.BinOp() | ast.AugAssign() if type(node.op) in SWAPS:
            changed = copy.copy(node)
            changed.op = SWAPS[type(node.op)]()
            yield changed
        case ast.UnaryOp(op=ast.Not(), operand=operand):
            yield ast.BoolOp(ast.And(), [operand, operand])
        case ast.UnaryOp(op=ast.USub(), operand=operand):
            yield ast.UnaryOp(ast.UAdd(), operand)
        case ast.Constant(value=bool() as value):
            yield ast.Constant(not value)
        case ast.Constant(value=int() | float() as value):
            yield ast.Constant(value * 10 if value else 1)
        case ast.Tuple(elts=[first, second]) if isinstance(node.ctx, ast.Load):
            if _text(first) == _text(second):
                return
            yield ast.Tuple([second, first], node.ctx)
        case ast.Tuple(elts=elements) if isinstance(node.ctx, ast.Load) and _are_names(elements):
            for i in range(len(elements)):
                yield ast.Tuple([*elements[:i], *elements[i + 1 :]], node.ctx)
        case ast.Return(value=value) if value is not None and _text(value) != "None":
            yield ast.Return(ast.Constant(None))
        case ast.Expr(value=ast.Call()):
            yield ast.Pass()


def _are_names(elements: list[ast.expr]) -> bool:
    return len(elements) > 2 and all(isinstance(e, ast.Name) for e in elements)


def _text(node: ast.AST) -> str:
    return " ".join(ast.unparse(node).split())[:90]
