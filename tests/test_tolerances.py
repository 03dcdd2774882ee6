"""Tolerances stand in one place a package, each with its unit and its reason; no name stands for two numbers."""

import ast
import io
import re
import tokenize
from collections import defaultdict
from pathlib import Path

import pytest

ENGINE = Path(__file__).parents[1] / "engine"
BEHIND_THE_DOOR = {"kernels", "drivers"}  # tuples of numbers there are places in an array, or codes
TOLERANCES = sorted(ENGINE.rglob("tolerances.py"))


@pytest.fixture(scope="module")
def modules():
    """What each file of the engine says, by its path."""
    return {path: ast.parse(path.read_text(encoding="utf-8")) for path in sorted(ENGINE.rglob("*.py"))}


def number(node):
    """The number that an expression of literals is; None if it is none."""
    if not isinstance(node, ast.Constant | ast.BinOp | ast.UnaryOp) or any(
        isinstance(part, ast.Name | ast.Call | ast.Attribute) for part in ast.walk(node)
    ):
        return None
    value = eval(compile(ast.Expression(node), "", "eval"), {"__builtins__": {}})
    return value if isinstance(value, int | float) and not isinstance(value, bool) else None


def constants(path, module):
    """Name, number and line of each constant of a module that is a number, or one of a tuple of numbers."""
    places = BEHIND_THE_DOOR.isdisjoint(path.relative_to(ENGINE).parts)
    for node in module.body:
        if not isinstance(node, ast.Assign):
            continue
        (target,), value = node.targets, node.value
        both_tuples = isinstance(target, ast.Tuple) and isinstance(value, ast.Tuple) and places
        pairs = zip(target.elts, value.elts, strict=True) if both_tuples else [(target, value)]
        for name, literal in pairs:
            if isinstance(name, ast.Name) and (found := number(literal)) is not None:
                yield name.id, found, node.lineno


def test_no_name_stands_for_two_numbers(modules):
    found = defaultdict(lambda: defaultdict(list))
    for path, module in modules.items():
        for name, value, _ in constants(path, module):
            found[name][value].append(str(path.relative_to(ENGINE)))
    assert not {name: dict(values) for name, values in found.items() if len(values) > 1}


def test_every_tolerance_is_used(modules):
    assert len(TOLERANCES) > 5
    for path in TOLERANCES:
        names = {node.targets[0].id for node in modules[path].body if isinstance(node, ast.Assign)}
        own = {
            node.id for node in ast.walk(modules[path]) if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load)
        }
        used = {name for module in modules.values() for name in taken_from(module, path.parent.name)}
        assert names <= used | own, names - used - own


def taken_from(module, package):
    """Names that a module takes from the tolerances of a package, its own or another one."""
    for node in ast.walk(module):
        if isinstance(node, ast.ImportFrom) and re.fullmatch(rf".*\.{package}\.tolerances", node.module or ""):
            yield from (alias.name for alias in node.names)


def test_every_tolerance_has_its_reason(modules):
    for path in TOLERANCES:
        tokens = tokenize.generate_tokens(io.StringIO(path.read_text(encoding="utf-8")).readline)
        comments = [token for token in tokens if token.type == tokenize.COMMENT]
        # beside a constant, or on a line of their own above it
        explained = {token.start[0] + (token.line.lstrip()[0] == "#") for token in comments}
        bare = [node.lineno for node in modules[path].body[1:] if node.lineno not in explained]
        assert not bare, f"{path.relative_to(ENGINE)}: say unit and reason beside lines {bare}"
