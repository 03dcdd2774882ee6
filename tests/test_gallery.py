"""The gallery without a server: a page has the verdict, its figures and the commands, and asks no other host."""

import re
import subprocess
import sys
from pathlib import Path

from vibroscope.app.explorer.presets import shelf

ROOT = Path(__file__).parents[1]


def test_a_report_of_a_published_system(tmp_path):
    call = [sys.executable, "docs/static_gallery.py", "--out", str(tmp_path), "wall"]
    done = subprocess.run(call, cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    text = (tmp_path / "wall.html").read_text()
    assert shelf()["wall"].title in text
    assert text.count("<svg") == 2
    assert "data-figure" not in text
    assert "vibroscope compare" in text
    assert "Parts of the difference" in text
    assert not re.findall(r'(?:src|href)="https?:', text)
    index = (tmp_path / "index.html").read_text()
    assert f'<a href="wall.html">{shelf()["wall"].title}</a>: {shelf()["wall"].caption}' in index
    for each in (text, index):  # readable on a phone and in the dark
        assert '<meta name="viewport"' in each
        assert "prefers-color-scheme: dark" in each
