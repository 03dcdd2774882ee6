"""The report of one state of the page: HTML that opens without a server. No panel import.

The browser puts its figures, as SVG, into the elements with a ``data-figure``, and offers the whole as a file.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape

from vibroscope.app.explorer.state import Explorer, Setting, texts_of
from vibroscope.app.export.formats import Figure

_STYLE = """
body { max-width: 60rem; margin: 2rem auto; padding: 0 1rem; font: 16px/1.5 system-ui, sans-serif; color: #22303c; }
table { border-collapse: collapse; } td, th { padding: 2px 14px 2px 0; text-align: left; font-weight: normal; }
figure { margin: 1.5rem 0; } figure svg { max-width: 100%; height: auto; } figcaption { color: #566573; }
pre { padding: 10px; overflow-x: auto; background: #f3f5f7; font-size: 13px; }
"""


def as_report(
    title: str,
    words: Mapping[str, str],
    setting: Setting | None,
    figures: Sequence[Figure],
    scripts: Sequence[str],
    source: Mapping[str, str],
) -> str:
    """The report, its figures still missing.

    Parameters
    ----------
    title : str
        Of what is reported.
    words : mapping of str to str
        Lines by their headings, e.g. the verdict.
    setting : Setting or None
        What was set, if the figures depend on it.
    figures : sequence of Figure
        In their order.
    scripts : sequence of str
        That give these numbers again.
    source : mapping of str to str
        ``program``, ``made`` (when), ``address`` of the page.
    """
    lines = "".join(f"<h3>{escape(head)}</h3><p>{escape(text)}</p>" for head, text in words.items())
    drawn = "".join(
        f'<figure><div data-figure="{escape(one.name)}"></div><figcaption>{escape(one.caption)}</figcaption></figure>'
        for one in figures
    )
    again = "".join(f"<pre>{escape(script)}</pre>" for script in scripts)
    return f"""<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><title>Vibroscope report: {escape(title)}</title>
<style>{_STYLE}</style></head><body>
<h1>Vibroscope report: {escape(title)}</h1>
<h2>What it means</h2>{lines}
{_what_was_set(setting) if setting else ""}
<h2>What is shown</h2>{drawn}
<h2>How to get these numbers again</h2>{again}
<p>{escape(source["program"])}, {escape(source["made"])}; the page:
<a data-page>{escape(source["address"])}</a></p>
</body></html>
"""


def _what_was_set(setting: Setting) -> str:
    rows = "".join(
        f"<tr><th>{escape(Explorer.param[name].label)}</th><td>{escape(text)}</td>"
        f"<td>{escape(Explorer.param[name].doc)}</td></tr>"
        for name, text in texts_of(setting).items()
    )
    return f"<h2>What was set</h2><table>{rows}</table>"
