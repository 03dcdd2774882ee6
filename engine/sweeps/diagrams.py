"""The bifurcation diagrams that the explorer opens with: shipped for the default system, else computed once and kept.

A shipped one is a single npz file, which is read in milliseconds when the page opens; what reads a labelled result
takes half a second to import.
"""

import os
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path

import numpy as np
from vibroscope import assets
from vibroscope.engine.methods import JOINT_DAMPINGS, Reference
from vibroscope.engine.model import System
from vibroscope.engine.sweeps.cache import cached_dataset
from vibroscope.engine.sweeps.eta_study import EtaStudy
from vibroscope.engine.sweeps.growth import RunOptions, run
from vibroscope.engine.sweeps.progress import ProgressCallback

SHIPPED = Path(str(files(assets))) / "diagrams"
GRID = np.round(np.arange(0.5, 4.0 + 1e-9, 0.0025), 4)  # 1,401 values of η; the paper's four are among them


@dataclass(frozen=True)
class Diagram:
    """Bifurcation diagram from rest.

    Attributes
    ----------
    eta : (n,) ndarray
    displacement : (2, n, sample) ndarray of float32
        ξ₁ and ξ₂ at τ ≡ 0 mod T; nan in rows whose run ended early.
    """

    eta: np.ndarray
    displacement: np.ndarray


def diagram_study(system: System, method: Reference) -> EtaStudy:
    """The study that the diagram is made of; its key changes with any number and any code that goes in."""
    return EtaStudy(system, method, float(GRID[0]), transient=2000, sample=50, values=GRID)


def diagram(
    system: System,
    method: Reference,
    *,
    progress: ProgressCallback | None = None,
    cancelled: Callable[[], bool] | None = None,
) -> Diagram:
    """The bifurcation diagram over GRID: shipped, or cached, or computed now and cached.

    Parameters
    ----------
    progress : callable, optional
        Called with a `Progress`; only where the diagram is not shipped.

    Raises
    ------
    Cancelled
        If ``cancelled`` returned true; what is complete is kept for the next time.
    """
    study = diagram_study(system, method)
    return shipped_diagram(system, method) or _diagram_of(cached_dataset(study, progress=progress, cancelled=cancelled))


def shipped_diagram(system: System, method: Reference) -> Diagram | None:
    """The shipped diagram; None if none is shipped for this system, or if it is of another engine."""
    return load_diagram(shipped_path(method), diagram_study(system, method).key)


def _diagram_of(found) -> Diagram:
    points = np.stack([found[name].values for name in ("xi1", "xi2")])
    return Diagram(found["eta"].values, points.astype(np.float32))


def shipped_path(method: Reference) -> Path:
    """The file with the diagram of the default system in the source tree."""
    return SHIPPED / f"{method.joint_damping}.npz"


def ship_diagrams() -> list[Path]:
    """Compute the diagrams of the default system and put them into the source tree; returns their paths."""
    paths = []
    for kind in JOINT_DAMPINGS:
        study, path = diagram_study(System(), Reference(kind)), shipped_path(Reference(kind))
        save_diagram(path, study.key, _diagram_of(run(study, RunOptions())))
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
    except Exception:  # a damaged file has zipfile, zlib and numpy raise what they please
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
