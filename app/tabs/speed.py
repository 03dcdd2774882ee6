"""Speed against error: the work–precision figure, as it was measured and shipped."""

from __future__ import annotations

import panel as pn

from app.files import style
from app.tabs.base import Tab

# Served from assets/speed; `benchmarks/work_precision.py --write` renews it.
FIGURE = "speed/work-precision.svg"
_TEXT = f"""
<article class="text wide">
<h2>What a period costs, and how wrong it is</h2>
<p>Six problems; error after ten periods against 60-digit solutions, over the time that one period takes. Further left
is faster, further down is more exact. The solvers in closed form are single points: they have no time step. Newmark's
error falls about as the step, and irregularly, since each contact change is missed by a part of a step; that of the
located step, which lands on the contact changes, falls as its square.</p>
<p><a class="figure-link" href="{FIGURE}" target="_blank" rel="noopener">Open the figure by itself</a></p>
<img class="figure" src="{FIGURE}" alt="Error after ten periods against time per period for six problems: the closed
form solvers lie furthest to the lower left, plain Newmark furthest to the upper right.">
</article>
"""


class Speed(Tab):
    """A figure that depends on nothing that is set."""

    key = "speed"
    title = "Speed against error"
    controls = False

    def build(self) -> pn.viewable.Viewable:
        """The figure with its explanation."""
        return pn.pane.HTML(_TEXT, stylesheets=[style("text")], sizing_mode="stretch_width", sanitize_html=False)
