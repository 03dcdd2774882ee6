"""Free vibrations: the motion of bodies that nothing drives has a period of its own, or none.

Nothing sets the instant at which such a motion is looked at, so that its section at τ ≡ 0 mod 2π/η says nothing: η is
arbitrary. The motion repeats itself if its impacts do, in position and velocities.
"""

import numpy as np

from ..result import Response
from .tolerances import REPEATED_IMPACTS, REPEATED_IMPACTS_BY_STEPS

MOST_IMPACTS = 8  # of a cycle


def own_period(response: Response) -> float:
    """Time τ after which a free vibration repeats itself, by its impacts; nan if they do not show one.

    Parameters
    ----------
    response : Response
        Of a system that nothing drives.
    """
    found = response.impacts
    rows = np.column_stack([found.position, found.velocity_before])
    tolerance = (REPEATED_IMPACTS_BY_STEPS if response.method.has_step else REPEATED_IMPACTS) * np.abs(rows).max(
        initial=0.0
    )
    for count in range(1, min(MOST_IMPACTS, len(rows) // 2) + 1):
        times = found.time[count:] - found.time[:-count]
        if np.abs(rows[count:] - rows[:-count]).max() <= tolerance and np.ptp(times) <= tolerance:
            return float(times.mean())
    return np.nan
