"""What the user has set: validated numbers, and their printing in the page's address.

Everything from outside (address, typed text, slider, forged message) passes
through `read`, as text, and is taken whole or not at all. No panel import.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from inspect import signature
from typing import NamedTuple
from urllib.parse import parse_qsl, urlencode

import param
from vibroscope.app.runtime.limits import CostLimitError, check_cost
from vibroscope.engine import Newmark, Reference, System, Units, simulate

# A number as a person writes one. Stricter than float(), which also takes
# "nan", "inf", "1_000", other scripts' digits and any length.
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d{1,4})?", re.ASCII)
_LONGEST_NUMBER = 40
_LONGEST_ADDRESS = 2000


class Refused(ValueError):
    """A value from outside that is not taken; the text is for the user."""

    def __init__(self, name: str, text: str) -> None:
        super().__init__(text)
        self.name = name


class Setting(NamedTuple):
    """One complete, valid setting of the explorer; hashable, so it can key a cache."""

    eta: float
    K: float
    D: float
    steps: int
    located: str
    joint_damping: str
    threshold: float
    restitution: float
    kappa: float
    d1: float
    d2: float
    kappa3: float
    d3: float
    frame: str
    coordinate: str
    units: str
    omega1: float
    m1: float
    amplitude: float

    @property
    def system(self) -> System:
        """The two pendulums."""
        return System(**{name: getattr(self, name) for name in SYSTEM_FIELDS})

    @property
    def reference(self) -> Reference:
        """The solver with the impact law."""
        return Reference(joint_damping=self.joint_damping, threshold=self.threshold)

    @property
    def penalty(self) -> Newmark:
        """The solver that does what an FE code would."""
        return Newmark(self.K, self.D, self.steps, located=self.located == "yes")

    @property
    def scale(self) -> Units | None:
        """What the numbers are shown in; None where they stay without dimension."""
        return Units(self.omega1, self.m1, self.amplitude) if self.units == "physical" else None

    @property
    def period(self) -> float:
        """Length of an excitation period on the axes of time: 1 where time is counted in periods, else seconds."""
        return 1.0 if self.scale is None else self.scale.physical("time", 2 * math.pi / self.eta)


SYSTEM_FIELDS = ("kappa", "d1", "d2", "kappa3", "d3", "restitution")
MAIN_FIELDS = ("eta", "K", "D", "steps")
PAPER_FIELDS = (*SYSTEM_FIELDS, "threshold", "located")  # what a scene of the paper sets to the paper's
# What else an address may hold: the tab that is open, the setting that is pinned, as an address of its own, how the tab
# is seen (`app.explorer.link`), and light or dark where the user has chosen.
VIEW_FIELDS = ("tab", "pin", "zoom", "choice", "mute", "theme")
_PAPER, _UNITS = System(), Units()
_PERIODS = signature(simulate).parameters["periods"].default


class Explorer(param.Parameterized):
    """The sliders and switches, with hard bounds."""

    eta = param.Number(1.08, bounds=(0.5, 4.0), label="η", doc="excitation frequency Ω/ω₁")
    K = param.Number(2500.0, bounds=(10.0, 1e5), label="K", doc="penalty stiffness")
    D = param.Number(8.0, bounds=(0.1, 100.0), label="D", doc="penalty damping")
    steps = param.Integer(2000, bounds=(8, 32_000), label="T/Δτ", doc="time steps per period T")
    located = param.Selector(
        default="no",
        objects=["no", "yes"],
        label="Contact changes",
        doc="Where Newmark's step meets a contact change: at the start of the next step, or located within the step",
    )
    joint_damping = param.Selector(
        default="table",
        objects=["table", "derived"],
        label="Joint damping d₃",
        doc="d₃ of the reference in permanent contact: as measured, or what the two dampers add up to",
    )
    threshold = param.Number(
        0.002, bounds=(0.0, 0.5), label="ε", doc="parting speed that begins permanent contact; 0: the limit"
    )
    restitution = param.Number(_PAPER.restitution, bounds=(0.0, 1.0), label="e", doc="coefficient of restitution")
    kappa = param.Number(_PAPER.kappa, bounds=(1.05, 10.0), label="κ", doc="frequency ratio ω₂/ω₁ of pendulum 2")
    d1 = param.Number(_PAPER.d1, bounds=(0.0, 0.5), label="d₁", doc="damping ratio of pendulum 1")
    d2 = param.Number(_PAPER.d2, bounds=(0.0, 0.5), label="d₂", doc="damping ratio of pendulum 2")
    kappa3 = param.Number(_PAPER.kappa3, bounds=(1.001, 9.999), label="κ₃", doc="frequency ratio of both, joined")
    d3 = param.Number(_PAPER.d3, bounds=(0.0, 0.5), label="d₃", doc="damping ratio of both, joined, as measured")
    frame = param.Selector(
        default="relative",
        objects=["relative", "absolute", "difference"],
        label="Displacements",
        doc="Relative to the base, as a fixed sensor sees them, or what the penalty solution differs by, in parts",
    )
    coordinate = param.Selector(
        default="xi2",
        objects=["xi1", "xi2"],
        label="Map and difference show",
        doc="Coordinate in the small map over η and in the difference",
    )
    units = param.Selector(
        default="none",
        objects=["none", "physical"],
        label="Units",
        doc="Without dimension as in the paper, or in s, mm, N as an FE input file has them; ω₁, m₁ and the amplitude "
        "of the base are set under System and solver",
    )
    omega1 = param.Number(_UNITS.omega1, bounds=(1e-6, 1e9), label="ω₁", doc="angular frequency of pendulum 1, 1/s")
    m1 = param.Number(_UNITS.m1, bounds=(1e-9, 1e12), label="m₁", doc="mass of pendulum 1, kg")
    amplitude = param.Number(_UNITS.base_amplitude, bounds=(1e-9, 1e6), label="A", doc="amplitude of the base, mm")

    def setting(self) -> Setting:
        """A frozen copy of all values."""
        return Setting(**{name: getattr(self, name) for name in Setting._fields})

    def apply(self, texts: Mapping[str, str]) -> None:
        """Take all of ``texts``, or raise `Refused` and take none."""
        self.param.update(**self.check(texts))

    def check(self, texts: Mapping[str, str]) -> dict[str, float | int | str]:
        """The values of ``texts``, if they can all be taken; raises `Refused` otherwise."""
        values = read(texts)
        check_together(self.setting()._replace(**values))
        return values


def check_together(setting: Setting) -> None:
    """Raise `Refused` where values that are valid each for itself make no system together, or cost too much."""
    try:
        check_cost(setting.steps, _PERIODS)
    except CostLimitError as error:
        raise Refused("steps", str(error)) from None
    try:
        _ = setting.system
    except ValueError:
        raise Refused(
            "kappa3",
            f"kappa3 must lie between 1 and kappa = {setting.kappa:g}, not {setting.kappa3:g}: joined pendulums swing "
            "between the frequencies of the separate ones, and the mass ratio follows from it.",
        ) from None


def read(texts: Mapping[str, str]) -> dict[str, float | int | str]:
    """Values for the known names in ``texts``; raises `Refused` at the first bad one."""
    values: dict[str, float | int | str] = {}
    for name, text in texts.items():
        if name in Setting._fields:
            values[name] = _read_one(name, text)
    return values


def _read_one(name: str, text: object) -> float | int | str:
    rule = Explorer.param[name]
    if isinstance(rule, param.Selector):
        return read_choice(name, text, rule.objects)
    return read_number(name, text, rule.bounds, isinstance(rule, param.Integer))


def read_choice(name: str, text: object, choices: list[str]) -> str:
    """The one of ``choices`` that ``text`` gives for ``name``; raises `Refused` if it is none."""
    if not isinstance(text, str) or text not in choices:
        raise Refused(name, f"{name} must be {' or '.join(choices)}, not {quoted(text)}.")
    return text


def read_number(name: str, text: object, bounds: tuple[float, float], whole: bool) -> float | int:
    """The number that ``text`` gives for ``name``; raises `Refused` if it is none or outside ``bounds``."""
    low, high = bounds
    kind = "a whole number" if whole else "a number"
    wanted = f"{name} must be {kind} from {low:g} to {high:g}, not {quoted(text)}."
    if not isinstance(text, str) or len(text) > _LONGEST_NUMBER:
        raise Refused(name, wanted)
    if not _NUMBER.fullmatch(text.strip()):
        raise Refused(name, wanted)
    value = float(text)
    if not (math.isfinite(value) and low <= value <= high) or (whole and value != int(value)):
        raise Refused(name, wanted)
    return int(value) if whole else value


def quoted(text: object) -> str:
    """What was given, short enough to show."""
    shown = text if isinstance(text, str) else type(text).__name__
    printable = "".join(c if c.isprintable() else "�" for c in shown[:30])
    return f"“{printable}{'…' if len(shown) > 30 else ''}”"


def parse_address(query: str) -> dict[str, str]:
    """The known names in an address's query string, as text, each at most once."""
    query = query.removeprefix("?")
    if len(query) > _LONGEST_ADDRESS:
        raise Refused("address", "This address is too long to be one of this page's.")
    texts: dict[str, str] = {}
    for name, text in parse_qsl(query, keep_blank_values=True, errors="replace"):
        if name not in Setting._fields + VIEW_FIELDS:
            continue  # links pick up other pages' parameters on their way
        if name in texts:
            raise Refused(name, f"The address gives {name} twice.")
        texts[name] = text
    return texts


def print_number(value: float | int) -> str:
    """The shortest text that reads back as exactly ``value``."""
    if isinstance(value, float) and value.is_integer() and abs(value) < 1e15:
        return str(int(value))
    return repr(value)


def texts_of(setting: Setting) -> dict[str, str]:
    """Every value as the text that `read` takes back exactly."""
    return {name: value if isinstance(value, str) else print_number(value) for name, value in setting._asdict().items()}


def print_address(setting: Setting, tab: str = "", pin: Setting | None = None, **view: str) -> str:
    """The query string that restores the page; values at their default are left out, but for the four sliders.

    What of the view is not as the page has it by itself comes under its name in `VIEW_FIELDS`, as text.
    """
    texts = texts_of(setting)
    shown = {
        name: text
        for name, text in texts.items()
        if name in MAIN_FIELDS or getattr(setting, name) != Explorer.param[name].default
    }
    view = {"tab": tab, "pin": print_address(pin) if pin else ""} | view
    return urlencode(shown | {name: text for name, text in view.items() if text}, safe=":;,")
