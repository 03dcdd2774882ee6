"""Energy balance of a response: what the excitation puts in, and where it goes.

    gain of mechanical energy = work of the excitation − dampers − contact damper − impacts

in units of m₁ω₁² times the base amplitude squared. The mechanical energy is that of the motion relative to the base,

    E = [ξ₁′² + ξ₁² + μ(ξ₂′² + κ²ξ₂²) + K min(g, 0)²] / 2,

K = 0 for the reference; the powers are η² cos ητ (ξ₁′ + μξ₂′) for the excitation, 2d₁ξ₁′² + 2μd₂κξ₂′² for the dampers
(2d₃κ₃(1 + μ)ξ′² while joined), 2Dg′² for the contact damper; an impact takes μ/(1 + μ) (g′⁻² − g′⁺²)/2.

The balance knows nothing of how the motion was marched. The reference, the exact penalty and the located step are
followed from one row of the section through the events of the response to the next row: between two events z′ = A z
(:mod:`..kernels.linear.tables`), so that every power is a quadratic form zᵀQz with the integral

    ∫₀ˢ zᵀQz dτ = z(0)ᵀ G(s) z(0),    G(2s) = G(s) + E(s)ᵀ G(s) E(s),    E(2s) = E(s)².

An event missed, misplaced or misjudged leaves a residual. For Newmark with a constant step the sums are those of
the discrete solution, which balances exactly within each step: the residual is the energy that the steps make where
contact changes.
"""

import numpy as np

from ..methods import Newmark
from ..result import Response
from .balance import EnergyBalance
from .events import along_events
from .steps import along_steps


def energy(response: Response, start: tuple[float, float, float, float] | None = None) -> EnergyBalance:
    """Energy balance of the kept periods of a response.

    Parameters
    ----------
    response : Response
        Of Newmark with a constant step: with every step of its sampled periods recorded; these are balanced.
    start : (4,) sequence, optional
        ξ₁, ξ₁′, ξ₂, ξ₂′ at the beginning of the kept periods: what the run was started with, if all periods are kept.
        Without it the balance begins with the second kept period, since a section is read at the end of periods.

    Returns
    -------
    EnergyBalance
        With a located step so coarse that it misplaces contacts by more than their depth, the closed form leaves the
        solution: the residual is then large, and nan where numbers overflow.

    Raises
    ------
    ValueError
        If the run ended early, if too few periods are kept, or if Newmark's steps were not all recorded.
    """
    if not response.ok:
        raise ValueError(response.ending)
    if isinstance(response.method, Newmark) and not response.method.located:
        return along_steps(response)
    rows = response.section if start is None else np.vstack([np.asarray(start, dtype=float), response.section])
    if len(rows) < 2:
        raise ValueError("one kept period has no beginning to balance from: keep two, or give the start")
    return along_events(response, rows)
