"""The digest of the code that the numbers of a study come from.

It names the engine in stores, caches and shipped diagrams: a result is found again only by an engine whose code would
compute the same numbers with the same versions of Python, NumPy and Numba on the same processor. What cannot change a
number does not enter: docstrings, comments, formatting, annotations of arguments, the texts of errors, and the names of
the files.

Which code is numerical follows from the imports: the five studies and every module of the engine that they import,
directly or not. These are the compiled kernels with their drivers, the model, the methods, `simulate`, `run_cells`, and
of `motions` and `divergence` the modules that describe a motion or measure an error. `NOT_NUMERICAL` are imported by
the studies as well, but hold words and refusals alone. Everything else is left out, since no study imports it: chunks,
stores, places, the cluster, progress, verdicts, searches, measurements.
"""

import ast
import contextlib
import functools
import hashlib
from pathlib import Path
from typing import NamedTuple

from vibroscope.engine.drivers.code_cache import cache_root, source_digest

ENGINE = Path(__file__).parents[1]
STUDIES = tuple(Path("sweeps", f"{name}_study.py") for name in ("basin", "eta", "no_solution", "plane", "step"))
NOT_NUMERICAL = (
    *map(Path, ("arguments.py", "facts.py", "wording.py", "sweeps/digest.py", "sweeps/variables.py")),
    Path("kernels/compile/code_cache.py"),  # where machine code is kept
)
KERNELS = "kernels"  # their folder

_PACKAGE = __package__.rpartition(".")[0].split(".")  # of the engine, in absolute imports
_IGNORED_FIELDS = {"ctx", "kind", "returns", "type_comment", "type_ignores"}
_BLOCKS = {"body", "orelse", "finalbody"}  # of statements
_NAME = "name "  # before the name of a variable


@functools.cache
def engine_digest() -> str:
    """Digest of this engine's code, as it was when the process first asked."""
    return remembered_digest(ENGINE, cache_root() / "digests")


def remembered_digest(engine: Path, folder: Path) -> str:
    """Return `code_digest`, from a file if the same sources were read before: computing it takes 0.2 s of a start."""
    file = folder / source_digest(engine)
    with contextlib.suppress(OSError, ValueError):
        found = file.read_text()
        if found == _with_check(file, found[:12]):
            return found[:12]
    digest = code_digest(engine)
    with contextlib.suppress(OSError):
        folder.mkdir(parents=True, exist_ok=True)
        file.write_text(_with_check(file, digest))
    return digest


def _with_check(file: Path, digest: str) -> str:
    """The content of the file: with one wrong digit in it, this engine would refuse its own results."""
    return f"{digest} {_hash([file.name, digest])[:12]}"


def code_digest(engine: Path) -> str:
    """Digest of the numerical code of an engine in this folder, 12 hexadecimal digits.

    Each module is written as its syntax tree. A name that it imports from another module of the engine is written as
    the content of that module and the name there, so that neither files nor import lines enter. The digest is that of
    all modules, in the order of their own digests.
    """
    modules = numerical_modules(engine)
    contents = {path: _hash(module.words({})) for path, module in modules.items()}
    return _hash(sorted(_hash(module.words(contents)) for module in modules.values()))[:12]


def solver_digest(engine: Path = ENGINE) -> str:
    """Digest of the kernels alone: the compiled code in which single runs spend their time."""
    own = [module for path, module in numerical_modules(engine).items() if path.parts[0] == KERNELS]
    return _hash(sorted(_hash(module.words({})) for module in own))[:12]


def numerical_modules(engine: Path = ENGINE) -> dict[Path, "_Module"]:
    """The modules that enter the digest, by their paths in the engine's folder."""
    found, waiting = {}, list(STUDIES)
    while waiting:
        path = waiting.pop()
        if path not in found and path not in NOT_NUMERICAL:
            found[path] = _Module(engine, path)
            waiting += found[path].sources
    return found


def _hash(words: list[str]) -> str:
    return hashlib.sha256("\0".join(words).encode()).hexdigest()


class _Imported(NamedTuple):
    """A name of another module of the engine; "" stands for the module itself."""

    path: Path
    name: str

    def word(self, contents: dict[Path, str]) -> str:
        return f"{contents.get(self.path, '')}:{self.name}"


class _Module:
    """A module as words: what it imports from outside the engine and from within it, and its syntax tree."""

    def __init__(self, engine: Path, path: Path) -> None:
        self._engine = engine
        self._outside: set[str] = set()
        self._inside: set[tuple[str, _Imported]] = set()
        self._body: list[str] = []
        self._write_statements(ast.parse((engine / path).read_bytes()).body)

    @property
    def sources(self) -> set[Path]:
        """The modules of the engine that it imports from."""
        return {imported.path for _, imported in self._inside}

    def words(self, contents: dict[Path, str]) -> list[str]:
        """The module with the contents of those it imports from; with none at all, what it contains itself."""
        # a module is bound to the name of its file, which does not enter
        inside = sorted(f"{one.word(contents)} as {here if one.name else ''}" for here, one in self._inside)
        imported = {_NAME + here: one.word(contents) for here, one in self._inside}
        return [*sorted(self._outside), *inside, *(imported.get(word, word) for word in self._body)]

    def _add_imports(self, node: ast.Import | ast.ImportFrom) -> None:
        source = self._source_of(node)
        for alias in node.names:
            here = alias.asname or alias.name
            if source is None:
                self._outside.add(f"{getattr(node, 'module', '')} {alias.name} as {here}")
            elif module := _file_of(self._engine, [*source, alias.name]):
                self._inside.add((here, _Imported(module, "")))
            elif module := _file_of(self._engine, source):
                self._inside.add((here, _Imported(module, alias.name)))

    def _source_of(self, node: ast.Import | ast.ImportFrom) -> list[str] | None:
        """The source of an import, as the parts of a path in the engine's folder; None: from outside."""
        if isinstance(node, ast.Import):
            return None
        parts = node.module.split(".")
        return parts[len(_PACKAGE) :] if parts[: len(_PACKAGE)] == _PACKAGE else None

    def _write_statements(self, statements: list[ast.stmt]) -> None:
        self._body.append("[")
        for node in statements:
            if isinstance(node, ast.Import | ast.ImportFrom):
                self._add_imports(node)
            elif isinstance(node, ast.Raise) and isinstance(node.exc, ast.Call):
                self._write(node.exc.func)  # the text of an error changes no number
            elif not _does_nothing(node):
                self._write(node)
        self._body.append("]")

    def _write(self, node: ast.AST) -> None:
        """Add a node with all below it; fields that are empty are left out, since each Python has other ones."""
        add = self._body.append
        if type(node) is ast.Name:
            add(_NAME + node.id)
            return
        add(type(node).__name__)
        for name in node._fields:
            value = getattr(node, name, None)
            if value is None or value == [] or name in _IGNORED_FIELDS:
                continue
            if name == "annotation" and type(node) is ast.arg:  # those of a NamedTuple's fields decide how it is packed
                continue
            add(name)
            if isinstance(value, ast.AST):
                self._write(value)
            elif name in _BLOCKS and isinstance(value, list):
                self._write_statements(value)
            elif isinstance(value, list):
                for item in value:
                    self._write(item) if isinstance(item, ast.AST) else add(repr(item))
            else:
                add(repr(value))
        add(")")


def _does_nothing(node: ast.stmt) -> bool:
    """Whether a statement is a docstring, ``pass``, or for type checkers alone."""
    if isinstance(node, ast.Expr):
        return isinstance(node.value, ast.Constant) and isinstance(node.value.value, str)
    if isinstance(node, ast.If):
        return isinstance(node.test, ast.Name) and node.test.id == "TYPE_CHECKING"
    return isinstance(node, ast.Pass)


def _file_of(engine: Path, parts: list[str]) -> Path | None:
    """The module of this name, relative to the engine's folder; None if there is none."""
    paths = [Path(*parts, "__init__.py"), *([Path(*parts).with_suffix(".py")] if parts else [])]
    return next((path for path in paths if (engine / path).is_file()), None)
