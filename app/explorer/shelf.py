"""Published systems beside the scenes of the paper, read from ``assets/validation/shelf.toml``. No panel import."""

import tomllib
from dataclasses import dataclass
from functools import cache

from vibroscope.app.explorer.parameters import FORM_FIELDS, MAIN_FIELDS, PAPER_FIELDS, START_FIELDS
from vibroscope.app.explorer.physical_fields import values_of_system
from vibroscope.app.explorer.reading import read_setting_at_any_cost
from vibroscope.app.explorer.state import Setting
from vibroscope.app.runtime.files import asset
from vibroscope.app.runtime.number_text import print_value
from vibroscope.engine.physical import system_of_physical

_SET = (*MAIN_FIELDS, *PAPER_FIELDS, "joint_damping")  # what a button sets, beside the units


@dataclass(frozen=True)
class ShelfSystem:
    """A button of the shelf: a published system, and a contact to begin with.

    Attributes
    ----------
    key, title : str
    question : str
        What the system answers.
    source, note : str
        Where its numbers were published, and what is assumed.
    setting : Setting
        What the button sets, with units on.
    """

    key: str
    title: str
    question: str
    source: str
    note: str
    setting: Setting

    @property
    def caption(self) -> str:
        """The question that the system answers."""
        return self.question

    @property
    def origin(self) -> str:
        """The source of the numbers, and the assumptions."""
        return f"{self.source.rstrip('.')}. {self.note}".strip()

    def texts(self) -> dict[str, str]:
        """The texts that the button sets, for `app.explorer.reading.read_setting`."""
        every = self.setting.texts()
        return {name: every[name] for name in (*_SET, *_UNIT_FIELDS, "coordinate")}

    def matches(self, setting: Setting) -> bool:
        """Whether ``setting`` has this system and its numbers."""
        return all(getattr(setting, name) == getattr(self.setting, name) for name in _SET)

    def button(self) -> dict[str, str]:
        """How the page shows it."""
        return {
            "key": self.key,
            "title": self.title,
            "figure": self.question,
            "tooltip": self.origin,
        }


_UNIT_FIELDS = ("units", *FORM_FIELDS, "omega1", "m1", "amplitude")


@cache
def shelf() -> dict[str, ShelfSystem]:
    """All systems of the shelf by key, in the order of the file."""
    return read_shelf(asset("validation/shelf.toml"))


def read_shelf(text: str) -> dict[str, ShelfSystem]:
    """The systems of a file, by key; a bad number raises ValueError."""
    rows = tomllib.loads(text)["system"]
    found = {row["key"]: _read(row) for row in rows}
    if len(found) < len(rows):
        raise ValueError("shelf.toml has two systems with one key")
    return found


def _read(row: dict) -> ShelfSystem:
    system, units, eta, forms = system_of_physical(row["physical"])
    texts = {name: row.get(name, "") for name in ("key", "title", "question", "source", "note")}
    values = values_of_system(system, units, eta, forms) | {"units": "si", "steps": row["steps"]}
    values["K"] = units.model("contact_stiffness", row["contact_stiffness_N_per_m"])
    values["D"] = units.model("contact_damping", row["contact_damping_Ns_per_m"])
    start = zip(START_FIELDS, ("displacement", "velocity") * 2, row.get("start_SI", ()), strict=False)
    values |= {name: units.model(quantity, value) for name, quantity, value in start}
    values = {name: float(f"{value:.15g}") if isinstance(value, float) else value for name, value in values.items()}
    written = {name: print_value(value) for name, value in values.items()}
    return ShelfSystem(**texts, setting=read_setting_at_any_cost(written))


def shelf_key(setting: Setting) -> str:
    """Key of the system of the shelf that ``setting`` has, with a contact as there; empty if it has none."""
    return next((each.key for each in shelf().values() if each.matches(setting)), "")
