"""Where a result comes from: what goes into its attributes.

Two kinds, kept apart. `origin` follows from what was asked and from the engine, and is the same in every run.
`account` is of the run that finished the result (date, cost) and is written last, so that all else is the same, byte
for byte, however often a run was killed and on how many machines it was taken up again.
"""

import datetime
import functools
import importlib.metadata
import json
import platform
from pathlib import Path

from ..drivers.code_cache import source_digest

SOURCE = "Penalty-regularization of a dissipative vibro-impacting system (the model and its Table 1)"


@functools.cache
def engine_digest() -> str:
    """Digest of the engine's sources, as they were when this process first asked."""
    return source_digest(Path(__file__).parents[1])


def engine_version() -> str:
    """Version of the package; ``unknown`` if it is not installed."""
    try:
        return importlib.metadata.version("vibroscope")
    except importlib.metadata.PackageNotFoundError:
        return "unknown"


def origin(study) -> dict[str, object]:
    """Attributes that are known before a study is run; groups of numbers as JSON, which every file format can hold."""
    numbers = study.numbers()
    return {
        "title": f"vibroscope sweep {study.kind}",
        "source": SOURCE,
        "system": json.dumps(numbers["system"]),
        "method": json.dumps(numbers["method"]),
        "options": json.dumps(numbers["options"]),
        **{name: numbers[name] for name in ("eta", "transient", "sample") if name in numbers},
        "engine_version": engine_version(),
        "engine_digest": numbers["engine"],
        "key": study.key,
        "complete": 0,
    }


def account(seconds: float, computed: int, reused: int, failed: int, where: str) -> dict[str, object]:
    """Attributes of the run that finished a result."""
    return {
        "date": datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds"),
        "seconds": seconds,
        "computed": computed,
        "reused": reused,
        "failed": failed,
        "computed_on": f"{where}, {platform.machine()}, Python {platform.python_version()}, "
        f"NumPy {importlib.metadata.version('numpy')}, Numba {importlib.metadata.version('numba')}",
        "complete": 1,
    }
