"""Brute force along the whole range of the paper's system: what runs at 1,000 η show lies on the branches."""

import numpy as np
from vibroscope.engine import BranchQuestion, Cells, Reference, System, find_branches, run_cells, steady

PAPER, RANGE, LONGEST = System(), (0.5, 4.0), 6


def test_what_runs_show_as_periodic_at_a_thousand_values_lies_on_a_branch(capsys):
    found = find_branches(BranchQuestion(PAPER, 2.76, Reference(), low=RANGE[0], high=RANGE[1], max_period=LONGEST))
    values = np.linspace(*RANGE, 1000)
    runs = run_cells(Cells(PAPER, values, Reference()), transient=4000, sample=64)
    off, apart = [], []
    for value, period, end in zip(values, runs.period, runs.end, strict=True):
        if not 0 < period <= LONGEST:
            continue
        limit = steady(PAPER, value, Reference(), initial=end, max_period=int(period))  # of the run, which goes on
        size = np.abs(limit.response.section).max()
        beside = [near for branch in found if branch.period == limit.period for near in orbits_at(branch, value)]
        distances = [np.abs(near.state - limit.state).max() / size for near in beside]
        k = int(np.argmin(distances))
        off.append(distances[k])
        polynomials = [np.poly(each.multipliers) for each in (beside[k], limit)]
        apart.append(np.abs(np.subtract(*polynomials)).max() / max(1.0, np.abs(limit.multipliers).max()))
    with capsys.disabled():
        print(f"\n{len(off)} periodic runs, {len(found)} branches: {max(off):.1e} of their size from them at most")
    assert len(off) > 700
    assert max(off) < 1e-9
    assert max(apart) < 1e-7


def orbits_at(branch, value):
    """The steady motions at a value that the chords between neighbouring orbits of a branch lead to, close by."""
    for k in np.flatnonzero((branch.values[:-1] - value) * (branch.values[1:] - value) <= 0):
        share = (value - branch.values[k]) / (branch.values[k + 1] - branch.values[k])
        chord = branch.sections[k + 1] - branch.sections[k]
        for row in branch.sections[k] + share * chord:
            near = steady(PAPER, value, Reference(), initial=row, max_period=branch.period)
            if near.periodic and np.abs(near.state - row).max() <= np.abs(chord).max() + 1e-6 * np.abs(row).max():
                yield near
