"""One-step methods of FE and physics codes, as the coefficients of their stages.

A stage leads from the displacement, velocity and acceleration (q₀, v₀, a₀) at the beginning of a step Δτ, and those of
the stages before it (j), to (q, v, a) at its end, the share c of the step,

    q = q₀ + Δτ Σ dⱼvⱼ + Δτ² (Σ eⱼaⱼ + βa),        v = v₀ + Δτ (Σ fⱼaⱼ + γa),                        (14)

where a follows from the equations of motion, with M, C and K of the bodies, their loads l and the contact force λ,

    M[(1 − α_m)a + α_m a₀] + C[(1 − α_v)v + α_v v₀] + K[(1 − α_f)q + α_f q₀] = l + rλ,               (15)

with α_v = α_f unless a stage says otherwise. A method adds where λ and the loads are taken: at the interpolated
displacement (1 − α_f)q + α_f q₀ and velocity (1 − α_v)v + α_v v₀ and the instant that belongs to the displacement, or
as the average of both ends, (1 − α_f)λ + α_f λ₀, likewise the loads. Where λ is linear these are the same but for the
loads. A stage may leave out γa from the velocity that the dampers feel.
"""

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import ClassVar, NamedTuple

from vibroscope.engine.arguments import require, set_fields

BETA_RANGE = (0.0, 1.0)
GAMMA_RANGE = (0.0, 2.0)
ALPHA_RANGE = (-1 / 3, 0.0)
RHO_RANGE = (0.0, 1.0)


class Stage(NamedTuple):
    """Coefficients of Eqs. (14) and (15); the tuples have one number for the beginning, and each stage before."""

    end: float  # c
    velocities: tuple[float, ...]  # dⱼ
    accelerations: tuple[float, ...]  # eⱼ
    beta: float
    rates: tuple[float, ...]  # fⱼ
    gamma: float
    alpha_m: float = 0.0
    alpha_f: float = 0.0
    weight: float = 1.0  # share of the impulse over a step that its λ gives
    alpha_v: float | None = None  # None: α_f
    leaves_out: bool = False  # whether the dampers feel v without γa

    @property
    def velocity_share(self) -> float:
        """α_v."""
        return self.alpha_f if self.alpha_v is None else self.alpha_v


@dataclass(frozen=True)
class Integrator(ABC):
    """A one-step method; its numbers are the attributes of a subclass.

    Raises
    ------
    ValueError
        If a number is out of range.
    """

    name: ClassVar[str]  # as options and files have it
    title: ClassVar[str]  # as texts have it: the method, and after a comma its variant
    explicit: ClassVar[bool] = False  # whether the gap at which λ is taken is known before λ
    averaged: ClassVar[bool] = False  # whether forces at both ends are averaged
    always_unstable: ClassVar[bool] = False  # whether undamped motion grows with every step, however small

    @classmethod
    def short_title(cls) -> str:
        """The method without its variant, as "HHT-α"."""
        return cls.title.partition(",")[0]

    @property
    @abstractmethod
    def stages(self) -> tuple[Stage, ...]:
        """One stage, or two that follow each other."""

    def _check(self, name: str, span: tuple[float, float], advice: str) -> None:
        set_fields(self, **{name: require(name, getattr(self, name), *span, advice)})


def _newmark(beta: float, gamma: float, alpha_m: float = 0.0, alpha_f: float = 0.0) -> tuple[Stage]:
    return (Stage(1.0, (1.0,), (0.5 - beta,), beta, (1.0 - gamma,), gamma, alpha_m, alpha_f),)


@dataclass(frozen=True)
class NewmarkBeta(Integrator):
    """Newmark (1959), J. Eng. Mech. Div. ASCE 85(3), 67–94.

    Stable with every step for 2β ≥ γ ≥ ½, of second order for γ = ½. With γ = ½, β = ¼ is average acceleration, and
    β = 1/6 linear acceleration, which is stable for ωΔτ ≤ √12.
    """

    beta: float = 0.25
    gamma: float = 0.5
    name: ClassVar[str] = "newmark"
    title: ClassVar[str] = "Newmark"

    def __post_init__(self):
        self._check("beta", BETA_RANGE, "Newmark's β, ¼ for average acceleration")
        self._check("gamma", GAMMA_RANGE, "Newmark's γ, ½ for second order, more for numerical damping")

    @property
    def always_unstable(self) -> bool:
        """γ < ½ is negative numerical damping."""
        return self.gamma < 0.5

    @property
    def stages(self) -> tuple[Stage, ...]:
        """Eq. (14) as it stands in the textbook."""
        return _newmark(self.beta, self.gamma)


@dataclass(frozen=True)
class HHT(Integrator):
    """HHT-α of Hilber, Hughes & Taylor (1977), Earthq. Eng. Struct. Dyn. 5, 283–292: forces averaged over the step."""

    alpha: float = -0.05
    name: ClassVar[str] = "hht"
    title: ClassVar[str] = "HHT-α, forces averaged"
    averaged: ClassVar[bool] = True

    def __post_init__(self):
        self._check("alpha", ALPHA_RANGE, "α as Hilber writes it, 0 for no numerical damping; 0.9 elsewhere is −0.1")

    @property
    def stages(self) -> tuple[Stage, ...]:
        """β = (1 − α)²/4, γ = ½ − α."""
        return _newmark((1.0 - self.alpha) ** 2 / 4.0, 0.5 - self.alpha, alpha_f=-self.alpha)


@dataclass(frozen=True)
class HHTInterpolated(HHT):
    """HHT-α with forces at the interpolated displacement, as in OpenSees, whose α is 1 + this one."""

    alpha: float = -0.1
    name: ClassVar[str] = "hht-interpolated"
    title: ClassVar[str] = "HHT-α, forces between"
    averaged: ClassVar[bool] = False


@dataclass(frozen=True)
class GeneralisedAlpha(Integrator):
    """Generalised-α of Chung & Hulbert (1993), J. Appl. Mech. 60, 371–375; ρ∞: spectral radius at high frequencies."""

    rho: float = 0.8
    name: ClassVar[str] = "generalised-alpha"
    title: ClassVar[str] = "generalised-α"

    def __post_init__(self):
        self._check("rho", RHO_RANGE, "ρ∞, 1 for no numerical damping, 0 for most")

    @property
    def stages(self) -> tuple[Stage, ...]:
        """α_m and α_f of least damping at low frequencies for this ρ∞."""
        alpha_m, alpha_f = (2.0 * self.rho - 1.0) / (self.rho + 1.0), self.rho / (self.rho + 1.0)
        return _newmark((1.0 - alpha_m + alpha_f) ** 2 / 4.0, 0.5 - alpha_m + alpha_f, alpha_m, alpha_f)


def _composite(share: float, rho: float) -> tuple[Stage, Stage]:
    """The trapezoidal rule to ``share``, then the second stage with spectral radius ``rho`` at high frequencies."""
    first = Stage(share, (share,), (share**2 / 4.0,), share**2 / 4.0, (share / 2.0,), share / 2.0)
    q1 = (rho + 1.0) / (2.0 * share * (rho - 1.0) + 4.0)
    q0, q2 = (share - 1.0) * q1 + 0.5, 0.5 - share * q1
    second = Stage(1.0, (q0 + q2, q1), (q2 * q0, q2 * q1), q2 * q2, (q0, q1), q2, weight=1.0 - q1)
    return first._replace(weight=q1), second


@dataclass(frozen=True)
class TRBDF2(Integrator):
    """Trapezoidal rule and second-order backward differences, half a step each.

    Bathe (2007), Comput. Struct. 85, 437–445. OpenSees counts each half as a step.
    """

    name: ClassVar[str] = "tr-bdf2"
    title: ClassVar[str] = "TR-BDF2"

    @property
    def stages(self) -> tuple[Stage, ...]:
        """The two halves."""
        return _composite(0.5, 0.0)


@dataclass(frozen=True)
class Bathe(Integrator):
    """ρ∞-Bathe method of Noh & Bathe (2019), Comput. Struct. 212, 299–310.

    Its first stage has the share of the step with which both stages have one effective stiffness matrix.
    """

    rho: float = 0.0
    name: ClassVar[str] = "bathe"
    title: ClassVar[str] = "Bathe"

    def __post_init__(self):
        self._check("rho", RHO_RANGE, "ρ∞, 1 for no numerical damping, 0 for most")

    @property
    def stages(self) -> tuple[Stage, ...]:
        """The share (2 − √(2 + 2ρ∞))/(1 − ρ∞), without its cancellation at ρ∞ = 1."""
        return _composite(2.0 / (2.0 + math.sqrt(2.0 + 2.0 * self.rho)), self.rho)


@dataclass(frozen=True)
class CentralDifference(Integrator):
    """Central differences with velocities at half steps, the damper's too; stable for ωΔτ ≤ 2(√(1 + ζ²) − ζ).

    Belytschko, Liu & Moran, Nonlinear Finite Elements (2000), section 6.2; the velocity at a step is that of both
    halves beside it.
    """

    name: ClassVar[str] = "central-difference"
    title: ClassVar[str] = "central differences"
    explicit: ClassVar[bool] = True

    @property
    def stages(self) -> tuple[Stage, ...]:
        """v at the half step is v₀ + Δτ a₀/2, from which q follows."""
        (stage,) = _newmark(0.0, 0.5)
        return (stage._replace(leaves_out=True),)


@dataclass(frozen=True)
class SemiImplicitEuler(Integrator):
    """Semi-implicit (symplectic) Euler: v from the forces at the beginning, q from the new v; of first order.

    Hairer, Lubich & Wanner, Geometric Numerical Integration (2006), section I.1. Its displacements are those of
    central differences with another start.
    """

    name: ClassVar[str] = "semi-implicit-euler"
    title: ClassVar[str] = "semi-implicit Euler"
    explicit: ClassVar[bool] = True

    @property
    def stages(self) -> tuple[Stage, ...]:
        """v = v₀ + Δτ a₀, q = q₀ + Δτ v."""
        return (Stage(1.0, (1.0,), (1.0,), 0.0, (1.0,), 0.0),)


@dataclass(frozen=True)
class EulerImplicitDamper(Integrator):
    """Semi-implicit Euler whose dampers feel the new velocity: springs and loads at the beginning; of first order.

    M(v − v₀)/Δτ = l₀ + rλ(q₀, v) − Cv − Kq₀,  q = q₀ + Δτ v. MuJoCo's integrators "Euler" and "implicitfast" take the
    dampers of joints so (its documentation, Computation, Numerical integration); here that of the contact is taken so,
    too. Stable for ωΔτ ≤ 2(√(1 + ζ²) + ζ), where semi-implicit Euler has the minus sign.
    """

    name: ClassVar[str] = "euler-implicit-damper"
    title: ClassVar[str] = "semi-implicit Euler, implicit dampers"
    explicit: ClassVar[bool] = True

    @property
    def stages(self) -> tuple[Stage, ...]:
        """v = v₀ + Δτ a, q = q₀ + Δτ v with α_f = 1, α_v = 0."""
        return (_euler()._replace(alpha_f=1.0, alpha_v=0.0),)


@dataclass(frozen=True)
class BackwardEuler(Integrator):
    """Backward (implicit) Euler: all forces at the end of the step; stable with every step, of first order.

    Hairer & Wanner, Solving Ordinary Differential Equations II (1996), section IV.3. Contacts of ODE and Bullet with
    ERP = Δt K/(Δt K + c) and CFM = 1/(Δt K + c) are a step of it: they give λ = Kδ + cv at the end ("How To Use ERP and
    CFM" of ODE's manual: as implicit first order integration); their other forces are those at the beginning.
    """

    name: ClassVar[str] = "backward-euler"
    title: ClassVar[str] = "backward Euler"

    @property
    def stages(self) -> tuple[Stage, ...]:
        """v = v₀ + Δτ a, q = q₀ + Δτ v."""
        return (_euler(),)


def _euler() -> Stage:
    return Stage(1.0, (1.0,), (0.0,), 1.0, (0.0,), 1.0)


_KINDS = NewmarkBeta, HHT, HHTInterpolated, GeneralisedAlpha, TRBDF2, Bathe, CentralDifference, SemiImplicitEuler
_KINDS += EulerImplicitDamper, BackwardEuler
INTEGRATORS = {kind.name: kind for kind in _KINDS}
