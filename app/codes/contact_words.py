"""One contact in the words of a code, in physical numbers, and in the words of another code.

Between two codes stands a `Contact`: spring K δⁿ and damper c δᵐ v of a law of the engine, in SI units, the penetration
δ > 0 and its rate v. ``assets/codes.toml`` has the words of each code, their quantities and defaults; the formulas are
here, each in both directions, with the reduced mass m of the two bodies and the time step h:

    MuJoCo, solref = (−s, −b):     K = m s, c = m b                                                          (a)
    MuJoCo, solref = (τ, ζ):       s = 1/(τζ)², b = 2/τ, with τ ≥ 2h                                         (b)
    ODE, Bullet:                   erp = hK/(hK + c), cfm = 1/(hK + c);  K = erp/(h cfm), c = (1 − erp)/cfm  (c)
    Drake:                         f = k δ (1 + d v), c = d K;  SAP: c = τ K                                 (d)
    Drake, allowance p:            K = m g/p, d = √(p/g)/p                                                   (e)
    LS-DYNA:                       K = SLSFAC SFS k₀, with SOFT = 1 max(SLSFAC SFS k₀, SOFSCL m*/h²);
                                   c = VDC/100 · 2m*√(K/m), m* of the lighter body                           (f)
    ImpactMaterial:                K₁ = K_e + E/(a δₘ²), K₂ = K_e − E/((1 − a) δₘ²), δ_y = a δₘ, a = 0.1,
                                   K_e = K √δₘ, E = K δₘ^(n+1) (1 − e²)/(n + 1), n = 1.5                     (g)
    COMSOL:                        pressure p = f_p E/h_min per penetration over the area A: K = p A, c = τ K (h)
    Abaqus/Explicit:               the same p, c = 2ζ√(K m)                                                  (i)

(a), (b): MuJoCo documentation, Modeling, "Solver parameters", where the impedance is the one of the width; (c): ODE
manual, "How to use ERP and CFM", and answers.ros.org 15400; (d), (e): Drake, ``contact_model_doxygen.h``; (f): LSTC
FAQ, contact.soft1, where m* = min(m_master_nodes, m_slave_node), and *CONTACT in PyDyna, VDC: 2mω with m =
min(mslave, mmaster), ω = √(k(mslave + mmaster)/(mmaster mslave)); (g): OpenSees wiki, Impact Material; (h): COMSOL,
Contact, and Damping; (i): Abaqus, "Defining viscous contact damping", μ₀√(4m k_c) of the nodal mass m.

What becomes of a law that the other code does not have: :mod:`.translation`.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import NamedTuple

from vibroscope.app.explorer.errors import Refused
from vibroscope.app.explorer.typed import read_typed_number
from vibroscope.app.runtime.number_text import TYPED_UNITS, sizes
from vibroscope.engine import QUANTITIES, Units, damping_of_restitution, restitution_of_damping, written
from vibroscope.engine.arguments import one_of, require
from vibroscope.engine.contact import ContactUnits
from vibroscope.engine.law_table import HERTZ, LAWS, deepest_penetration
from vibroscope.engine.methods import EXPONENT_RANGE

_GRAVITY = 9.81  # m/s², as Drake's
_SHARE = 0.1  # a of ImpactMaterial
_DIGITS = 6
_ROUNDED = 1e-3  # relative, of a typed mass
_POSITIVE = (1e-12, 1e20)
_BOUNDS = {
    "stiffness": (0.0, 1e20),
    "contact_damping": (0.0, 1e20),
    "time": (0.0, 1e20),
    "number": _POSITIVE,
    "switch": (0.0, 9.0),  # a digit on a card
    "share": (1e-12, 1.0),
    "restitution": (1e-6, 1.0),
    "exponent": EXPONENT_RANGE,
    "percent": (0.0, 1e6),
    "damping_ratio": (0.0, 1e4),
    "damping_per_area": (0.0, 1e20),
    "s/m": (0.0, 1e20),
}
_SI_UNITS = {  # of a quantity over the contact area, which the model does not have
    "stiffness_per_area": "N/m³",
    "damping_per_area": "N·s/m³",
    "pressure": "N/m²",
}
_ROLES = {  # of a word: what of the contact it is
    "contact_stiffness": "stiffness",
    "contact_damping": "damping",
    "exponent": "exponent",
    "displacement": "penetration",
    "restitution": "restitution",
}
_READ = ("stiffness", "damping", "restitution")  # what other words are read as
NEEDED = {  # beside the words: quantity, meaning, and how to give it
    "mass": ("mass", "reduced mass of the two bodies, m₁m₂/(m₁ + m₂)", "1 kg"),
    "lighter": ("mass", "mass of the lighter body (by default the reduced mass: the other is a wall)", "1 kg"),
    "step": ("time", "time step", "1 ms"),
    "speed": ("velocity", "closing speed", "1 m/s"),
    "area": ("area", "contact area", "120 mm²"),
}


@dataclass(frozen=True)
class Around:
    """What a translation needs beside the words, in SI units; None where it is not given."""

    mass: float | None = None
    lighter: float | None = None
    step: float | None = None
    speed: float | None = None
    area: float | None = None

    def need(self, name: str) -> float:
        """One of them; raises `Missing` where it is not given, ValueError where it is out of range."""
        _, meaning, example = NEEDED[name]
        if getattr(self, name) is None:
            raise Missing(f"the {meaning} is needed: give it, such as --{name} '{example}'")
        return require(name, getattr(self, name), *_POSITIVE, f"give the {meaning}, as '{example}'")

    @property
    def masses(self) -> tuple[float, float]:
        """The reduced mass m, and that of the lighter body, m to 2m; raises `Missing` without the first."""
        mass = self.need("mass")
        if self.lighter is None:
            return mass, mass
        low, high = mass * (1.0 - _ROUNDED), 2.0 * mass * (1.0 + _ROUNDED)
        return mass, require("lighter", self.lighter, low, high, "give one to two times the reduced mass")


class Missing(ValueError):
    """A translation needs a number that is not given."""


@dataclass(frozen=True)
class Contact:
    """A contact in SI units.

    Attributes
    ----------
    law : str
        One of :data:`engine.CONTACT_LAWS`.
    stiffness : float
        K in N/mⁿ.
    damping : float or None
        c in N·s/m, times a power of the penetration in laws where that multiplies the damper; None where it is to
        follow from the restitution.
    exponent : float
        n.
    penetration : float or None
        Of IMPACT: in m, from where on the damper acts in full.
    restitution : float or None
        Where the words give it.
    """

    law: str
    stiffness: float
    damping: float | None = None
    exponent: float = 1.0
    penetration: float | None = None
    restitution: float | None = None

    def __post_init__(self) -> None:
        require("stiffness", self.stiffness, 0.0, 1e30, "give words whose contact has a spring", open_low=True)

    def restitution_at(self, around: Around) -> float:
        """The restitution at the closing speed; raises `Missing` where that, or the mass, is needed and not given."""
        if self.restitution is not None:
            return self.restitution
        unit, numbers = self._scaled(around)
        return restitution_of_damping(self.law, 0.5 * self.damping / unit, 1.0, **numbers)

    def with_restitution(self, e: float, around: Around) -> "Contact":
        """The same with the damper that gives a restitution; raises ValueError where none does."""
        unit, numbers = self._scaled(around)
        damping = (
            2.0 * unit * damping_of_restitution(self.law, min(e, 1.0), 1.0, **numbers)
        )  # rounding makes it 1 + 1e-13
        return replace(self, damping=damping, restitution=None)

    def _scaled(self, around: Around) -> tuple[float, dict[str, float]]:
        """The unit of D for which mass, K and closing speed are 1, and the numbers of the law in such units."""
        mass, own = around.need("mass"), LAWS[self.law]
        speed = 1.0 if own.restitution else around.need("speed")
        units = ContactUnits(mass, speed, self.stiffness, self.exponent)
        numbers = {"exponent": self.exponent} if own.takes_exponent else {}
        if own.penetration:
            numbers["penetration"] = self.penetration / units.length
        return units.damping(self.law, self.exponent), numbers

    def texts(self) -> dict[str, str]:
        """Its numbers with units, by their names."""
        units = _units("si", self.law, self.exponent)
        found = {"K": f"{written(self.stiffness, _DIGITS)} {units.unit('contact_stiffness')}"}
        if self.damping is not None:
            found["c"] = f"{written(self.damping, _DIGITS)} {units.unit('contact_damping')}"
        if self.exponent != 1.0:
            found["exponent"] = written(self.exponent)
        if self.penetration is not None:
            found["full damping from"] = f"{written(1e3 * self.penetration)} mm"
        return found


Values = tuple[float | tuple[float, ...], ...]  # of the words of a form, in their order and in SI units


class Formulas(NamedTuple):
    """Both directions: from values to K, c and, where the words are made from it, the restitution; and back.

    Values are written for the last words of a form, if they are fewer; None: there is no way back.
    """

    read: Callable[[Values, Around], tuple[float | None, ...]]
    write: Callable[[Contact, Around], Values] | None = None


@dataclass(frozen=True)
class Form:
    """Words of a code that together say one contact, as ``[[code.contact]]`` in ``assets/codes.toml``.

    Attributes
    ----------
    words : mapping of str to str
        The quantity of each word, or the unit of a number that is in SI units; "numbers": several, in SI units.
    law : str
    text : str
        Its input, with the words in braces.
    formulas : str
        A key of `FORMULAS`; "direct": each word is a part of the contact, as its quantity says.
    defaults : mapping of str to str
    units : str
        System of units of plain numbers.
    exponent : float
        n, where no word is it.
    """

    words: Mapping[str, str]
    law: str
    text: str
    formulas: str = "direct"
    defaults: Mapping[str, str] = field(default_factory=dict)
    units: str = "si"
    exponent: float = 1.0

    def __post_init__(self) -> None:
        one_of("law", self.law, tuple(LAWS))
        one_of("formulas", self.formulas, ("direct", *FORMULAS))

    @property
    def writable(self) -> bool:
        """Whether there is a way back from a contact to its words."""
        return self.formulas == "direct" or FORMULAS[self.formulas].write is not None

    def word_of(self, role: str) -> str | None:
        """The word that is stiffness, damping, exponent, penetration or restitution; None if none is."""
        return next((word for word, quantity in self.words.items() if _ROLES.get(quantity) == role), None)

    @property
    def says_restitution(self) -> bool:
        """Whether its words are made from a restitution, not from a damper."""
        return self.formulas == "bilinear" or self.word_of("restitution") is not None

    def read(self, given: Mapping[str, str], around: Around) -> Contact:
        """The contact that texts of words say; a word that is left out has its default."""
        texts = {word: self._unsigned(word, text) for word, text in {**self.defaults, **given}.items()}
        if missing := [word for word in self.words if word not in texts]:
            raise Missing(f"{missing[0]} is missing: give {' '.join(f'{word}=...' for word in self.words)}")
        power = self.word_of("exponent")
        exponent = _number(power, texts[power], "exponent", self, 1.0) if power else self.exponent
        values = tuple(_number(word, texts[word], of, self, exponent) for word, of in self.words.items())
        if self.formulas == "direct":
            found = dict(zip(map(_ROLES.get, self.words.values()), values, strict=True))
        else:
            found = dict(zip(_READ, FORMULAS[self.formulas].read(values, around), strict=False))
        return Contact(self.law, **{"exponent": exponent} | found)

    def _unsigned(self, word: str, text: str) -> str:
        """The text of a word without the minus that the code's input has before it."""
        return text.strip().removeprefix("-") if f"-{{{word}}}" in self.text else text

    def default_of(self, role: str) -> float | None:
        """The default of the word that is a part of the contact, in SI units; None where there is none."""
        word = self.word_of(role)
        return None if word not in self.defaults else _number(word, self.defaults[word], self.words[word], self, 1.0)

    def write(self, contact: Contact, around: Around) -> dict[str, str]:
        """The words of a contact of its own law, as texts."""
        if self.formulas == "direct":
            values = tuple(getattr(contact, _ROLES[quantity]) for quantity in self.words.values())
        else:
            values = FORMULAS[self.formulas].write(contact, around)
        names = list(self.words)[-len(values) :]
        return {word: self._text(word, value, contact) for word, value in zip(names, values, strict=True)}

    def _text(self, word: str, value: float | tuple[float, ...], contact: Contact) -> str:
        if isinstance(value, tuple):
            return " ".join(written(each, _DIGITS) for each in value)
        return written(value / _one(self.words[word], self, contact.exponent)[0], _DIGITS)

    def unit(self, word: str, contact: Contact) -> str:
        """The unit in which a word is written; empty where it has none."""
        return _one(self.words[word], self, contact.exponent)[1]


def _units(system: str, law: str, exponent: float) -> Units:
    """Units in which a number of the model is one in SI units."""
    return Units(1.0, 1.0, 1e3, system, law, exponent)


def _one(quantity: str, form: Form, exponent: float) -> tuple[float, str]:
    """What one of a word is in SI units, and the unit's name."""
    if quantity not in QUANTITIES:
        return 1.0, _SI_UNITS.get(quantity, quantity if "/" in quantity else "")
    units = _units(form.units, form.law, exponent)
    return units.quantity(quantity).convention / units.factor(quantity), units.unit(quantity)


def _number(word: str, text: str, quantity: str, form: Form, exponent: float) -> float | tuple[float, ...]:
    """A typed word in SI units; raises ValueError, naming the word, what is typed, the range and the units."""
    if quantity == "numbers":
        try:
            return tuple(float(part) for part in text.replace(",", " ").split())
        except ValueError:
            raise ValueError(f"{word} = {text!r} is no list of numbers: give them with blanks between") from None
    size, unit = _one(quantity, form, exponent)
    power = exponent - 1.0 if quantity == "contact_stiffness" else 0.0
    units = {unit.replace("·", ""): 1.0, "": 1.0} | (TYPED_UNITS.get(quantity, {}) and sizes(quantity, size, power))
    if power:  # many write N/mm for N/mm^n
        units |= {known.partition("^")[0]: worth for known, worth in units.items()}
    low, high = _BOUNDS.get(quantity, _POSITIVE)
    try:
        found = read_typed_number(word, text, (low / size, high / size), units={**units, "": 1.0}, shown=unit)
    except Refused as error:
        raise ValueError(str(error)) from None
    return size * float(found)


# --- formulas ---------------------------------------------------------------------------------------------------------


def _solref_in(values: Values, around: Around) -> tuple[float, float]:  # (a), (b)
    (solref,), mass = values, around.need("mass")
    if len(solref) != 2 or not (max(solref) <= 0.0 > solref[0] or min(solref) > 0.0):
        raise ValueError(
            f"solref = {' '.join(map(written, solref))} is not a pair of one sign: give '-stiffness -damping', "
            "such as '-1000 -10', or 'timeconst dampratio', such as '0.02 1'"
        )
    if solref[0] < 0.0:
        return -mass * solref[0], -mass * solref[1]
    constant = max(solref[0], 2.0 * (around.step or 0.0))
    return mass / (constant * solref[1]) ** 2, 2.0 * mass / constant


def _solref_out(contact: Contact, around: Around) -> Values:
    mass = around.need("mass")
    return ((-contact.stiffness / mass, -contact.damping / mass),)


def _erp_in(values: Values, around: Around) -> tuple[float, float]:  # (c)
    erp, cfm = values
    return erp / (cfm * around.need("step")), (1.0 - erp) / cfm


def _erp_out(contact: Contact, around: Around) -> Values:
    spring = around.need("step") * contact.stiffness
    return spring / (spring + contact.damping), 1.0 / (spring + contact.damping)


def _allowance_in(values: Values, around: Around) -> tuple[float, float]:  # (e)
    stiffness = around.need("mass") * _GRAVITY / values[0]
    return stiffness, stiffness / math.sqrt(_GRAVITY * values[0])


def _standard_in(values: Values, around: Around) -> tuple[float, float]:  # (f)
    k0, factor, of_surface, percent = values
    return _with_share_of_critical(factor * of_surface * k0, percent, around)


def _soft_in(values: Values, around: Around) -> tuple[float, float]:  # (f)
    k0, factor, of_surface, soft, of_step, percent = values
    if soft not in (0.0, 1.0):
        raise ValueError(f"SOFT = {written(soft)} has a stiffness that is not known here: give SOFT=0 or SOFT=1")
    stiffness = factor * of_surface * k0
    if soft:
        stiffness = max(stiffness, of_step * around.masses[1] / around.need("step") ** 2)
    return _with_share_of_critical(stiffness, percent, around)


def _with_share_of_critical(stiffness: float, percent: float, around: Around) -> tuple[float, float]:
    mass, lighter = around.masses if percent else (1.0, 1.0)
    return stiffness, 0.02 * percent * lighter * math.sqrt(stiffness / mass)


def _soft_out(contact: Contact, around: Around) -> Values:
    mass, lighter = around.masses
    critical = 2.0 * lighter * math.sqrt(contact.stiffness / mass)
    return 1.0, contact.stiffness * around.need("step") ** 2 / lighter, 100.0 * contact.damping / critical


def _bilinear_in(values: Values, around: Around) -> tuple[float, None, float]:  # (g)
    first, second, bend = values
    mean = _SHARE * first + (1.0 - _SHARE) * second
    lost = (HERTZ + 1.0) * _SHARE * (first - mean) / mean  # 1 − e²
    if not 0.0 <= lost <= 1.0 + 10.0 ** (2 - _DIGITS):  # of words that were written for e = 0
        raise ValueError(
            f"K1 = {written(first)} and K2 = {written(second)} N/m are no approximation of a Hertz contact, which has "
            "a restitution of 0 to 1: give a K1 at or a little above K2"
        )
    known = None not in (around.mass, around.speed)
    if known and first * bend**2 >= (twice := around.need("mass") * around.need("speed") ** 2):  # δ_y is not reached
        return 0.5 * (HERTZ + 1.0) * twice / math.sqrt(twice / first) ** (HERTZ + 1.0), None, 1.0
    e = _bilinear_restitution(first, second, bend, around) if known else math.sqrt(max(0.0, 1.0 - lost))
    return mean / (bend / _SHARE) ** (HERTZ - 1.0), None, e


def _bilinear_restitution(first: float, second: float, bend: float, around: Around) -> float:
    """What ImpactMaterial gives: it loads along K₁ up to δ_y, then K₂, and unloads K₁ − K₂ times δ_y lower.

    Not the e of (g): at its deepest penetration its spring holds another energy than that of Hertz.
    """
    energy = 0.5 * around.need("mass") * around.need("speed") ** 2
    beyond = 2.0 * energy - first * bend**2  # K₂s² + 2K₁δ_y s, s beyond δ_y
    root = math.hypot(first * bend, math.sqrt(second * beyond))
    return math.sqrt(max(0.0, 1.0 - (first - second) * bend * beyond / (root + first * bend) / energy))


def _bilinear_out(contact: Contact, around: Around) -> Values:
    deepest = deepest_penetration(contact.stiffness, around.need("mass"), around.need("speed"), HERTZ)
    mean = contact.stiffness * deepest ** (HERTZ - 1.0)
    lost = mean * (1.0 - contact.restitution_at(around) ** 2) / (HERTZ + 1.0)  # E/δₘ²
    return mean + lost / _SHARE, mean - lost / (1.0 - _SHARE), _SHARE * deepest


def _scaled_by(area: bool, share: bool) -> Formulas:
    """Words that are K and c, each over the contact area, or the second as a share of the first: (d), (h)."""

    def read(values: Values, around: Around) -> tuple[float, float]:
        size = around.need("area") if area else 1.0
        return values[0] * size, values[1] * values[0] * size if share else values[1] * size

    def write(contact: Contact, around: Around) -> Values:
        size = around.need("area") if area else 1.0
        return contact.stiffness / size, contact.damping / (contact.stiffness if share else size)

    return Formulas(read, write)


def _fraction_in(values: Values, around: Around) -> tuple[float, float]:  # (i)
    stiffness = values[0] * around.need("area")
    return stiffness, 2.0 * values[1] * math.sqrt(stiffness * around.need("mass"))


def _fraction_out(contact: Contact, around: Around) -> Values:
    critical = 2.0 * math.sqrt(contact.stiffness * around.need("mass"))
    return contact.stiffness / around.need("area"), contact.damping / critical


_PRESSURE = _scaled_by(area=True, share=True)
FORMULAS = {
    "solref": Formulas(_solref_in, _solref_out),
    "erp-cfm": Formulas(_erp_in, _erp_out),
    "share": _scaled_by(area=False, share=True),
    "allowance": Formulas(_allowance_in),
    "standard-penalty": Formulas(_standard_in),
    "soft": Formulas(_soft_in, _soft_out),
    "bilinear": Formulas(_bilinear_in, _bilinear_out),
    "per-area": _scaled_by(area=True, share=False),
    "fraction": Formulas(_fraction_in, _fraction_out),
    "pressure": _PRESSURE,
    "penalty-factor": Formulas(lambda v, around: _PRESSURE.read((v[0] * v[1] / v[2], v[3]), around)),
}
