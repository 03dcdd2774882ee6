"""Contacts alone, one after the other: what the steps of a one-step method make of each touch.

The bodies come with the same speed and touch at different instants within a step. A contact is over when the bodies
have parted and a step changes their speed as in flight: methods that average over a step feel the contact after it.
"""

from vibroscope.engine.kernels.compile.options import jit_no_alloc
from vibroscope.engine.kernels.compile.record import no_contact
from vibroscope.engine.kernels.status import DIVERGED, OK
from vibroscope.engine.kernels.time_stepping.linear_step import FORCE, STATE_ROWS, StepProgress, advance

SAME_SPEED = 1e-12  # change of speed by a step, as a share of the closing speed, that is none
SPEED, GAP, DEPTH, PUSH, PULL, STEPS, NONE, TWO, CODE = range(9)  # columns of what is found
FOUND = 9
STUCK = -1  # code of a contact that has not ended


@jit_no_alloc
def run_touches(m, angles, starts, flight, most, work, buffers, found):
    """Follow contacts until they are over.

    Parameters
    ----------
    m : linear_step.LinearScheme
        In units in which closing speeds are some one.
    angles : (2, 1) float64
        One and zero: cos ητ and sin ητ of a load that is constant.
    starts : (n, 2) float64
        Gap and its rate at the last step before each touch.
    flight : float
        Acceleration of the gap without contact.
    most : int
        Steps after which a contact counts as one that does not end.
    work : (3 or more, WORK) float64
        Work space.
    buffers : Buffers
        Without room.
    found : (n, FOUND) float64
        Written: g′ and g after the contact, the deepest penetration, the largest and the smallest λ at a step, steps in
        which λ acts, steps without a solution and with two, and OK, DIVERGED (also where the bodies do not part and
        move faster than they came), WITHOUT_SOLUTION or STUCK.
    """
    u, window = work[3, :STATE_ROWS], (1, 1, 1)
    for i in range(starts.shape[0]):
        u[:] = 0.0
        u[1], u[3], u[5] = starts[i, 0], starts[i, 1], flight
        at, code, row, over = StepProgress(0, False, 0, 0, 0, no_contact()), OK, found[i], False
        row[:] = 0.0
        while not over and code == OK and at.step < most:
            before = u[3]
            at, code = advance(m, angles, u, at, work, window, buffers)
            rate = u[3]
            row[DEPTH] = max(row[DEPTH], -u[1])
            row[PUSH], row[PULL] = max(row[PUSH], u[FORCE]), min(row[PULL], u[FORCE])
            row[STEPS] += at.status
            parted = at.step > 1 and at.status == 0 and not at.pressed and rate > 0.0
            over = parted and abs(rate - before - flight * m.system.h) <= SAME_SPEED
        row[SPEED], row[GAP], row[NONE], row[TWO] = u[3], u[1], at.none, at.two
        moving = DIVERGED if abs(row[SPEED]) > abs(starts[i, 1]) else STUCK
        row[CODE] = code if code != OK or over else moving
