from itertools import pairwise

from vibroscope.app.explorer.state import Setting
from vibroscope.app.page.session import History

DEFAULT = Setting()


def test_a_drag_is_undone_as_a_whole_and_redone_until_something_else_is_moved():
    history, steps = History(), [DEFAULT._replace(eta=eta) for eta in (1.0, 1.1, 1.2)]
    for i, (before, after) in enumerate(pairwise(steps)):
        history.add(before, after, now=0.1 * i)
    other = steps[-1]._replace(K=99.0)
    history.add(steps[-1], other, now=0.3)
    assert history.undo(other) == steps[-1]
    assert history.undo(steps[-1]) == steps[0]
    assert history.undo(steps[0]) is None
    assert history.redo(steps[0]) == steps[-1]
    assert history.redo(steps[-1]) == other
    assert history.undo(other) == steps[-1]
    history.add(steps[-1], steps[0], now=9.0)
    assert not history.can_redo


def test_moves_that_lie_apart_in_time_are_undone_one_by_one():
    history, steps = History(), [DEFAULT._replace(eta=eta) for eta in (1.0, 1.1, 1.2)]
    history.add(steps[0], steps[1], now=0.0)
    history.add(steps[1], steps[2], now=5.0)
    assert history.undo(steps[2]) == steps[1]
    assert history.undo(steps[1]) == steps[0]
