"""What a search for branches has finished, in a folder: the same search takes it up where it was stopped or killed.

A search makes the same traces in the same order each time. So trace k is read instead of followed if it begins at the
same orbit. A trace is a file that is written whole or not at all; its numbers are written so that they are read to the
last bit, and what follows from them is computed again.
"""

import json
import os
from collections.abc import Iterable, Mapping
from pathlib import Path

import numpy as np
from vibroscope.engine.continuation.branch import point_on_branch
from vibroscope.engine.continuation.curve import Curve, CurvePoint
from vibroscope.engine.continuation.orbit import Orbit
from vibroscope.engine.continuation.tracer import Trace
from vibroscope.engine.drivers.code_cache import source_digest

QUESTION = "question.json"
ENGINE = Path(__file__).parents[1]


class Journal:
    """The finished traces of one search.

    Parameters
    ----------
    folder : Path
        Made if it is missing.
    question : mapping
        All that the search depends on, as JSON takes it.

    Raises
    ------
    ValueError
        If the folder holds the traces of another search, or of another version of the engine.
    """

    def __init__(self, folder: Path, question: Mapping[str, object]) -> None:
        self._folder = folder
        wanted = json.dumps({**question, "engine": source_digest(ENGINE)}, sort_keys=True).encode()
        folder.mkdir(parents=True, exist_ok=True)
        file = folder / QUESTION
        if not file.exists():
            _write(file, wanted)
        elif file.read_bytes() != wanted:
            raise ValueError(f"{folder} holds another search, or one of another engine: give a new place")

    def read(self, k: int, start: CurvePoint, curve: Curve) -> Trace | None:
        """Trace k; None if it is not there, or begins elsewhere."""
        try:
            kept = json.loads(self._file(k).read_bytes())
        except (OSError, ValueError):
            return None
        if kept["start"] != _plain(start):
            return None
        points = [_read_point(each, curve) for each in kept["points"]]
        marked = ((kind, index, stop, _read_point(each, curve)) for kind, index, stop, each in kept["marks"])
        marks = [(point_on_branch(curve, kind, point, index, stop), point) for kind, index, stop, point in marked]
        return Trace(points, marks, kept["reason"], joined=kept["joined"])

    def write(self, k: int, trace: Trace) -> None:
        """Keep trace k, which is finished."""
        kept = {
            "start": _plain(trace.points[0]),
            "points": [_plain(point) for point in trace.points],
            "marks": [(point.kind, point.index, point.stop, _plain(where)) for point, where in trace.marks],
            "reason": trace.reason,
            "joined": trace.joined,
        }
        _write(self._file(k), json.dumps(kept).encode())

    def _file(self, k: int) -> Path:
        return self._folder / f"trace-{k}.json"


def _write(file: Path, content: bytes) -> None:
    unfinished = file.with_suffix(".partial")
    unfinished.write_bytes(content)
    os.replace(unfinished, file)


def _plain(point: CurvePoint) -> list:
    orbit = point.orbit
    numbers: Iterable[np.ndarray] = (point.unknowns, point.tangent)
    return [orbit.period, [int(kind) for kind in orbit.kinds], int(orbit.first), *(each.tolist() for each in numbers)]


def _read_point(kept: list, curve: Curve) -> CurvePoint:
    period, kinds, first, unknowns, tangent = kept
    orbit = Orbit(period, tuple(kinds), first, np.array(unknowns[:-1]))
    return CurvePoint(curve, orbit, unknowns[-1], np.array(tangent))
