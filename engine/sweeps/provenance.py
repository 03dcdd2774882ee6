"""The origin of a result, which its attributes hold.

Two kinds, kept apart. `origin` follows from what was asked and from the engine, and is the same in every run.
`account` is of the run that finished the result (date, cost) and is written last, so that all else is the same, byte
for byte, however often a run was killed and on how many machines it was taken up again.
"""

import datetime
import importlib.metadata
import json
import platform

from vibroscope.engine.sweeps.progress import Progress
from vibroscope.engine.sweeps.study import Study

SOURCE = "Penalty-regularization of a dissipative vibro-impacting system (the model and its Table 1)"


def engine_version() -> str:
    """Version of the package; ``unknown`` if it is not installed."""
    try:
        return importlib.metadata.version("vibroscope")
    except importlib.metadata.PackageNotFoundError:
        return "unknown"


def origin(study: Study) -> dict[str, object]:
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


def account(progress: Progress, where: str) -> dict[str, object]:
    """Attributes of the run that finished a result."""
    return {
        "date": datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds"),
        **cost(progress),
        "computed_on": f"{where}, {platform.machine()}, Python {platform.python_version()}, "
        f"NumPy {importlib.metadata.version('numpy')}, Numba {importlib.metadata.version('numba')}",
        "complete": 1,
    }


def cost(progress: Progress) -> dict[str, object]:
    """Seconds and cells of a run."""
    return {
        "seconds": progress.seconds,
        "computed": progress.computed,
        "reused": progress.reused,
        "failed": progress.failed,
    }
