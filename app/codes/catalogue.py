"""The tables of codes and of materials, read from ``assets/codes.toml`` and ``assets/materials.toml``, and validated.

What no source says of a code is empty: ours then takes its default. Materials are for the stiffness of Hertz' contact.
"""

import math
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from functools import cache
from types import MappingProxyType

from vibroscope.app.codes.contact_words import Form
from vibroscope.app.explorer.method_words import scheme_texts
from vibroscope.app.runtime.files import asset
from vibroscope.engine import (
    CONTACT_LAWS,
    CONTACT_STATUSES,
    INITIAL_ACCELERATIONS,
    INTEGRATORS,
    WITHOUT_SOLUTION,
    Integrator,
    Material,
    NewmarkBeta,
    TimeStepping,
    Units,
    effective_restitution,
    written,
)
from vibroscope.engine.arguments import one_of
from vibroscope.engine.contact import contact_frequency, damping_ratio
from vibroscope.engine.law_table import numbers_of
from vibroscope.engine.model import System, check_eta


@cache
def materials() -> dict[str, Material]:
    """Elastic constants by the name of the material, each with its source."""
    rows = tomllib.loads(asset("materials.toml"))
    return {name: Material(row["E_GPa"] * 1e9, row["nu"], row["title"], row["source"]) for name, row in rows.items()}


_PENETRATION = 0.01  # of full damping where no source says one, in units of length
_DIGITS = 6  # of a number in an input


@dataclass(frozen=True)
class Source:
    """The source of a number in the table; without ``url`` the source is not public, or was not checked."""

    figure: str
    text: str
    url: str = ""


@dataclass(frozen=True)
class Code:
    """A simulation code: its default choices, with the source of each.

    Attributes
    ----------
    key, name : str
    integrator, status, without_solution, law, initial_acceleration : str
        As in `engine.TimeStepping`; empty where no source says.
    damper : str
        "restitution" where the law takes its damper from that, else empty.
    numbers : mapping of str to float
        Of the integrator.
    exponent, penetration : float or None
        Of the law.
    rules : tuple of str
        Keys of the rules of thumb that belong to it.
    leaves_out : str
        What ours does not have.
    alone : tuple of str
        What of its words for a contact it alone has.
    input : tuple of str
        Lines of its input, with the names of `input_numbers` in braces.
    integrators : mapping of str to tuple of str
        Lines for each integrator that it has.
    contact : tuple of Form
        Its words for one contact, in each way in which it says that.
    sources : tuple of Source
    """

    key: str
    name: str
    integrator: str = ""
    numbers: Mapping[str, float] = field(default_factory=dict)
    status: str = ""
    without_solution: str = ""
    law: str = ""
    exponent: float | None = None
    penetration: float | None = None
    initial_acceleration: str = ""
    damper: str = ""
    rules: tuple[str, ...] = ()
    leaves_out: str = ""
    alone: tuple[str, ...] = ()
    input: tuple[str, ...] = ()
    integrators: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    contact: tuple[Form, ...] = ()
    sources: tuple[Source, ...] = ()

    def __post_init__(self) -> None:
        if self.integrator:
            INTEGRATORS[one_of("integrator", self.integrator, tuple(INTEGRATORS))](**self.numbers)
        for name, allowed in (
            ("status", CONTACT_STATUSES),
            ("without_solution", WITHOUT_SOLUTION),
            ("law", CONTACT_LAWS),
            ("initial_acceleration", INITIAL_ACCELERATIONS),
            ("damper", ("restitution",)),
        ):
            if getattr(self, name):
                one_of(name, getattr(self, name), allowed)
        for name in self.integrators:
            one_of("integrators", name, tuple(INTEGRATORS))

    def method(self, stiffness: float, damping: float, steps: int) -> TimeStepping:
        """The engine's method for this code and these numbers; what no source states has the engine's default."""
        integrator = INTEGRATORS[self.integrator or NewmarkBeta.name](**self.numbers)
        more = {
            name: value
            for name in ("without_solution", "initial_acceleration", "exponent", "penetration")
            if (value := getattr(self, name)) not in ("", None)
        }
        status = self.status or CONTACT_STATUSES[0]
        law = self.law or CONTACT_LAWS[0]
        if "penetration" in numbers_of(law):
            more.setdefault("penetration", _PENETRATION)
        own = None if self.damper else damping
        return TimeStepping(stiffness, own, steps, integrator, status, law=law, **more)

    def schemes(self) -> tuple[TimeStepping, ...]:
        """The methods that a search for this code tries: each of its integrators, with its law and contact status.

        Where no source says its status, both whole-step ones; explicit integrators take the start of the step.
        """
        own = replace(self.method(1.0, 0.0, 1000), damping=0.0)
        names = dict.fromkeys((own.integrator.name, *self.integrators))
        kinds = [own.integrator if name == own.integrator.name else INTEGRATORS[name]() for name in names]
        statuses = [self.status] if self.status else ["start", "end"]
        pairs = ((kind, "start" if kind.explicit else status) for kind in kinds for status in statuses)
        return tuple(replace(own, integrator=kind, status=status) for kind, status in dict.fromkeys(pairs))

    def texts(self) -> dict[str, str]:
        """The choices of this code beside K, D and the step, as texts by the names of `engine.TimeStepping`."""
        return scheme_texts(self.method(1.0, 1.0, 4))

    def words_for(
        self,
        system: System,
        eta: float,
        method: TimeStepping,
        units: Units | None,
        contact_area: float | None = None,
    ) -> tuple:
        """The lines of its input for a method, in these units; without units, dimensionless.

        ``contact_area``: in the model's unit of length squared, for a code with a pressure in place of the force; None
        where it is not known: the lines then say what is to be divided by it.
        """
        k, dt = method.stiffness, 2.0 * math.pi / (eta * method.steps)
        c = None if method.damping is None else 2.0 * method.damping
        length = 1.0
        if units is not None:
            numbers = units.settings(eta, method)
            k, c, dt = numbers["stiffness"], numbers.get("damping"), numbers["time_step"]
            length = units.factor("displacement")
        numbers = input_numbers(system, eta, method, k, c, dt, length)
        area = None if contact_area is None else contact_area * length**2
        return self.lines(numbers | _per_area(k, c, area), method.integrator.name)

    def lines(self, numbers: Mapping[str, str], integrator: str) -> tuple[str, ...]:
        """The input of the code for the numbers of `input_numbers`, with its words for the integrator that is set."""
        own = self.integrators.get(integrator)
        first = own if own is not None else (f"(its input for the integrator {integrator} is not known)",)
        return tuple(line.format_map(_Blanks(numbers)) for line in (*first, *self.input))

    def as_dict(self) -> dict[str, object]:
        """Plain values for JSON; None for what is not known."""
        values = {each.name: getattr(self, each.name) or None for each in fields(self)}
        lists = {name: list(getattr(self, name)) for name in ("rules", "alone", "input")}
        words = {name: list(lines) for name, lines in self.integrators.items()}
        sources = [vars(source) for source in self.sources]
        contact = [{name: dict(getattr(form, name)) for name in ("words", "defaults")} for form in self.contact]
        tables = {"numbers": dict(self.numbers), "integrators": words, "contact": contact, "sources": sources}
        return values | lists | tables


def _per_area(k: float, c: float | None, area: float | None) -> dict[str, str]:
    """K and c of the contact over its area, or what is to be divided by it where that is not known."""
    known = {name: value for name, value in {"k/area": k, "c/area": c}.items() if value is not None}
    if area is None:
        return {name: f"<{written(value, _DIGITS)} divided by the contact area>" for name, value in known.items()}
    return {name: written(value / area, _DIGITS) for name, value in known.items()}


class _Blanks(dict):
    """Numbers by name; one that is not known stays a blank to fill in."""

    def __missing__(self, name: str) -> str:
        return f"<{name}>"


@cache
def table() -> Mapping[str, object]:
    """The file as it stands."""
    return tomllib.loads(asset("codes.toml"))


@cache
def codes() -> Mapping[str, Code]:
    """All codes by key, in the order of the file; a fault in the file raises ValueError."""
    found: dict[str, Code] = {}
    for row in table()["code"]:
        more = {name: tuple(row[name]) for name in ("rules", "alone", "input") if name in row}
        more["integrators"] = {name: tuple(lines) for name, lines in row.get("integrators", {}).items()}
        more["sources"] = tuple(Source(**source) for source in row.get("sources", ()))
        try:
            more["contact"] = tuple(Form(**each) for each in row.get("contact", ()))
            code = Code(**(row | more))
        except (TypeError, ValueError) as fault:
            raise ValueError(f"codes.toml, {row.get('key')}: {fault}") from None
        if code.key in found:
            raise ValueError(f"codes.toml has two codes named {code.key}")
        found[code.key] = code
    return MappingProxyType(found)


def lighter_critical_damping(system: System, stiffness: float) -> float:
    """D of the critical damping 2mω_c of LS-DYNA, with the mass m of the lighter body in place of the reduced mass."""
    return system.lighter_mass * contact_frequency(system, stiffness)


def input_numbers(
    system: System, eta: float, method: TimeStepping, k: float, c: float | None, dt: float, length: float = 1.0
) -> dict[str, str]:
    """The numbers that stand in the lines of an input, as texts.

    Parameters
    ----------
    system, eta, method
        What is set; of a Newmark solution too.
    k, c, dt : float
        K and c of the contact law (c None where it follows from the restitution) and time step in the units of the
        input.
    length : float
        The unit of length in the units of the input, for the penetration of the law.
    """
    numbers = {"k": k, "dt": dt, "exponent": method.spring_exponent}
    if method.penetration is not None:
        numbers["penetration"] = method.penetration * length
    if method.law == "constant-restitution":  # at any closing speed
        numbers["restitution"] = effective_restitution(system, method, closing_speed=1.0)
    if method.damping is not None:
        zeta = damping_ratio(system, method.stiffness, method.damping)
        numbers |= {"c": c, "zeta": zeta}
        numbers["vdc"] = 100.0 * method.damping / lighter_critical_damping(system, method.stiffness)
        unit_of_time = dt * check_eta(eta) * method.steps / (2.0 * math.pi)
        frequency = contact_frequency(system, method.stiffness) / unit_of_time
        numbers |= {"k/mass": frequency**2, "c/mass": 2.0 * zeta * frequency}
        if zeta:  # 2ζω_c = 2/time constant, as in MuJoCo's solref
            numbers["timeconst"] = 1.0 / (zeta * frequency)
    numbers |= _integrator_numbers(method.integrator, dt)
    return {name: written(value, _DIGITS) for name, value in numbers.items()}


def _integrator_numbers(integrator: Integrator, dt: float) -> dict[str, float]:
    """The numbers of an integrator, and those that other codes write for them and for its time step."""
    own = {each.name: getattr(integrator, each.name) for each in fields(integrator)}
    if "alpha" in own:
        own |= {"openseesalpha": 1.0 + own["alpha"], "hhtdecay": -own["alpha"]}
    return own | {"openseesdt": dt / len(integrator.stages)}  # OpenSees counts each stage as a step
