"""The order in which cells are computed, and the coarse cells that stand for those that are not known yet."""

import numpy as np
import pytest
from vibroscope.engine import Reference, System
from vibroscope.engine.sweeps import COARSEST, EtaStudy, nearest_known
from vibroscope.engine.sweeps.batches import (
    adaptive_batches,
    chunk_shape,
    chunks,
    chunks_in_order,
    coarse_first,
    interlaced_order,
)


def continued(direction, n=37):
    return EtaStudy(
        System(), Reference(), 1.0, transient=10, sample=5, values=np.linspace(1, 2, n), direction=direction
    )


@pytest.mark.parametrize("shape", [(1,), (7,), (64, 64), (1000, 3), (10_000, 10_000)])
def test_chunks_cover_every_cell_once(shape):
    sides = chunk_shape(shape, 500, 30)
    assert 1 <= np.prod(sides) <= 16_384
    if np.prod(shape) < 10**6:
        seen = np.zeros(shape, int)
        for chunk in chunks(shape, sides):
            seen[chunk] += 1
        assert (seen == 1).all()


def test_chunks_of_a_downward_continuation_come_from_the_top():
    up, down = (chunks_in_order(continued(direction), (10,)) for direction in ("up", "down"))
    assert down == up[::-1]
    assert up[0] == (slice(0, 10),)


@pytest.mark.parametrize("shape", [(1,), (37,), (8, 8), (13, 21)])
def test_every_cell_comes_once_and_the_coarse_ones_first(shape):
    order = interlaced_order(shape)
    assert sorted(order) == list(range(int(np.prod(shape))))
    places = np.array(np.unravel_index(order, shape))
    coarse = (places % COARSEST == 0).all(axis=0)
    assert coarse[: coarse.sum()].all()
    halved = (places % (COARSEST // 2) == 0).all(axis=0)
    assert halved[: halved.sum()].all()


def test_on_each_level_the_first_axis_runs_fastest():
    first, second = np.unravel_index(interlaced_order((24, 24)), (24, 24))
    assert first[:4].tolist() == [0, 8, 16, 0]
    assert second[:4].tolist() == [0, 0, 0, 8]


@pytest.mark.parametrize("direction", ["rest", "up", "down"])
def test_known_cells_come_in_the_first_batch_and_the_others_once(direction):
    known = np.zeros(37, bool)
    known[slice(-10, None) if direction == "down" else slice(10)] = True
    first, *others = (cells for (cells,) in coarse_first(continued(direction), known))
    assert first.tolist() == np.flatnonzero(known).tolist()
    assert sorted(np.concatenate(others)) == np.flatnonzero(~known).tolist()
    assert all((np.diff(cells) > 0).all() for cells in others)
    if direction == "down":
        assert others[0][-1] == 26


def test_batches_are_the_order_whole_and_grow_while_they_are_quick():
    order = np.arange(3000)
    pieces = list(adaptive_batches(order))
    assert (np.concatenate(pieces) == order).all()
    assert len(pieces[0]) < len(pieces[1])


def test_a_cell_that_is_not_known_is_shown_as_the_finest_known_one_that_stands_for_it():
    shape = (16, 24)
    known = np.zeros(shape, bool)
    assert (nearest_known(known) == -1).all()
    known[::8, ::8] = True
    rows, columns = np.unravel_index(nearest_known(known), shape)
    assert (rows == np.arange(16)[:, None] // 8 * 8).all()
    assert (columns == np.arange(24) // 8 * 8).all()
    known[4, 4] = True
    assert nearest_known(known)[7, 7] == nearest_known(known)[4, 4] == 4 * 24 + 4
    assert nearest_known(known)[3, 7] == 0
    known[:] = True
    assert (nearest_known(known).ravel() == np.arange(16 * 24)).all()
