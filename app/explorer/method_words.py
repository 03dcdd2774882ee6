"""The penalty solution in words: integrator, contact status and law. No panel import."""

from __future__ import annotations

from dataclasses import fields

from vibroscope.engine import Method, Newmark, TimeStepping, written

INTEGRATOR_NAMES = {
    "newmark": "Newmark",
    "hht": "HHT-α, forces averaged",
    "hht-interpolated": "HHT-α, forces between",
    "generalised-alpha": "generalised-α",
    "tr-bdf2": "TR-BDF2",
    "bathe": "Bathe",
    "central-difference": "central differences",
    "semi-implicit-euler": "semi-implicit Euler",
}
STATUS_NAMES = {"start": "start of the step", "end": "end, iterated"}
LAW_NAMES = {
    "kelvin-voigt": "Kelvin–Voigt",
    "cut": "Kelvin–Voigt, cut at zero",
    "limited": "limited damper",
    "compression": "damper in compression alone",
    "hunt-crossley": "Hunt–Crossley",
    "lankarani-nikravesh": "Lankarani–Nikravesh",
    "flores": "Flores",
    "jankowski": "Jankowski",
    "constant-restitution": "constant restitution",
    "impact": "IMPACT",
}
_SYMBOLS = {"beta": "β", "gamma": "γ", "alpha": "α", "rho": "ρ∞"}
_STATUSES = {
    "start": "contact status from the start of the step",
    "end": "contact status iterated to the end of the step",
    "located": "contact changes located within the step",
}


def name_of_integrator(name: str) -> str:
    """The name of an integrator alone, as "HHT-α"."""
    return INTEGRATOR_NAMES.get(name, name).partition(",")[0]


def name_of_method(method: Method) -> str:
    """A penalty solution with a time step in a few words, as "HHT-α, forces averaged (α = −0.05)"."""
    if isinstance(method, Newmark):
        return "Newmark, located" if method.located else "Newmark"
    if not isinstance(method, TimeStepping):
        return str(method.name)
    own = method.integrator
    numbers = ", ".join(
        f"{_SYMBOLS.get(each.name, each.name)} = {written(getattr(own, each.name)).replace('-', '−')}"
        for each in fields(own)
    )
    name = INTEGRATOR_NAMES.get(own.name, own.name)
    return f"{name} ({numbers})" if numbers else name


def is_located(method: Method) -> bool:
    """Whether contact changes are located within its steps."""
    return bool(getattr(method, "located", False)) or getattr(method, "status", "") == "located"


def words_of_method(method: Method) -> str:
    """The same with contact status and law; empty for Newmark's method, which the page takes unless told otherwise."""
    if not isinstance(method, TimeStepping):
        return ""
    law = LAW_NAMES.get(method.law, method.law)
    return f"{name_of_method(method)}; {_STATUSES.get(method.status, method.status)}; contact law {law}"


def not_with(what: str, method: Method) -> str:
    """Why ``what``, which knows Newmark's method alone, is not of what is set; empty where it is."""
    words = words_of_method(method)
    return words and f"{what} is by Newmark's method, β = ¼, γ = ½, and Kelvin–Voigt contact. What is set is {words}."
