"""The published cases, read from ``assets/validation/cases.toml``; its header explains the keys."""

import tomllib
from dataclasses import dataclass, fields
from functools import cache

from vibroscope.app.runtime.files import asset
from vibroscope.engine import (
    CONTACT_LAWS,
    ExactPenalty,
    Method,
    Newmark,
    Reference,
    System,
    Units,
    system_of_physical,
    system_of_tables,
)

FILE = "validation/cases.toml"


@dataclass(frozen=True)
class PublishedFigure:
    """One published figure.

    Attributes
    ----------
    what : str
        What is compared.
    unit : str
        "N", "s", …; empty for a number without dimension.
    published : float or None
        The figure as published; None where the source has none.
    recomputed : float
        The same as tests/data/recompute_published.py finds it.
    within : float
        Largest allowed |ours − recomputed|, relative to ``recomputed``.
    measure : str
        Name of a function of :mod:`.outcome`.
    arguments : dict
        Its further arguments.
    note : str
        Why the published figure differs from the recomputed one, where it does.
    """

    what: str
    recomputed: float
    within: float
    measure: str
    arguments: dict
    unit: str = ""
    published: float | None = None
    note: str = ""


@dataclass(frozen=True)
class PublishedCase:
    """One published problem and its figures.

    Attributes
    ----------
    key, title, source : str
    formula : bool
        Whether what the source prints is a formula, of which the published figures are the values.
    system : System
    units : Units or None
        None for a problem without dimensions.
    eta : float
    method : Method
    periods : int
    initial : tuple of 4 float
        ξ₁, ξ₁′, ξ₂, ξ₂′ at τ = 0.
    quantities : tuple of PublishedFigure
    """

    key: str
    title: str
    source: str
    formula: bool
    system: System
    units: Units | None
    eta: float
    method: Method
    periods: int
    initial: tuple[float, float, float, float]
    quantities: tuple[PublishedFigure, ...]


@cache
def cases() -> tuple[PublishedCase, ...]:
    """All cases, in the order of the file."""
    return tuple(map(_case, tomllib.loads(asset(FILE))["case"]))


def _case(table: dict) -> PublishedCase:
    run = table["run"]
    if "physical" in table:
        system, units, eta, _ = system_of_physical(table["physical"])
    else:
        content = system_of_tables({name: table[name] for name in ("system", "excitation") if name in table})
        system, units, eta = content.system, None, run["eta"]
    return PublishedCase(
        **{name: table[name] for name in ("key", "title", "source")},
        formula=table.get("formula", False),
        system=system,
        units=units,
        eta=eta,
        method=_method(run, units),
        periods=run["periods"],
        initial=_initial(run, units),
        quantities=tuple(map(_quantity, table["quantity"])),
    )


def _method(run: dict, units: Units | None) -> Method:
    """The method of a run; contact spring and damper as K and D, or in physical units."""
    if run["method"] == Reference.name:
        return Reference("derived", run.get("threshold", 0.0))
    stiffness, damping = run.get("K"), run.get("D", 0.0)
    if units is not None and stiffness is None:
        stiffness = units.model("contact_stiffness", run["contact_stiffness_N_per_m"])
        damping = units.model("contact_damping", run.get("contact_damping_Ns_per_m", 0.0))
    if run["method"] == ExactPenalty.name:
        return ExactPenalty(stiffness, damping, run.get("law", CONTACT_LAWS[0]))
    return Newmark(stiffness, damping, run["steps"])


def _initial(run: dict, units: Units | None) -> tuple[float, float, float, float]:
    """The state at the beginning: ``start``, or ``start_SI`` in m and m/s."""
    if "start_SI" not in run or units is None:
        return tuple(run.get("start", (0.0, 0.0, 0.0, 0.0)))
    return tuple(map(units.model, ("displacement", "velocity") * 2, run["start_SI"]))


def _quantity(table: dict) -> PublishedFigure:
    own = {each.name for each in fields(PublishedFigure)}
    arguments = {name: value for name, value in table.items() if name not in own}
    return PublishedFigure(**{name: table[name] for name in own & table.keys()}, arguments=arguments)
