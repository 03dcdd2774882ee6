"""Serves a page with the explorer's figures, sizes and data and nothing else: the least that Bokeh needs for them.

It has Bokeh's own slider and layout and one callback, which writes columns that were computed before the server
started: no solver, no Panel, no text, no animation.

.venv/bin/python benchmarks/_bare_page.py PORT ORIGIN,… SIZES   (SIZES: {"phase1": [width, height], …} as JSON)
"""

import json
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from bokeh.layouts import column, row
from bokeh.models import Slider
from bokeh.server.server import Server

sys.path.insert(0, str(Path(__file__).parents[1]))

from vibroscope.app.explorer.compute import compute_runs
from vibroscope.app.explorer.present import present
from vibroscope.app.explorer.shipped import load_diagram
from vibroscope.app.explorer.state import Setting
from vibroscope.app.page.explore.eta_map import EtaMapView, MapPoints
from vibroscope.app.page.explore.figures import MotionView
from vibroscope.app.page.shared.figure import THEME, write
from vibroscope.app.runtime.cache import Cache

SETTING = Setting()
ETAS = [round(0.01 * n, 2) for n in range(50, 281)]


def columns_of(eta):
    """What the explorer would send for one η."""
    return present(compute_runs(SETTING._replace(eta=eta), cache=Cache(0)))


class Bare:
    """One session."""

    def __init__(self, doc, prepared, sizes):
        self.doc, self.prepared = doc, prepared
        motion = MotionView()
        columns = prepared[SETTING.eta]
        # the section first: a figure is painted as soon as its columns are there, and the probe reads η in those of it
        order = sorted(columns, key=lambda name: name != "section_reference")
        self.sources = {name: motion.sources[name] for name in order}
        diagram = EtaMapView(motion.sources)
        self.cursor = diagram.cursor
        for name, source in self.sources.items():
            write(source, columns[name])
        motion.update(SETTING, fresh=True)
        shipped = load_diagram("table").result()
        diagram.update(SETTING, MapPoints(shipped.eta, shipped.displacement, 1.0), fresh=True)
        order = ("phase1", "phase2", "displacement", "strip", "force")
        figures = [*(motion.figures[name] for name in order), diagram.figure]
        for figure in figures:
            figure.sizing_mode = "fixed"
            figure.width, figure.height = sizes[figure.name]
        slider = Slider(start=0.5, end=4, step=0.01, value=SETTING.eta, width=sizes["slider"][0], title="η")
        slider.on_change("value", self.moved)
        one, two, wide, strip, low, map_ = figures
        doc.add_root(column(slider, row(one, two), wide, strip, row(low, map_)))
        doc.theme = THEME

    def moved(self, _, __, eta):
        """Write the columns of this η, as one message."""
        self.doc.hold("collect")
        columns = self.prepared[round(eta, 2)]
        for name, source in self.sources.items():
            write(source, columns[name])
        self.cursor.location = eta
        self.doc.unhold()


def main():
    """Serve until a signal ends it."""
    port, origins, sizes = int(sys.argv[1]), sys.argv[2].split(","), json.loads(sys.argv[3])
    with ThreadPoolExecutor(2) as pool:
        prepared = dict(zip(ETAS, pool.map(columns_of, ETAS), strict=True))
    load_diagram("table").result()
    server = Server({"/": lambda doc: Bare(doc, prepared, sizes)}, port=port, allow_websocket_origin=origins)
    server.run_until_shutdown()


if __name__ == "__main__":
    main()
