"""The paper's motions and parameter sets, and examples of our own, read from ``assets/scenes.toml``.

The page opens with one of them. The defaults of `Setting` are another one, and stay: a link leaves them out.
"""

import tomllib
from dataclasses import dataclass
from functools import cache

from vibroscope.app.explorer.parameters import MAIN_FIELDS, PAPER_FIELDS
from vibroscope.app.explorer.reading import read_values
from vibroscope.app.explorer.state import Setting
from vibroscope.app.runtime.files import asset
from vibroscope.app.runtime.number_text import print_number

OPENING = "9B"


@dataclass(frozen=True)
class Scene:
    """A button, and the four numbers that it sets; system and solver are the paper's.

    Attributes
    ----------
    key : str
    group, label : str
        The figure of the paper and the case in it; one of the paper's four motions has the group "motion".
    title : str
        What the scene shows, in a few words.
    caption : str
        What to see in it, in a sentence that begins with the picture.
    look : str
        Name of that figure; the page marks it.
    tooltip : str
        Its numbers and where they come from.
    first : bool
        Whether its button stands before those of "More scenes".
    """

    key: str
    group: str
    label: str
    title: str
    caption: str
    look: str
    tooltip: str
    first: bool
    eta: float
    K: float
    D: float
    steps: int

    def texts(self) -> dict[str, str]:
        """The four numbers and the paper's values of `PAPER_FIELDS`, for `app.explorer.reading.read_setting`."""
        default = Setting().texts()
        return {name: print_number(getattr(self, name)) for name in MAIN_FIELDS} | {n: default[n] for n in PAPER_FIELDS}

    def matches(self, setting: Setting) -> bool:
        """Whether ``setting`` has this scene's numbers."""
        default = Setting()
        return all(getattr(self, name) == getattr(setting, name) for name in MAIN_FIELDS) and all(
            getattr(setting, name) == getattr(default, name) for name in PAPER_FIELDS
        )


@cache
def scenes() -> dict[str, Scene]:
    """All scenes by key, in the order of the file; a bad number in the file raises `Refused`."""
    found: dict[str, Scene] = {}
    for row in tomllib.loads(asset("scenes.toml"))["scene"]:
        numbers = read_values({name: str(row[name]) for name in MAIN_FIELDS})
        texts = {name: row[name] for name in ("key", "group", "label", "title", "caption", "look", "tooltip")}
        scene = Scene(**texts, first=row.get("first", False), **numbers)
        if scene.key in found:
            raise ValueError(f"scenes.toml has two scenes named {scene.key}")
        found[scene.key] = scene
    return found


def opening_setting() -> Setting:
    """The setting of the page where the address gives none."""
    return Setting(**{name: getattr(scenes()[OPENING], name) for name in MAIN_FIELDS})


def buttons() -> list[Scene]:
    """The scenes that have a button: of those with equal numbers the first."""
    found: dict[tuple, Scene] = {}
    for scene in scenes().values():
        found.setdefault(tuple(getattr(scene, name) for name in MAIN_FIELDS), scene)
    return list(found.values())


def scene_key(setting: Setting) -> str:
    """Key of the first scene that ``setting`` matches, or an empty string."""
    return next((key for key, scene in scenes().items() if scene.matches(setting)), "")
