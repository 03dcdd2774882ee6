"""Where the files beside the code lie: scenes, style sheet, cached diagram."""

from __future__ import annotations

from pathlib import Path

ASSETS = Path(__file__).resolve().parent.parent / "assets"


def asset(name: str) -> str:
    """The text of one file in ``assets``."""
    return (ASSETS / name).read_text(encoding="utf-8")
