"""Settings that a button sets. No panel import.

Scenes, from ``assets/scenes.toml``: the paper's motions and parameter sets, and examples of our own. The page opens
with one of them. The defaults of `Setting` are another one, and stay: a link leaves them out. The shelf, from
``assets/validation/shelf.toml``: published systems, each with a contact to begin with.
"""

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache

from vibroscope.app.explorer.parameters import FORM_FIELDS, MAIN_FIELDS, PAPER_FIELDS, START_FIELDS
from vibroscope.app.explorer.physical_fields import values_of_system
from vibroscope.app.explorer.reading import read_setting_at_any_cost, read_values
from vibroscope.app.explorer.state import Setting
from vibroscope.app.runtime.files import asset
from vibroscope.app.runtime.number_text import print_value
from vibroscope.engine.physical import system_of_physical

OPENING = "9B"
_OF_SCENE = (*MAIN_FIELDS, *PAPER_FIELDS)  # by which one is recognised: of its setting the last are the paper's
_OF_SYSTEM = (*_OF_SCENE, "joint_damping")
_SHOWN = ("units", *FORM_FIELDS, "omega1", "m1", "amplitude", "coordinate")  # what a published system sets beside them


@dataclass(frozen=True)
class Preset:
    """A button, and the setting that it sets.

    Attributes
    ----------
    key : str
    title : str
        What it shows, in a few words.
    caption : str
        What to see in it, in a sentence that begins with the picture; of a published system the question it answers.
    figure : str
        Below its title: the figure of the paper and the case in it, or the question.
    tooltip : str
        What is said at the pointer; of a published system where its numbers come from, and what is assumed.
    setting : Setting
    decides : tuple of str
        Names of the fields by which it is recognised.
    shows : tuple of str
        Names of the others that it sets.
    group, label : str
        Of a scene, the figure of the paper and the case in it; one of the paper's four motions has the group "motion".
    look : str
        Name of the figure that the caption begins with; the page marks it.
    first : bool
        Whether its button stands before those of "More scenes".
    """

    key: str
    title: str
    caption: str
    figure: str
    tooltip: str
    setting: Setting
    decides: tuple[str, ...] = _OF_SCENE
    shows: tuple[str, ...] = ()
    group: str = ""
    label: str = ""
    look: str = ""
    first: bool = False

    def texts(self) -> dict[str, str]:
        """The texts that the button sets, for `app.explorer.reading.read_setting`."""
        every = self.setting.texts()
        return {name: every[name] for name in (*self.decides, *self.shows)}

    def matches(self, setting: Setting) -> bool:
        """Whether ``setting`` has its numbers."""
        return all(getattr(setting, name) == getattr(self.setting, name) for name in self.decides)

    def button(self) -> dict[str, str | bool]:
        """How the page shows it."""
        return {name: getattr(self, name) for name in ("key", "title", "figure", "tooltip", "first")}


@cache
def scenes() -> dict[str, Preset]:
    """All scenes by key, in the order of the file; a bad number in the file raises `Refused`."""
    return _by_key([_scene(**row) for row in tomllib.loads(asset("scenes.toml"))["scene"]])


def _scene(key: str, group: str, label: str, tooltip: str, caption: str, **row) -> Preset:
    setting = Setting(**read_values({name: str(row.pop(name)) for name in MAIN_FIELDS}))
    figure = f"motion {label}, η = {setting.eta:.2f}" if group == "motion" else f"{group} {label}"
    texts = {"figure": figure, "tooltip": f"{caption} {tooltip}", "caption": caption, "group": group, "label": label}
    return Preset(key, setting=setting, **texts, **row)


@cache
def shelf() -> dict[str, Preset]:
    """All systems of the shelf by key, in the order of the file."""
    return read_shelf(asset("validation/shelf.toml"))


def read_shelf(text: str) -> dict[str, Preset]:
    """The systems of a file, by key; a bad number raises ValueError."""
    return _by_key(list(map(_published, tomllib.loads(text)["system"])))


def _published(row: Mapping) -> Preset:
    system, units, eta, forms = system_of_physical(row["physical"])
    values = values_of_system(system, units, eta, forms) | {"units": "si", "steps": row["steps"]}
    values["K"] = units.model("contact_stiffness", row["contact_stiffness_N_per_m"])
    values["D"] = units.model("contact_damping", row["contact_damping_Ns_per_m"])
    start = zip(START_FIELDS, ("displacement", "velocity") * 2, row.get("start_SI", ()), strict=False)
    values |= {name: units.model(quantity, value) for name, quantity, value in start}
    values = {name: float(f"{value:.15g}") if isinstance(value, float) else value for name, value in values.items()}
    setting = read_setting_at_any_cost({name: print_value(value) for name, value in values.items()})
    origin, asked = f"{row['source'].rstrip('.')}. {row.get('note', '')}".strip(), row["question"]
    return Preset(row["key"], row["title"], asked, asked, origin, setting, _OF_SYSTEM, _SHOWN)


def presets() -> dict[str, Preset]:
    """Scenes and shelf."""
    return scenes() | shelf()


def _by_key(rows: list[Preset]) -> dict[str, Preset]:
    found = {each.key: each for each in rows}
    if len(found) < len(rows):
        raise ValueError("a file has two presets with one key")
    return found


def opening_setting() -> Setting:
    """The setting of the page where the address gives none."""
    return scenes()[OPENING].setting


def buttons() -> list[Preset]:
    """The scenes that have a button: of those with equal numbers the first."""
    found: dict[Setting, Preset] = {}
    for scene in scenes().values():
        found.setdefault(scene.setting, scene)
    return list(found.values())


def preset_of(setting: Setting) -> Preset | None:
    """The first scene or, with a contact as there, system of the shelf that a setting matches; None if it is none."""
    return next((each for each in presets().values() if each.matches(setting)), None)
