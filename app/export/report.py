"""The report of one state of the page: HTML that opens without a server. No panel import.

The browser inserts its figures as SVG into the elements with a ``data-figure``, and saves the result as a file.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape

from vibroscope.app.explorer.state import Setting
from vibroscope.app.export.formats import Figure
from vibroscope.app.export.label import setting_rows

STYLE = """
body { max-width: 60rem; margin: 2rem auto; padding: 0 1rem; font: 16px/1.5 system-ui, sans-serif; color: #22303c; }
body { overflow-wrap: anywhere; }
table { border-collapse: collapse; } td, th { padding: 2px 14px 2px 0; text-align: left; font-weight: normal; }
@media (min-width: 46em) { td, th { overflow-wrap: break-word; } }
figure { margin: 1.5rem 0; } figure svg { max-width: 100%; height: auto; } figcaption { color: #566573; }
pre { padding: 10px; white-space: pre-wrap; background: #f3f5f7; font-size: 13px; }
@media screen and (prefers-color-scheme: dark) {
  body { background: #131416; color: #cfd0d0; } a { color: #7ab3f5; }
  pre { background: #202226; } figcaption { color: #9aa5b1; } figure svg { background: white; }
}
"""


def as_report(
    title: str,
    words: Mapping[str, str],
    setting: Setting | None,
    figures: Sequence[Figure],
    scripts: Sequence[str],
    source: Mapping[str, str],
) -> str:
    """The report without its figures, which the browser inserts.

    Parameters
    ----------
    title : str
        Title of the tab.
    words : mapping of str to str
        Paragraphs by their headings.
    setting : Setting or None
        The setting of the figures, if they depend on one.
    figures : sequence of Figure
        In their order.
    scripts : sequence of str
        That reproduce the numbers.
    source : mapping of str to str
        ``program``, ``made`` (date), ``address`` of the page.
    """
    lines = "".join(f"<h3>{escape(head)}</h3><p>{escape(text)}</p>" for head, text in words.items())
    drawn = "".join(
        f'<figure><div data-figure="{escape(one.name)}"></div><figcaption>{escape(one.caption)}</figcaption></figure>'
        for one in figures
    )
    commands = "".join(f"<pre>{escape(script)}</pre>" for script in scripts)
    return f"""<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width">
<title>Vibroscope report: {escape(title)}</title>
<style>{STYLE}</style></head><body>
<h1>Vibroscope report: {escape(title)}</h1>
<h2>What it means</h2>{lines}
{_setting_table(setting) if setting else ""}
<h2>Figures</h2>{drawn}
<h2>How to reproduce these numbers</h2>{commands}
<p>{escape(source["program"])}, {escape(source["made"])}; the page:
<a data-page>{escape(source["address"])}</a></p>
</body></html>
"""


def _setting_table(setting: Setting) -> str:
    rows = "".join(
        f"<tr><th>{escape(label)}</th><td>{escape(text)}</td><td>{escape(doc)}</td></tr>"
        for label, text, doc in setting_rows(setting)
    )
    return f"<h2>Setting</h2><table>{rows}</table>"
