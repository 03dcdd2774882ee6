"""Results kept on disk, under a key that holds every number and the engine's own sources."""

import contextlib
import hashlib
import json
import os
import tempfile
import zipfile
from dataclasses import asdict
from pathlib import Path

import numpy as np

from .kernels.jit import cache_root, source_digest
from .methods import JOINT_DAMPINGS, Reference
from .model import System
from .sweep import Diagram, bifurcation

SHIPPED = Path(__file__).parents[1] / "assets" / "diagrams"
GRID = np.round(np.arange(0.5, 4.0 + 1e-9, 0.0025), 4)  # 1,401 values of η; the paper's four are among them


def diagram_key(system: System, method: Reference, eta: np.ndarray = GRID, periods: int = 2050, keep: int = 50) -> str:
    """Name of a diagram: changes with any number that goes in and with any line of the engine."""
    numbers = {
        "engine": source_digest(Path(__file__).parent),
        "system": system.as_dict(),
        "method": [method.name, asdict(method)],
        "eta": hashlib.sha256(np.ascontiguousarray(eta).tobytes()).hexdigest(),
        "periods": periods,
        "keep": keep,
    }
    return hashlib.sha256(json.dumps(numbers, sort_keys=True).encode()).hexdigest()[:20]


def diagram(system: System, method: Reference, *, progress=None) -> Diagram:
    """The bifurcation diagram over GRID: shipped, or cached, or computed now and cached.

    Parameters
    ----------
    progress : callable, optional
        Called with the number of η done; only where the diagram must be computed.
    """
    key = diagram_key(system, method)
    cached = cache_root() / "diagrams" / f"{key}.npz"
    for path in (shipped_path(method), cached):
        found = load_diagram(path, key)
        if found is not None:
            return found
    computed = bifurcation(system, GRID, method, progress=progress)
    with contextlib.suppress(OSError):  # a full or read-only cache costs time at the next start, not this result
        save_diagram(cached, key, computed)
    return computed


def shipped_path(method: Reference) -> Path:
    """Where the diagram of the default system lies in the source tree."""
    return SHIPPED / f"{method.joint_damping}.npz"


def ship_diagrams() -> list[Path]:
    """Compute the diagrams of the default system and put them into the source tree; returns their paths."""
    paths = []
    for kind in JOINT_DAMPINGS:
        method = Reference(kind)
        path = shipped_path(method)
        save_diagram(path, diagram_key(System(), method), bifurcation(System(), GRID, method))
        paths.append(path)
    return paths


def load_diagram(path: Path, key: str) -> Diagram | None:
    """The diagram in a file; None if the file is missing, damaged, or holds another one."""
    try:
        # opened here, since numpy leaves a damaged file open
        with path.open("rb") as file, np.load(file, allow_pickle=False) as content:
            if str(content["key"]) != key:
                return None
            return Diagram(content["eta"], content["displacement"])
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile):
        return None


def save_diagram(path: Path, key: str, result: Diagram) -> None:
    """Write a diagram whole or not at all.

    Raises
    ------
    OSError
        If the folder cannot be written.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    handle, unfinished = tempfile.mkstemp(dir=path.parent, suffix=".part")
    try:
        with os.fdopen(handle, "wb") as file:
            np.savez_compressed(file, key=np.array(key), eta=result.eta, displacement=result.displacement)
        Path(unfinished).chmod(0o644)  # as any other file; a temporary one is its owner's alone
        os.replace(unfinished, path)
    except BaseException:
        Path(unfinished).unlink(missing_ok=True)
        raise
