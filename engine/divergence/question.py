"""What a comparison of a penalty solution with the reference is asked."""

from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass, field

from vibroscope.engine.arguments import check_fields
from vibroscope.engine.divergence.grid import PER_PERIOD
from vibroscope.engine.methods import Reference, TimeStepping
from vibroscope.engine.model import System, check_eta
from vibroscope.engine.motions.steady import REST
from vibroscope.engine.simulate import KEEP, LONG, check_lengths


@dataclass(frozen=True)
class ComparisonQuestion:
    """The difference of a penalty solution from the reference is asked for, both from one start.

    Attributes
    ----------
    system : System
    eta : float
        Excitation frequency η = Ω/ω₁.
    penalty : TimeStepping
        Its ``limit``, the exact penalty solution, is run as well.
    reference : Reference
        By default the paper's. With derived joint damping the part of the joint damping vanishes.
    periods, keep : int
        Excitation periods to run at least, and the last of them to compare. Where the solutions are not settled by
        then, more are run, and SECTION of them are compared if the reference does not repeat itself (:mod:`.window`).
    initial : (4,) sequence, optional
        ξ₁, ξ₁′, ξ₂, ξ₂′ at τ = 0, by default rest.
    per_period : int
        Samples per period at most; they are Newmark's own steps.

    Raises
    ------
    ValueError
        If η is out of range, or the penalty solution has no time step.

    Examples
    --------
    >>> from vibroscope.engine import ComparisonQuestion, Newmark, System
    >>> ComparisonQuestion(System(), 2.76, Newmark(12000, 18, 2000)).keep
    50
    """

    system: System
    eta: float
    penalty: TimeStepping
    _: KW_ONLY
    reference: Reference = field(default_factory=Reference)
    periods: int = LONG
    keep: int = KEEP
    initial: Sequence[float] | None = REST
    per_period: int = PER_PERIOD

    def __post_init__(self) -> None:
        check_fields(self)
        if not self.penalty.has_step:
            raise ValueError(f"{self.penalty} has no time step: compare Newmark, whose limit it is")
        object.__setattr__(self, "eta", check_eta(self.eta))
        periods, keep = check_lengths(self.periods, self.keep)
        object.__setattr__(self, "periods", periods)
        object.__setattr__(self, "keep", keep)
        object.__setattr__(self, "initial", None if self.initial is None else tuple(self.initial))

    @property
    def start(self) -> tuple[float, ...]:
        """ξ₁, ξ₁′, ξ₂, ξ₂′ at τ = 0."""
        return self.system.rest if self.initial is None else tuple(map(float, self.initial))
