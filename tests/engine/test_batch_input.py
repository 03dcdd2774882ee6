"""What is refused in the input of many cells, and the words."""

import numpy as np
import pytest
from vibroscope.engine import Cells, ExactPenalty, Newmark, Reference, System, run_cells

CELLS = Cells(System(), [2.76], ExactPenalty(12000, 18))

BAD = {
    "eta = 0.0": lambda: Cells(System(), [1.0, 0.0], Reference()),
    "eta = nan": lambda: Cells(System(), [1.0, np.nan], Reference()),
    "K = -1": lambda: Cells(System(), [1, 1], ExactPenalty(1, 1), stiffness=[1, -1]),
    "steps = 100.5": lambda: Cells(System(), [1, 1], Newmark(1, 1, 10), steps=[100, 100.5]),
    "no number of the reference": lambda: Cells(System(), [1], Reference(), stiffness=[1]),
    "2 entries": lambda: Cells(System(), [1], ExactPenalty(1, 1), stiffness=[1, 2]),
    "gap": lambda: Cells(System(), [1], Reference(), initial=[[1, 0, 0, 0]]),
    "shape": lambda: Cells(System(), [1], Reference(), initial=[[1, 0, 0]]),
    "initial = 10000000.0": lambda: Cells(System(), [1], Reference(), initial=[[0, 0, 1e7, 0]]),
    "transient": lambda: run_cells(CELLS, transient=-1, sample=1),
    "sample": lambda: run_cells(CELLS, transient=1, sample=0),
    "coordinate = 4": lambda: run_cells(CELLS, transient=1, sample=1, coordinates=(4,)),
    "threads = 0": lambda: run_cells(CELLS, transient=1, sample=1, threads=0),
}


@pytest.mark.parametrize("text", BAD)
def test_bad_input(text):
    with pytest.raises(ValueError, match=text):
        BAD[text]()
