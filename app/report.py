"""The report of one state of the page: HTML that opens without a server. No panel import.

The browser puts its figures, as SVG, into the elements with a ``data-figure``, and offers the whole as a file.
"""

from __future__ import annotations

from collections.abc import Mapping
from html import escape

from app.state import Explorer, Setting, texts_of
from app.takeaway import as_command, as_python, provenance

_FIGURES = {
    "phase1": "Phase plot of pendulum 1 with its Poincaré section (τ ≡ 0 mod T).",
    "phase2": "Phase plot of pendulum 2 with its Poincaré section.",
    "displacement": "Displacements over the last two excitation periods.",
    "strip": "Intervals in contact; an impact of the reference has no length.",
    "force": "Contact force, and the impulse of each impact.",
    "diagram": "Bifurcation diagram of the reference; the line marks η.",
}
_STYLE = """
body { max-width: 60rem; margin: 2rem auto; padding: 0 1rem; font: 16px/1.5 system-ui, sans-serif; color: #22303c; }
table { border-collapse: collapse; } td, th { padding: 2px 14px 2px 0; text-align: left; font-weight: normal; }
figure { margin: 1.5rem 0; } figure svg { max-width: 100%; height: auto; } figcaption { color: #566573; }
pre { padding: 10px; overflow-x: auto; background: #f3f5f7; font-size: 13px; }
"""


def as_report(setting: Setting, words: Mapping[str, str], made: str) -> str:
    """The report, its figures still missing.

    Parameters
    ----------
    setting : Setting
    words : mapping of str to str
        Lines by their headings, e.g. the verdict.
    made : str
        When, in words.
    """
    lines = "".join(f"<h3>{escape(head)}</h3><p>{escape(text)}</p>" for head, text in words.items())
    rows = "".join(
        f"<tr><th>{escape(Explorer.param[name].label)}</th><td>{escape(text)}</td>"
        f"<td>{escape(Explorer.param[name].doc)}</td></tr>"
        for name, text in texts_of(setting).items()
    )
    figures = "".join(
        f'<figure><div data-figure="{name}"></div><figcaption>{escape(caption)}</figcaption></figure>'
        for name, caption in _FIGURES.items()
    )
    source = provenance(setting)
    return f"""<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><title>Vibroscope report</title><style>{_STYLE}</style></head><body>
<h1>Vibroscope report</h1>
<h2>What it means</h2>{lines}
<h2>What was set</h2><table>{rows}</table>
<h2>What moves</h2>{figures}
<h2>How to get these numbers again</h2>
<pre>{escape(as_command(setting))}</pre><pre>{escape(as_python(setting))}</pre>
<p>{escape(source["program"])}, {escape(made)}; address of the page: {escape(source["address"])}</p>
</body></html>
"""
