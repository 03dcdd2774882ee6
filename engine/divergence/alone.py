"""What is left of the difference if one number or choice alone is changed: curves, and what each leaves at best."""

import math
from dataclasses import dataclass, field

import numpy as np
from vibroscope.engine.divergence.parts import Difference
from vibroscope.engine.methods import METHOD_NUMBERS, ExactPenalty, TimeStepping
from vibroscope.engine.wording import finite_or_none, percent


@dataclass(frozen=True)
class Change:
    """A changed number or choice, or several, and what it leaves.

    Attributes
    ----------
    changed : str
        "K", "D", "steps", "status", "integrator", "law", "joint damping"; "K and D", "K, D and the step" for several.
    left : float
        What the run with exactly this change leaves of the difference, relative to the reference.
    robust : float
        The median of what it and its neighbours on the grid leave, by which the change counts; ``left`` for a choice.
    method : TimeStepping, ExactPenalty or None
        What was run: the exact penalty solution stands for no time step, None for no joint damping of its own.
    difference : Difference or None
        ``left`` as a comparison with this change has it; None where a search alone has run it.
    """

    changed: str
    left: float
    robust: float
    method: TimeStepping | ExactPenalty | None = None
    difference: Difference | None = None

    @property
    def amount(self) -> str:
        """What it leaves, in words."""
        return self.difference.amount if self.difference else percent(self.left)

    @property
    def value(self) -> float:
        """The changed number; inf steps for no time step, nan for a choice or several numbers."""
        if self.changed == "steps" and not self.method.has_step:
            return math.inf
        return float(self.method.numbers[self.changed]) if self.changed in METHOD_NUMBERS else math.nan


@dataclass(frozen=True)
class Curve:
    """What is left of the difference over one number alone.

    Attributes
    ----------
    name : {"K", "D", "steps"}
    present : float
        The present value.
    values, left : (n,) ndarray
        Ascending values, and what each leaves; inf where the run ends early.
    best : Change or None
        What it leaves at best; None as long as it is not known, and if no value leaves less than the present one.
    equal : float
        The value of equal restitution; nan for the steps, and where there is none.
    resolved : float
        Largest K, or least number of steps, with RESOLVED steps in a contact; nan for D, and where it is not known.
    """

    name: str
    present: float
    values: np.ndarray = field(repr=False)
    left: np.ndarray = field(repr=False)
    best: Change | None = None
    equal: float = math.nan
    resolved: float = math.nan


@dataclass(frozen=True)
class Alone:
    """The search over each number alone.

    Attributes
    ----------
    total : float
        The difference as it is.
    floor : float
        What neither K nor D nor the step mends: the part of the joint damping, 0 if there is none.
    curves : dict of str to Curve
        Of "K", of "D" unless the law takes it from the restitution, and of "steps".
    choices : tuple of Change
        Status, integrator and law, each changed alone, and no joint damping of its own for the reference.
    done : bool
        Whether all of them are known.
    """

    total: float
    floor: float
    curves: dict[str, Curve]
    choices: tuple[Change, ...] = ()
    done: bool = False

    @property
    def changes(self) -> list[Change]:
        """The best change of each number, and the choices, the one that leaves least first; none that ends early."""
        best = [curve.best for curve in self.curves.values() if curve.best is not None]
        known = [each for each in (*best, *self.choices) if math.isfinite(each.robust)]
        return sorted(known, key=lambda each: each.robust)

    def as_dict(self) -> dict:
        """Return plain numbers and lists for scripts; None for what is not known or ends early."""
        return {
            "total": self.total,
            "floor": self.floor,
            "curves": {name: _plain_curve(curve) for name, curve in self.curves.items()},
            "choices": [_plain_change(each) for each in self.choices],
        }


def _plain_curve(curve: Curve) -> dict:
    return {
        "present": curve.present,
        "values": curve.values.tolist(),
        "left": [finite_or_none(value) for value in curve.left.tolist()],
        "best": curve.best and _plain_change(curve.best),
        "equal_restitution": finite_or_none(curve.equal),
        "resolved": finite_or_none(curve.resolved),
    }


def _plain_change(change: Change) -> dict:
    method = change.method
    numbers = {} if method is None else {"K": method.stiffness, "D": method.damping}
    if method is not None and method.has_step:
        numbers |= {"steps": method.steps, "status": method.status, "integrator": method.integrator.name}
    left, robust = finite_or_none(change.left), finite_or_none(change.robust)
    law = {} if method is None else {"law": method.law}
    return {"changed": change.changed, "left": left, "median_of_neighbours": robust, **numbers, **law}
