"""The contact force over time: of the touch closest to what was asked, of the farthest, and without a step."""

import math
from typing import NamedTuple

import numpy as np
from vibroscope.engine.drivers.alone import force_alone, parameters_alone
from vibroscope.engine.one_impact.forward import WithStep, impact
from vibroscope.engine.one_impact.instants import SHORT
from vibroscope.engine.one_impact.question import Impact

CONTACT_TIMES = 2.0  # after so many a contact that has not ended is not followed further
MOST_GIVEN = 1000  # steps that are given; of more, each second, third, …


class ForceCourse(NamedTuple):
    """The force of one contact over time."""

    instant: float  # of touch, in steps after a step; nan without a step
    restitution: float
    time: np.ndarray  # (n,), since touch
    force: np.ndarray  # (n,); with a step that at the end of each step


def force_courses(
    question: Impact, asked: float | None = None, found: WithStep | None = None
) -> dict[str, ForceCourse]:
    """The force over time of the best touch within a step, of the worst, and of the contact without a step.

    The best has the restitution nearest to what was asked for, and the worst the farthest of all that have one.

    Parameters
    ----------
    question : Impact
    asked : float, optional
        The restitution that was asked for; by default what the contact gives without a step.
    found : WithStep, optional
        What `impact` finds; without it, it is computed.

    Returns
    -------
    dict of str to ForceCourse
        "best" and "worst", both left out where no touch has a restitution, and "exact".

    Raises
    ------
    ValueError
        If there is no time step.

    Examples
    --------
    >>> from vibroscope.engine import Impact, TimeStepping, force_courses
    >>> question = Impact(TimeStepping(1e6, 0.0, 4), 1.0, time_step=1e-4).with_restitution(0.5)
    >>> courses = force_courses(question.with_steps_per_contact(5))
    >>> {name: round(course.restitution, 2) for name, course in courses.items()}
    {'best': 0.56, 'worst': 0.23, 'exact': 0.5}
    """
    found = found or impact(question)
    wanted = question.without_step.restitution if asked is None else asked
    u, until = question.units, CONTACT_TIMES * question.contact_time
    known = np.isfinite(found.restitutions)
    lasting = found.instant[:, -1:] - found.instant[:, :1] > SHORT  # else rounding decides what a touch there gives
    known &= lasting | ~(known & lasting).any()
    off, touches, courses = np.abs(found.restitutions[known] - wanted), question.touches, {}
    for name, choose in (("best", np.argmin), ("worst", np.argmax)) if known.any() else ():
        k = choose(off)
        instant, e = float(found.instant[known][k]), float(found.restitutions[known][k])
        steps = math.ceil(until / question.time_step) + 1
        every = math.ceil(steps / MOST_GIVEN)
        force = touches.force(instant, steps, every)
        time = (every * np.arange(len(force)) - instant) * question.time_step
        courses[name] = ForceCourse(instant, e, time, force * u.force)
    p = parameters_alone(question.unit_method.limit, question.restitution, push=question.force / u.force)
    time, force = force_alone(p, until / u.time)
    courses["exact"] = ForceCourse(math.nan, question.without_step.restitution, time * u.time, force * u.force)
    return courses
