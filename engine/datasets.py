"""Results as labelled arrays (xarray), with meaning and unit of each variable as its attributes."""

from typing import TYPE_CHECKING

from vibroscope.engine.model import COORDINATES

if TYPE_CHECKING:
    import xarray as xr
    from vibroscope.engine.divergence.compare import Comparison
    from vibroscope.engine.result import Response

BODIES = (1, 2)
LENGTH, SPEED, TIME = "unit of length", "unit of length times omega1", "1/omega1"


def response_dataset(response: "Response") -> "xr.Dataset":
    """The arrays of a run.

    Returns
    -------
    xarray.Dataset
        ``section`` (period, coordinate), the impacts (impact; body), ``contact`` (contact, edge), and where samples
        were asked for ``displacement``, ``velocity`` (body, time) and ``force`` (time). Attributes: what was asked,
        and how the run ended.
    """
    import xarray as xr

    impacts, first = response.impacts, response.checkpoint.periods + 1
    found = xr.Dataset(
        {
            "section": labelled(("period", "coordinate"), response.section, "Poincaré section", f"{LENGTH}, {SPEED}"),
            "impact_time": labelled("impact", impacts.time, "instant of the impact", TIME),
            "impact_position": labelled("impact", impacts.position, "displacement of body 1", LENGTH),
            "velocity_before": labelled(("impact", "body"), impacts.velocity_before, "velocities before", SPEED),
            "velocity_after": labelled(("impact", "body"), impacts.velocity_after, "velocities after", SPEED),
            "impulse": labelled("impact", impacts.impulse, "impulse between the bodies", f"m1 times {SPEED}"),
            "closing_speed": labelled("impact", impacts.closing_speed, "closing speed", SPEED),
            "contact": labelled(("contact", "edge"), response.contacts, "beginning and end of each contact", TIME),
        },
        {
            "period": range(first, first + len(response.section)),
            "coordinate": list(COORDINATES),
            "body": list(BODIES),
            "edge": ["begin", "end"],
        },
        {
            "system": str(response.system),
            "method": str(response.method),
            "eta": response.eta,
            "status": str(response.status),
            "message": response.message,
        },
    )
    path = response.trajectory
    if path is None:
        return found
    return found.assign_coords(time=path.time).assign(
        displacement=labelled(("body", "time"), path.displacement, "displacements relative to the base", LENGTH),
        velocity=labelled(("body", "time"), path.velocity, "velocities relative to the base", SPEED),
        force=labelled("time", path.force, "contact force", "k1 times unit of length"),
    )


def comparison_dataset(comparison: "Comparison") -> "xr.Dataset":
    """The four solutions of a comparison, their difference and its parts.

    Returns
    -------
    xarray.Dataset
        ``solution`` (run, coordinate, time), ``total`` and the parts (coordinate, time). Attributes: the rms of each,
        relative to the reference.

    Raises
    ------
    ValueError
        If a run ended early, so that there are no series.
    """
    import xarray as xr

    series = comparison.parts
    if series is None:
        raise ValueError("a run ended early, so that there are no series: see the runs' messages")
    names = ("total", *comparison.part_names)
    variables = {
        name: labelled(("coordinate", "time"), getattr(series, name), "", f"{LENGTH}, {SPEED}") for name in names
    }
    return xr.Dataset(
        {"solution": labelled(("run", "coordinate", "time"), list(series.runs), "", f"{LENGTH}, {SPEED}")} | variables,
        {"time": series.time, "run": list(series.runs._fields), "coordinate": ["xi1", "xi2", "v1", "v2"]},
        {name: getattr(comparison, name) for name in names},
    )


def labelled(dims, values, meaning: str, unit: str) -> tuple:
    """A variable with its meaning and its unit."""
    return dims, values, {"units": unit} | ({"long_name": meaning} if meaning else {})
