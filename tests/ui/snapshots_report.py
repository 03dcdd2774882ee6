"""All differences from the baselines in one run, in one HTML file: old, new and difference."""

import base64
import difflib
import html
import io

HEAD = """<!doctype html><meta charset=utf-8><title>What differs from the snapshots</title>
<style>
body { font: 15px/1.5 sans-serif; margin: 2em; }
section { border-top: 1px solid #999; }
figure { display: inline-block; margin: 0 1em 1em 0; vertical-align: top; }
img { max-width: 46vw; border: 1px solid #999; }
table.diff { font: 12px monospace; }
.diff_add { background: #cfc; } .diff_sub { background: #fcc; } .diff_chg { background: #ffc; }
</style>
<h1>What differs from the snapshots</h1>
"""


class Report:
    """One HTML file, begun again by the first difference of a run."""

    def __init__(self, path):
        self.path = path
        self.sections = []

    def add_pictures(self, name, fault, old, new, difference):
        """Add three pictures side by side; returns the address of the section."""
        pictures = {"was": old, "is": new} | ({"difference": difference} if difference is not None else {})
        cells = "".join(
            f"<figure><figcaption>{title}</figcaption><img src='data:image/png;base64,{png(image)}'></figure>"
            for title, image in pictures.items()
        )
        return self._add(name, f"<p>{html.escape(fault)}</p>{cells}")

    def add_data(self, name, differences, old, new):
        """Add every difference as a line, and both texts side by side where they differ."""
        lines = "".join(f"<li>{html.escape(line)}</li>" for line in differences[:200])
        table = difflib.HtmlDiff(wrapcolumn=80).make_table(
            old.splitlines(), new.splitlines(), "was", "is", context=True, numlines=1
        )
        return self._add(f"{name}.json", f"<ul>{lines}</ul>{table}")

    def _add(self, name, content):
        self.sections.append(f"<section id='{name}'><h2>{html.escape(name)}</h2>{content}</section>\n")
        self.path.parent.mkdir(exist_ok=True)
        self.path.write_text(HEAD + "".join(self.sections), encoding="utf-8")
        return f"{self.path.parent.parent.name}/{self.path.parent.name}/{self.path.name}#{name}"


def png(image):
    buffer = io.BytesIO()
    image.save(buffer, "PNG")
    return base64.b64encode(buffer.getvalue()).decode()
