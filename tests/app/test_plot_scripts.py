"""The matplotlib script beside each table draws that table, and says what it shows."""

import runpy
from pathlib import Path

import matplotlib as mpl
import pytest
from matplotlib import pyplot as plt
from matplotlib.figure import Figure
from PIL import Image
from vibroscope.app.export import formats
from vibroscope.app.export.formats import Series
from vibroscope.app.export.label import figure_label
from vibroscope.app.export.plots import plot_script
from vibroscope.app.page.take_away import file_writer

from tests.share import every

from .filled_tabs import ADDRESS, SETTING, filled  # noqa: F401 - a fixture


def drawn(axes):
    """Number of curves, marks, bars and cells."""
    return sum(map(len, (axes.lines, axes.collections, axes.patches, axes.containers)))


@pytest.fixture
def saved(monkeypatch):
    """Paths of saved figures; of PDF files only the first is written, since each takes a part of a font with it."""
    names, save = [], Figure.savefig

    def savefig(figure, path, **options):
        if Path(path).suffix != ".pdf" or not any(Path(name).suffix == ".pdf" for name in names):
            save(figure, path, **options)
        names.append(str(path))

    monkeypatch.setattr(Figure, "savefig", savefig)
    return names


@pytest.mark.parametrize("key", every(["explore", "bifurcation", "plane", "basin", "step", "speed", "paper"]))
def test_the_script_of_each_figure_draws_its_table(filled, key, tmp_path, saved):  # noqa: F811
    mpl.use("Agg")
    tab = filled(key)
    plotted = [figure for figure in tab.figures() if figure.drawn and figure.tabled]
    for figure in set(tab.figures()) - {*plotted}:
        assert file_writer(tab, f"plot:{figure.name}", SETTING, ADDRESS) is None
    for figure in every(plotted):
        table, script = (file_writer(tab, f"{kind}:{figure.name}", SETTING, ADDRESS)() for kind in ("csv", "plot"))
        for file in (table, script):
            (tmp_path / file["name"]).write_text(file["text"], encoding="utf-8")
        space = runpy.run_path(str(tmp_path / script["name"]))
        axes = [space["axes"], *space["axes"].child_axes]
        assert sum(map(drawn, axes)) >= len(space["series"]), figure.name
        assert all(len(column) for series in space["series"].values() for column in series.values())
        assert axes[0].get_xlabel()
        assert "from_" not in axes[0].get_xlabel()
        plt.close("all")
        name = tmp_path / script["name"].removesuffix(".py")
        with Image.open(name.with_suffix(".png")) as picture:
            assert abs(picture.width - 85 / 25.4 * 300) <= 1
            assert figure.title in picture.text["Title"]
            assert "vibroscope" in picture.text["Description"]
        assert sorted(saved[-2:]) == [f"{name}.pdf", f"{name}.png"]
    (pdf,) = tmp_path.glob("*.pdf")
    assert pdf.read_bytes().startswith(b"%PDF-")


def test_axes_and_texts_have_the_units_of_the_page():
    columns = {"time [s]": [0.0, 0.1], "force [N]": [1.0, 2.0]}
    setting = SETTING._replace(units="si", omega1=100.0)
    label = figure_label("Explore", formats.Figure("force", 'Force """', "A \\ caption."), setting, "?eta=1")
    script = plot_script("vibroscope-force", [Series("reference", columns)], label)
    compile(script, "script", "exec")
    assert "set_xlabel('time t / s')" in script
    assert "set_ylabel('contact force λ / N')" in script
    assert "K = 1.2e8 N/m" in script


def test_a_measurement_is_drawn_as_dots():
    time = {"time": [0.0, 1.0], "xi1": [1.0, 2.0], "xi2": [3.0, 4.0]}
    phase = {"xi1": [1.0, 2.0], "velocity1": [3.0, 4.0]}
    for columns, lines in ((time, 2), (phase, 1)):
        table = [Series("reference", columns), Series("measured", columns)]
        script = plot_script("vibroscope-x", table, {"title": "t", "description": "d"})
        assert script.count('"o", color="0.15"') == lines
