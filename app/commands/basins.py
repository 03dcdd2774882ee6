"""The summaries that ``vibroscope sweep basin`` and ``vibroscope sweep basin-difference`` print."""

import argparse
import math

from vibroscope.app.commands.report import Report
from vibroscope.engine import basin_difference
from vibroscope.engine.sweeps import KIND_FLAGS, check_store


def summary(found) -> tuple[dict, list[str]]:
    """The motions and the boundary, as numbers and as lines of text."""
    motions = _motions_of(found)
    names = ("boundary_dimension", "boundary_dimension_error")
    numbers = {name: float(found[name]) for name in names}
    lines = [_motion_text(motion) for motion in motions]
    if math.isfinite(numbers["boundary_dimension"]):
        lines.append("dimension of the boundary: {:.3f} ± {:.3f}".format(*numbers.values()))
    return {"motions": motions} | numbers, lines


def _motions_of(found) -> list[dict]:
    kinds = {number: name for name, number in KIND_FLAGS.items()}
    columns = {
        "kind": [kinds[int(kind)] for kind in found["motion_kind"]],
        "period": [int(period) for period in found["motion_period"]],
        "share": [float(share) for share in found["motion_share"]],
        "share_error": [float(error) for error in found["motion_share_error"]],
        "start": list(found["motion_start"].values),
    }
    return [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]


def _motion_text(motion: dict) -> str:
    name = f"period {motion['period']}" if motion["period"] else motion["kind"]
    return f"{name}: {100 * motion['share']:.2f} ± {100 * motion['share_error']:.2f} % of the starts"


def difference(options: argparse.Namespace) -> Report:
    """The share in which two basins differ, and which motions of both are the same."""
    import xarray

    for path in (options.first, options.second):
        check_store(path)  # raises a ValueError in words where there is no result
    first, second = (xarray.open_zarr(path) for path in (options.first, options.second))
    found = basin_difference(first, second)
    lines = [f"{100 * found.share:.2f} ± {100 * found.error:.2f} % of the starts lead to different motions"]
    for path, each, alike in ((options.first, first, found.same.any(1)), (options.second, second, found.same.any(0))):
        for motion, in_both in zip(_motions_of(each), alike, strict=True):
            lines.append(f"{path}: {_motion_text(motion)}, {'in both' if in_both else 'not in the other'}")
    return Report(lines, {"share": found.share, "error": found.error, "same": found.same})
