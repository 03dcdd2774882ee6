"""Other people's numbers: published cases of ``assets/validation/cases.toml``, solved here and compared.

The header of the file explains its keys. Measures of a run are peaks, instants, impulses, multipliers: each takes a
`SolvedCase` and returns a number. Numbers are those of the model; `validate` converts them. Contacts and impacts are
counted from 1.
"""

import math
import time
import tomllib
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, fields, replace
from functools import cache, cached_property

import numpy as np
from vibroscope.app.runtime.files import asset
from vibroscope.engine import (
    CONTACT_LAWS,
    ExactPenalty,
    Method,
    Newmark,
    Record,
    Reference,
    Response,
    System,
    Trajectory,
    Units,
    simulate,
    steady,
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
        Key of `MEASURES`.
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


SAMPLES = 400_000  # of a run in closed form: so dense that interpolation between them errs by rounding
BISECTIONS = 60


class SolvedCase:
    """One case, solved when a measure asks for it."""

    def __init__(self, case: PublishedCase):
        self.case = case

    @cached_property
    def response(self) -> Response:
        """The run with all periods kept, not sampled."""
        return self._solve(self.case.periods)

    @cached_property
    def samples(self) -> Trajectory:
        """Samples of the whole run: of every step of Newmark's method, else SAMPLES of them."""
        steps = self.case.method.steps or SAMPLES // self.case.periods
        return self._solve(self.case.periods, record=Record(self.case.periods, steps)).trajectory

    def _solve(self, keep: int, **options) -> Response:
        case = self.case
        found = simulate(
            case.system, case.eta, case.method, periods=case.periods, keep=keep, initial=case.initial, **options
        )
        if not found.ok:
            raise ValueError(f"{case.key}: {found.ending}")
        return found


def rebound(run: SolvedCase, number: int) -> float:
    """Speed at which the bodies part after an impact, over the closing speed."""
    impacts = run.response.impacts
    after = impacts.velocity_after[number - 1]
    return (after[1] - after[0]) / impacts.closing_speed[number - 1]


def displacement(run: SolvedCase, time: float) -> float:
    """ξ₁ at an instant, by the cubic through the two samples around it and their velocities."""
    samples = run.samples
    i = min(np.searchsorted(samples.time, time, "right"), len(samples.time) - 1) - 1
    h = samples.time[i + 1] - samples.time[i]
    s = (time - samples.time[i]) / h
    (x, y), (v, w) = samples.displacement[0, i : i + 2], h * samples.velocity[0, i : i + 2]
    return x + s * (v + s * (3 * (y - x) - 2 * v - w + s * (2 * (x - y) + v + w)))


def peak(run: SolvedCase, number: int = 0) -> tuple[float, float]:
    """Instant and size of the greatest contact force, of one contact or of all (number 0), by a parabola."""
    samples, force = run.samples, run.samples.force
    if number:
        begin, end = run.response.contacts[number - 1]
        force = np.where((samples.time > begin) & (samples.time < end), force, 0.0)
    i = int(np.argmax(force))
    left, top, right = force[i - 1 : i + 2]
    bend = left - 2 * top + right
    shift = (left - right) / (2 * bend)
    h = samples.time[i + 1] - samples.time[i]
    return samples.time[i] + shift * h, top - (left - right) * shift / 4


def time_of_force(run: SolvedCase, force: float) -> float:
    """Instant at which the contact force first reaches a value, between two samples."""
    samples = run.samples
    i = int(np.argmax(samples.force >= force))
    (low, high), (begin, end) = samples.force[i - 1 : i + 1], samples.time[i - 1 : i + 1]
    return begin + (force - low) / (high - low) * (end - begin)


def multiplier_product(run: SolvedCase) -> float:
    """Product of the two largest Floquet multipliers of the periodic motion that the run leads to."""
    case = run.case
    found = steady(case.system, case.eta, case.method, initial=case.initial)
    if not found.periodic:
        raise ValueError(f"{case.key}: {found.message}")
    return np.prod(found.multipliers[:2]).real


def grazing_force(run: SolvedCase) -> float:
    """Amplitude of the force on body 1 at which its steady motion without contact grazes the wall, by bisection.

    Each trial begins in that motion, and its impacts in one period decide.
    """
    case, low, high = run.case, 0.0, run.case.system.excitation.force1
    if not _impacts(case, high):
        raise ValueError(f"{case.key}: no impact with force1 = {high:g}; give the case a larger one")
    for _ in range(BISECTIONS):
        middle = (low + high) / 2
        low, high = (low, middle) if _impacts(case, middle) else (middle, high)
    return high


def _impacts(case: PublishedCase, force: float) -> int:
    """Impacts of one period that begins in the steady motion which body 1 would have without contact."""
    system, eta = case.system, case.eta
    cosine, sine = replace(system.excitation, force1=force).harmonic("force1", eta)
    response = (cosine - 1j * sine) / (1 - eta**2 + 2j * system.d1 * eta)  # ξ₁ = Re(response e^(iητ))
    start = (response.real, -eta * response.imag, 0.0, 0.0)
    if start[0] > system.clearance:  # the motion goes beyond the wall, and begins there
        return 1
    driven = replace(system, excitation=replace(system.excitation, force1=force))
    return len(simulate(driven, eta, case.method, periods=1, keep=1, initial=start).impacts)


MEASURES = {
    # of an impact, 0 is the last one; for penalty contact, when the contact begins
    "impact_time": lambda run, number: run.response.impacts.time[number - 1],
    "impact_speed": lambda run, number: run.response.impacts.closing_speed[number - 1],
    "impulse": lambda run, number: run.response.impacts.impulse[number - 1],
    "rebound": rebound,
    "impacts": lambda run: len(run.response.impacts),  # of the whole run
    # of a contact; for the reference, of a permanent one
    "contact_begin": lambda run, number: run.response.contacts[number - 1][0],
    "contact_end": lambda run, number: run.response.contacts[number - 1][1],
    "contact_duration": lambda run, number: np.diff(run.response.contacts[number - 1])[0],
    # the angular frequency of a motion that hits once in each of its cycles
    "frequency": lambda run: 2 * math.pi / np.diff(run.response.impacts.time[:2])[0],
    "displacement": displacement,
    "peak_time": lambda run, number=0: peak(run, number)[0],
    "peak_force": lambda run, number=0: peak(run, number)[1],
    # among the states after every step, or every second one, …, as a code keeps them
    "greatest_sample": lambda run, every=1: run.samples.force[::every].max(),
    "time_of_force": time_of_force,
    "multiplier_product": multiplier_product,
    "grazing_force": grazing_force,
}


# unit of a figure: the quantity of `Units` that it belongs to
_KINDS = {
    "N": "force",
    "s": "time",
    "m": "displacement",
    "m/s": "velocity",
    "N·s": "impulse",
    "Hz": "frequency",
}
_MEASURED = ("time", "force")  # arguments of measures that have a dimension, which they are named by


@dataclass(frozen=True)
class ComparedFigure:
    """A published figure beside ours.

    Attributes
    ----------
    case : PublishedCase
    quantity : PublishedFigure
    ours : float
        In the unit of the quantity.
    seconds : float
        What it took, the solution included where it was not there yet.
    """

    case: PublishedCase
    quantity: PublishedFigure
    ours: float
    seconds: float

    @property
    def difference(self) -> float | None:
        """(ours − published)/published; None where nothing is published."""
        return None if self.quantity.published is None else self.ours / self.quantity.published - 1

    @property
    def error(self) -> float:
        """|ours − recomputed|, relative to the recomputed figure."""
        return abs(self.ours / self.quantity.recomputed - 1)

    @property
    def agrees(self) -> bool:
        """Whether our figure is the recomputed one, within what the file allows."""
        return self.error <= self.quantity.within


def validate(chosen: Iterable[PublishedCase] | None = None) -> Iterator[ComparedFigure]:
    """Yield the comparison of each figure, case by case; by default of all cases."""
    for case in cases() if chosen is None else chosen:
        run = SolvedCase(case)
        for quantity in case.quantities:
            begin = time.perf_counter()
            ours = _measured(run, quantity)
            yield ComparedFigure(case, quantity, ours, time.perf_counter() - begin)


def _measured(run: SolvedCase, quantity: PublishedFigure) -> float:
    """Our figure in the unit of the quantity."""
    units, arguments = run.case.units, dict(quantity.arguments)
    if units is not None:
        arguments |= {name: units.model(name, arguments[name]) for name in _MEASURED if name in arguments}
    ours = float(MEASURES[quantity.measure](run, **arguments))
    return ours if units is None or not quantity.unit else units.physical(_KINDS[quantity.unit], ours)


def as_dict(comparison: ComparedFigure) -> dict:
    """The JSON of one figure."""
    case, quantity = comparison.case, comparison.quantity
    return {
        "case": case.key,
        "title": case.title,
        "source": case.source,
        "what": quantity.what,
        "unit": quantity.unit,
        "published": quantity.published,
        "formula": case.formula,
        "recomputed": quantity.recomputed,
        "ours": comparison.ours,
        "difference": comparison.difference,
        "error": comparison.error,
        "allowed": quantity.within,
        "agrees": comparison.agrees,
        "seconds": comparison.seconds,
        "note": quantity.note,
    }
