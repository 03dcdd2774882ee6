"""The K–D plane of a method whose steps may have no solution: they are counted, coloured, said and taken away."""

import numpy as np
import pytest
from vibroscope.app.explorer.state import Setting
from vibroscope.app.page import asker
from vibroscope.app.page.study.plane import Plane, statements
from vibroscope.app.page.tab import Move
from vibroscope.app.studies import cell_classes as classes
from vibroscope.app.studies import plane
from vibroscope.app.studies.plane import grow_plane

from tests.app.fakes import FakeHost

ITERATED = Setting(integrator="hht", alpha=-0.1, status="end", without_solution="keep", steps=60)


@pytest.fixture(scope="module")
def small():
    """A plane in few cells, with the status iterated to the end of the step."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(plane, "COUNT", 8)
        patch.setattr(plane, "TRANSIENT", 50)
        tab = Plane(FakeHost())
        tab.build()
        yield list(grow_plane(tab.question(ITERATED), None, lambda: False))[-1]


def test_a_count_has_the_colour_of_its_class_and_the_side_without_a_step_none(small):
    quantity = classes.COLOURINGS["without_solution"]
    picture = classes.class_image(small, "penalty", "without_solution")
    counts = small.steps_without_solution("penalty")
    shown = picture != classes.DIVERGED
    for index, count in zip(picture[shown], counts[shown], strict=True):
        assert classes.PALETTE[index] == quantity.classes[sum(count >= edge for edge in quantity.edges)][1]
    exact = classes.class_image(small, "exact", "without_solution")
    assert set(np.unique(exact)) <= {classes.NO_NUMBER, classes.DIVERGED}
    assert [classes.SPECIAL[classes.NO_NUMBER], "no time step", "missing"] in classes.legend("without_solution")


def test_the_statements_say_how_many_steps_of_the_cell_and_in_how_many_cells(small):
    counts = small.steps_without_solution("penalty")
    row, column = np.unravel_index(np.argmax(counts), counts.shape)
    K, D = small.question.axis("K")[column], small.question.axis("D")[row]
    texts = [text for _, text in statements(Setting(K=K, D=D), small)]
    assert " steps without a solution." in texts[0]
    assert "without a solution" not in texts[1]
    assert f"In {100 * (counts > 0).mean():.0f} % a step has no solution." in texts[2]


class Waiting:
    """Stands for `StudyJob`: nothing is computed."""

    cancelled = out_of_time = False

    def __init__(self, question, grow, deliver):
        self.question, self.deliver = question, deliver
        Waiting.last = self

    def cancel(self):
        pass


def test_the_colour_is_offered_where_a_step_may_have_no_solution_and_the_counts_go_to_files(small, monkeypatch):
    monkeypatch.setattr(asker, "StudyJob", Waiting)
    tab = Plane(FakeHost())
    tab.build()
    tab.show(Move(1, Setting()))
    assert tab.panel.away == {"quantity": ["without_solution"]}
    tab.show(Move(2, ITERATED))
    assert tab.panel.away == {}
    tab.panel.receive({"choose": {**tab.panel.chosen, "quantity": "without_solution"}})
    Waiting.last.deliver(Waiting.last, small)
    assert tab.panel.key_title == "Steps without a solution"
    assert "10 to 99" in [text for _, text, _ in tab.panel.key]
    assert tab.view.figures["plane_penalty"].title.text.partition(": ")[2].startswith("steps without a solution ")
    (series,) = tab.table("plane_penalty")
    assert (series.columns["steps_without_solution"] == small.tables["penalty"]["steps_without_solution"].ravel()).all()
    assert "steps_without_solution" in tab.data()["penalty"]
    tab.show(Move(3, Setting()))  # the last picture has no colours of another one
    assert tab.panel.away
