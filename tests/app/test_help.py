"""The equations in Help, read from the page, hold for the numbers of the kernels."""

import re

import numpy as np
import pytest
from vibroscope.app.export.tables import FIGURES
from vibroscope.app.page.files import template
from vibroscope.app.page.study.tab import StudyView
from vibroscope.app.page.tabs import VIEWS
from vibroscope.engine import ExactPenalty, Excitation, Newmark, Record, Reference, System, simulate

SYSTEM = System()
ETA = 1.08
NUMBERS = {"kappa": SYSTEM.kappa, "kappa3": SYSTEM.kappa3, "d1": SYSTEM.d1, "d2": SYSTEM.d2, "d3": SYSTEM.d3}
NUMBERS |= {"mu": SYSTEM.mass_ratio, "e": SYSTEM.restitution, "eta": ETA, "K": 2500.0, "D": 8.0}
# Longest first: ξ₁″ before ξ₁. Each becomes a name of Python's.
SYMBOLS = {
    "cos (ητ + φ)": "drive", "cos (ητ + φ₁)": "drive1", "cos (ητ + φ₂)": "drive2", "a": "base", "F₁": "F1", "F₂": "F2",
    "P₁": "P1", "P₂": "P2", "g₀": "clearance", "g": "gap", "cos ητ": "drive",
    "η": "eta", "κ₃": "kappa3", "κ": "kappa", "μ": "mu", "λ": "force", "²": "**2",
    "ξ₁″": "a1", "ξ₂″": "a2", "ξ″": "a1", "ξ₁′": "v1", "ξ₂′": "v2", "ξ′": "v1", "ξ₁′⁺": "p1", "ξ₂′⁺": "p2",
    "ξ₁′⁻": "m1", "ξ₂′⁻": "m2", "ξ₁": "x1", "ξ₂": "x2", "ξ": "x1", "d₁": "d1", "d₂": "d2", "d₃": "d3", "−": "-",
}  # fmt: skip


def sides(name):
    """Both sides of a displayed equation as Python: symbols by name, a space or a bracket for a product."""
    text = re.search(rf'data-equation="{name}">(.*?)<', template("help/help.html")).group(1)
    tokens = re.findall("|".join(map(re.escape, sorted(SYMBOLS, key=len, reverse=True))) + r"|[KDe]|\d+|[-+=/()]", text)
    assert "".join(tokens).replace(" ", "") == text.replace(" ", ""), "a symbol that the test does not know"
    code, last = "", ""
    for token in (SYMBOLS.get(token, token) for token in tokens):
        ends = last not in ("", "-", "+", "=", "/", "(")
        begins = token not in ("-", "+", "=", "/", ")", "**2")
        code += ("*" if ends and begins else "") + token
        last = token
    return code.split("=")


def difference(name, **values):
    left, right = (np.asarray(eval(side, NUMBERS | values)) for side in sides(name))
    scale = np.abs(left).max()
    return np.abs(left - right).max() / scale


def sampled(method):
    """Samples whose neighbours lie in the same state of contact, with accelerations by central differences."""
    response = simulate(SYSTEM, ETA, method, periods=300, record=Record(2, 32_000))
    t = response.trajectory
    h = t.time[1] - t.time[0]
    acceleration = (t.velocity[:, 2:] - t.velocity[:, :-2]) / (2 * h)
    touching = (t.displacement[1] - t.displacement[0] <= 1e-12) if isinstance(method, Reference) else t.force != 0
    contacts_near = np.convolve(touching, np.ones(9), "same")[1:-1]
    inner = {
        "x1": t.displacement[0, 1:-1], "x2": t.displacement[1, 1:-1], "v1": t.velocity[0, 1:-1],
        "v2": t.velocity[1, 1:-1], "a1": acceleration[0], "a2": acceleration[1], "force": t.force[1:-1],
        "drive": np.cos(ETA * t.time[1:-1]),
    }  # fmt: skip
    apart, together = contacts_near == 0, contacts_near == 9
    if isinstance(method, Reference):  # at an impact the velocity jumps, and no difference is an acceleration
        near = np.searchsorted(t.time[1:-1], response.impacts.time[response.impacts.time > t.time[0]])
        apart[np.clip(near[:, None] + np.arange(-3, 4), 0, len(apart) - 1)] = False
    return [{name: values[chosen] for name, values in inner.items()} for chosen in (apart, together)]


@pytest.mark.parametrize("name", ["one", "two"])
@pytest.mark.parametrize("method", [Reference(), ExactPenalty(2500, 8), Newmark(2500, 8, 32_000)], ids=lambda m: m.name)
def test_the_equations_of_motion(name, method):
    apart, _ = sampled(method)
    assert len(apart["x1"]) > 2000
    assert difference(name, **apart) < 2e-4


@pytest.mark.parametrize("name", ["one", "two", "penalty"])
def test_the_penalty_contact(name):
    _, together = sampled(ExactPenalty(2500, 8))
    assert len(together["x1"]) > 1000
    assert difference(name, **together) < 2e-4


GENERAL = System(kappa=1.7, d1=0.02, d2=0.05, mu=0.6, d3=None, clearance=0.3, excitation=Excitation(
    base=0.8, base_phase=0.4, force1=0.5, force1_phase=-1.0, force2=0.7, force2_phase=2.0, constant1=0.2, constant2=0.1,
))  # fmt: skip


@pytest.mark.parametrize("name", ["general_one", "general_two", "gap"])
def test_the_equations_of_any_system(name):
    t = simulate(GENERAL, ETA, ExactPenalty(200, 2), periods=30, record=Record(2, 32_000), keep=2).trajectory
    (x1, x2), (v1, v2), inner = t.displacement[:, 1:-1], t.velocity[:, 1:-1], t.time[1:-1]
    a1, a2 = (t.velocity[:, 2:] - t.velocity[:, :-2]) / (t.time[2:] - t.time[:-2])
    steady = np.convolve(np.abs(np.diff(t.force != 0)), np.ones(9), "same")[:-1] == 0  # at its begin the force jumps
    drive = GENERAL.excitation
    values = {
        "kappa": 1.7,
        "d1": 0.02,
        "d2": 0.05,
        "mu": 0.6,
        "clearance": 0.3,
        "base": drive.base,
        "force": t.force[1:-1],
    }
    values |= {"F1": drive.force1, "F2": drive.force2, "P1": drive.constant1, "P2": drive.constant2}
    values |= {f"drive{n}": np.cos(ETA * inner + getattr(drive, f"force{n}_phase")) for n in (1, 2)}
    values |= {"x1": x1, "x2": x2, "v1": v1, "v2": v2, "a1": a1, "a2": a2, "drive": np.cos(ETA * inner + 0.4)}
    values["gap"] = GENERAL.gap(x1, x2)
    assert (t.force > 0).any()
    assert (t.force[1:-1][steady] == 0).sum() > 1000
    assert difference(name, **{n: v[steady] if np.ndim(v) else v for n, v in values.items()}) < 2e-4


@pytest.mark.parametrize("name", ["joined", "joint_force"])
def test_permanent_contact(name):
    _, together = sampled(Reference())
    assert len(together["x1"]) > 1000
    assert difference(name, **together) < 2e-4


@pytest.mark.parametrize("name", ["impact", "momentum"])
def test_impacts(name):
    found = simulate(SYSTEM, ETA, Reference(), periods=300).impacts
    (m1, m2), (p1, p2) = found.velocity_before.T, found.velocity_after.T
    if name == "impact":  # the last of a chatter leaves no parting speed: permanent contact begins
        parting = p1 != p2
        m1, m2, p1, p2 = m1[parting], m2[parting], p1[parting], p2[parting]
    assert len(m1) > 100
    assert difference(name, m1=m1, m2=m2, p1=p1, p2=p2) < 1e-9


def test_the_mass_ratio():
    assert difference("mass") < 1e-12


def test_no_equation_is_left_untested():
    shown = set(re.findall(r'data-equation="(\w+)"', template("help/help.html")))
    of_papers = {"one", "two", "mass", "impact", "momentum", "joined", "joint_force", "penalty"}
    assert shown == of_papers | {"gap", "general_one", "general_two"}


def test_every_figure_that_can_be_taken_away_has_its_paragraph():
    headings = re.findall(r'<h3 data-figures="([^"]+)">[^<]+</h3>\n<p>', template("help/help.html"))
    explained = [name for names in headings for name in names.split()]
    studies = [figure.name for tab in VIEWS.values() if issubclass(tab, StudyView) for figure in tab.pictures]
    assert sorted(explained) == sorted([*FIGURES, *studies, "claims", "paper"])  # Paper's are named paper3, paper4A, …
