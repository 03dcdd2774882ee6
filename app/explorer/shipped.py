"""The result that the page opens with while the solvers are still being compiled: computed beforehand, and shipped.

``vibroscope diagram --write`` writes it, and `tests/app/test_shipped.py` compares it with what is computed now.

The bifurcation diagrams of the default system, loaded once per process. No panel import.
"""

import io
import json
import threading
from collections.abc import Callable, Mapping
from concurrent.futures import Future
from dataclasses import asdict, dataclass, replace
from functools import cache
from pathlib import Path

import numpy as np
from vibroscope.app.explorer.compute import compute_runs
from vibroscope.app.explorer.explanation import Description, Explanation, describe, explain
from vibroscope.app.explorer.present import Columns, present
from vibroscope.app.explorer.presets import opening_setting
from vibroscope.app.explorer.state import Setting
from vibroscope.app.runtime.compilation import compilation
from vibroscope.app.runtime.files import ASSETS
from vibroscope.app.runtime.workers import workers
from vibroscope.engine import Diagram, Reference, System, diagram, shipped_diagram
from vibroscope.engine.facts import as_json, read_statement
from vibroscope.engine.sweeps import engine_digest

FUTURES: dict[str, Future[Diagram]] = {}
_lock = threading.Lock()


def is_shipped(setting: Setting) -> bool:
    """Whether the diagram of the setting is one of those that are shipped."""
    return setting.system == System() and setting.reference == Reference(setting.joint_damping)


def diagram_for_now(setting: Setting, then: Callable[[], None]) -> Diagram | None:
    """The shipped diagram of a setting while the solvers are being compiled; ``then`` is called once it is read.

    None if there is none, or while it is read.
    """
    if compilation.progress is None or not is_shipped(setting):
        return None
    future = load_diagram(setting.joint_damping)
    if not future.done():
        future.add_done_callback(lambda _: then())
        return None
    return future.result() if future.exception() is None else None


def load_diagram(joint_damping: str) -> Future[Diagram]:
    """The diagram from the package or the cache; a worker computes it (some ten seconds) where neither has it."""
    with _lock:
        if joint_damping not in FUTURES:
            FUTURES[joint_damping] = future = Future()
            workers().submit(_load, Reference(joint_damping), future)
        return FUTURES[joint_damping]


def _load(method: Reference, future: Future[Diagram]) -> None:
    shipped = shipped_diagram(System(), method)
    if shipped is not None:
        future.set_result(shipped)
    else:
        compilation.when_done(lambda: workers().submit(_compute, method, future))


def _compute(method: Reference, future: Future[Diagram]) -> None:
    try:
        future.set_result(diagram(System(), method))
    except Exception as error:
        future.set_exception(error)


PATH = Path(str(ASSETS)) / "opening.npz"


@dataclass(frozen=True, eq=False)
class Shipped:
    """The content of the figures and findings of one setting."""

    columns: dict[str, Columns]
    description: Description
    explanation: Explanation


def shipped_result(setting: Setting) -> Shipped | None:
    """The shipped result if ``setting`` has one and cannot be computed yet, since the solvers are being compiled."""
    return _shipped_opening() if compilation.progress is not None and setting == opening_setting() else None


@cache
def _shipped_opening() -> Shipped | None:
    return load(PATH, opening_setting())


def compute(setting: Setting) -> Shipped:
    """Compute what is to be shipped for ``setting``; the costs, which are those of this machine, are left out."""
    runs = compute_runs(setting)
    return Shipped(present(runs), replace(describe(runs), cost=()), explain(runs))


def ship_opening() -> Path:
    """Compute the result of the opening scene and put it into the source tree; returns its path."""
    save(PATH, opening_setting(), compute(opening_setting()))
    return PATH


def save(path: Path, setting: Setting, result: Shipped) -> None:
    """Write a result: its arrays as they are, everything else as JSON."""
    texts = {"key": _key(setting), "description": asdict(result.description), "explanation": asdict(result.explanation)}
    arrays = {f"series/{name}": series for name, series in texts["explanation"].pop("series").items()}
    for source, columns in result.columns.items():
        arrays |= {f"column/{source}/{name}": column for name, column in columns.items()}
    written = io.BytesIO()
    np.savez_compressed(written, texts=np.array(json.dumps(as_json(texts))), **arrays)
    path.write_bytes(written.getvalue())


def load(path: Path, setting: Setting) -> Shipped | None:
    """The result in a file; None if the file is missing, damaged, or holds that of another setting or engine."""
    try:
        # opened here, since numpy leaves a damaged file open
        with path.open("rb") as file, np.load(file, allow_pickle=False) as content:
            texts = json.loads(str(content["texts"]), object_hook=read_statement)
            if texts["key"] != _key(setting):
                return None
            return Shipped(
                _columns(content),
                Description(**_frozen(texts["description"])),
                Explanation(**_frozen(texts["explanation"]), series=_below(content, "series/")),
            )
    except Exception:  # a damaged file has zipfile, zlib and numpy raise what they please
        return None


def _key(setting: Setting) -> str:
    return f"{engine_digest()} {json.dumps(setting.texts())}"


def _columns(content: Mapping[str, np.ndarray]) -> dict[str, Columns]:
    columns: dict[str, Columns] = {}
    for name, column in _below(content, "column/").items():
        source, _, own = name.partition("/")
        columns.setdefault(source, {})[own] = column
    return columns


def _below(content: Mapping[str, np.ndarray], prefix: str) -> dict[str, np.ndarray]:
    return {name.removeprefix(prefix): content[name] for name in content if name.startswith(prefix)}


def _frozen(fields: dict[str, object]) -> dict[str, object]:
    """The fields of a dataclass from JSON, which has lists for its tuples."""
    return {name: _tuples(value) for name, value in fields.items()}


def _tuples(value: object) -> object:
    return tuple(_tuples(item) for item in value) if isinstance(value, list) else value
