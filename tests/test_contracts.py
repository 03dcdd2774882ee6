"""The doors between the rooms stay shut: what is loaded, and private names. Who imports whom: `make lint`."""

import ast
import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[1]
# Names that begin with an underscore because Python, asyncio, Panel or IPython gives them their meaning
OTHERS = {"_run", "_replace", "_asdict", "_fields", "_make", "_esm", "_stylesheets", "_send_msg", "_repr_html_"}


SCREEN = {"panel", "bokeh", "holoviews", "tornado"}
WITHOUT = """
from importlib import import_module
import sys
for name in sys.argv[1:]:
    import_module(f"vibroscope.{name}")
    print(*sys.modules)
"""


def test_no_screen_is_loaded_where_none_is_needed_and_the_page_starts_without_what_draws_files():
    """HoloViews alone imports a part of matplotlib, its colour maps."""
    names = [f"app.explorer.{name}" for name in ("compute", "present", "reading")]
    names = ["engine", *names, "app.commands.cli", "app.paper", "app.commands.paper", "app.server.server"]
    command = [sys.executable, "-c", WITHOUT, *names]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=120, check=True)
    loaded = dict(zip(names, map(str.split, done.stdout.splitlines()), strict=True))
    page = {*loaded.pop("app.server.server")}
    assert [name for name, modules in loaded.items() if SCREEN & {*modules}] == []
    assert SCREEN | {"vibroscope.app.export.drawing"} <= page
    assert not {"matplotlib.figure", "matplotlib.font_manager", "matplotlib.pyplot"} & page


def nodes_of(*folders, names=None):
    """File and node of all Python in some folders; modules `compat` take private names of others.

    ``names``: files that hold none of these words are left out.
    """
    for path in (path for folder in folders for path in (ROOT / folder).rglob("*.py") if path.stem != "compat"):
        text = path.read_text(encoding="utf-8")
        if names is None or not names.isdisjoint(re.findall(r"\w+", text)):
            yield from ((path, node) for node in ast.walk(ast.parse(text)))


def names_defined(node):
    if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
        return [node.name]
    name = node.attr if isinstance(node, ast.Attribute) else getattr(node, "id", None)
    return [name] if isinstance(getattr(node, "ctx", None), ast.Store) and name else []


def names_used(node):
    """Names of others that a node reads, imports, or holds as a text such as the target of a patch."""
    if isinstance(node, ast.Attribute):
        own = isinstance(node.value, ast.Name) and node.value.id in ("self", "cls")
        return [] if own else [node.attr]
    if isinstance(node, ast.ImportFrom):
        return [alias.name for alias in node.names]
    return node.value.split(".")[-1:] if isinstance(node, ast.Constant) and isinstance(node.value, str) else []


def test_tests_and_benchmarks_use_no_private_name_of_the_product():
    private = {name for _, node in nodes_of("app", "engine") for name in names_defined(node)}
    private = {name for name in private - OTHERS if len(name) > 1 and name[0] == "_" != name[1]}
    nodes = list(nodes_of("tests", "benchmarks", names=private))
    parts = {id(part) for _, node in nodes if isinstance(node, ast.JoinedStr) for part in node.values}
    found = [
        f"{path.relative_to(ROOT)}:{node.lineno} {name}"
        for path, node in nodes
        for name in names_used(node)
        if name in private and id(node) not in parts
    ]
    assert not found, f"test it by its public way, or give it a public name: {found}"
