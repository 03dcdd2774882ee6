"""Energy balance with another contact law, by integrals along the exact penalty solution.

Of located steps they begin anew at each row of the section, so that errors do not add up; a contact that is open there
does not show the closing speed that a formula's damper needs.
"""

import numpy as np

from ..drivers.event_driven import contact_state
from ..drivers.law_driven import law_powers
from ..methods import ExactPenalty, Newmark, TimeStepping
from ..result import Response
from .quadratic_forms import energy_forms
from .result import EnergyBalance


def spring_energy(method: ExactPenalty | Newmark | TimeStepping, gap: np.ndarray) -> np.ndarray:
    """Energy that the contact spring stores at each gap, Kδⁿ⁺¹/(n + 1)."""
    n = method.spring_exponent
    return method.stiffness * np.maximum(-gap, 0.0) ** (n + 1.0) / (n + 1.0)


def balance_of_law(response: Response, rows: np.ndarray) -> EnergyBalance:
    """Balance each period between two rows of the section.

    Parameters
    ----------
    rows : (n + 1, 4) ndarray
        Of the section; the last n + 1 of the kept periods, or with the start before them.
    """
    system, method, begun = response.system, response.method, response.checkpoint.periods
    if not method.has_step:
        periods = range(begun, begun + len(response.section))
        powers = law_powers(system, response.eta, method, response.checkpoint.state, periods)[1 - len(rows) :]
    else:
        each = (law_powers(system, response.eta, method.limit, row, range(1)) for row in rows[:-1])
        powers = np.concatenate(list(each))
    forms, y = energy_forms(response), contact_state(system, rows)
    z = y - np.array([0.0 if system.wall else system.separate_rest[0], 0.0, forms.free_gap, 0.0])
    spring = spring_energy(method, y[:, 2])
    stored = np.einsum("ki,ij,kj->k", z, forms.stored[:4, :4], z) + spring
    return EnergyBalance(
        gain=np.diff(stored),
        work=powers[:, 0],
        dampers=powers[:, 1],
        contact=powers[:, 2] - np.diff(spring),
        impacts=np.zeros(len(powers)),
        stored=float(stored.max()),
    )
