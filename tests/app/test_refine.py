"""The order of cells, and the coarse picture that stands for what is not known yet."""

import numpy as np
import pytest
from vibroscope.app.studies.refine import COARSEST, batches, interlaced, nearest


@pytest.mark.parametrize("shape", [(1,), (37,), (8, 8), (13, 21)])
def test_every_cell_comes_once_and_the_coarse_ones_first(shape):
    order = interlaced(shape)
    assert sorted(order) == list(range(int(np.prod(shape))))
    places = np.array(np.unravel_index(order, shape))
    coarse = (places % COARSEST == 0).all(axis=0)
    assert coarse[: coarse.sum()].all()
    halved = (places % (COARSEST // 2) == 0).all(axis=0)
    assert halved[: halved.sum()].all()


def test_a_cell_that_is_not_known_is_shown_as_the_finest_known_one_that_stands_for_it():
    shape = (16, 24)
    known = np.zeros(shape, bool)
    assert (nearest(known) == -1).all()
    known[::8, ::8] = True
    rows, columns = np.unravel_index(nearest(known), shape)
    assert (rows == np.arange(16)[:, None] // 8 * 8).all()
    assert (columns == np.arange(24) // 8 * 8).all()
    known[4, 4] = True
    assert nearest(known)[7, 7] == nearest(known)[4, 4] == 4 * 24 + 4
    assert nearest(known)[3, 7] == 0
    known[:] = True
    assert (nearest(known).ravel() == np.arange(16 * 24)).all()


def test_batches_are_the_order_whole_and_grow_while_they_are_quick():
    order = np.arange(3000)
    pieces = list(batches(order))
    assert (np.concatenate(pieces) == order).all()
    assert len(pieces[0]) < len(pieces[1])
