"""The paper's motions and parameter sets, and our examples, read from ``assets/scenes.toml``."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from functools import cache

from vibroscope.app.explorer.state import MAIN_FIELDS, PAPER_FIELDS, Explorer, Setting, print_number, read, texts_of
from vibroscope.app.runtime.files import asset


@dataclass(frozen=True)
class Scene:
    """One button: where it comes from and the four numbers it sets; system and solver are the paper's."""

    key: str
    group: str
    label: str
    tooltip: str
    eta: float
    K: float
    D: float
    steps: int

    def texts(self) -> dict[str, str]:
        """The four numbers, and the paper's for all others, as `app.explorer.state.read` takes them."""
        usual = texts_of(Explorer().setting())
        return {name: print_number(getattr(self, name)) for name in MAIN_FIELDS} | {n: usual[n] for n in PAPER_FIELDS}

    def matches(self, setting: Setting) -> bool:
        """Whether ``setting`` has this scene's numbers."""
        return all(getattr(self, name) == getattr(setting, name) for name in MAIN_FIELDS) and all(
            getattr(setting, name) == Explorer.param[name].default for name in PAPER_FIELDS
        )


@cache
def scenes() -> dict[str, Scene]:
    """All scenes by key, in the file's order; bad numbers in the file raise at once."""
    found: dict[str, Scene] = {}
    for row in tomllib.loads(asset("scenes.toml"))["scene"]:
        numbers = read({name: str(row[name]) for name in MAIN_FIELDS})
        scene = Scene(row["key"], row["group"], row["label"], row["tooltip"], **numbers)
        if scene.key in found:
            raise ValueError(f"scenes.toml has two scenes named {scene.key}")
        found[scene.key] = scene
    return found


def scene_of(setting: Setting) -> str:
    """Key of the scene that ``setting`` shows, or an empty string."""
    return next((key for key, scene in scenes().items() if scene.matches(setting)), "")
