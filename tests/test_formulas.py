"""The numbered formulas: pages and docstrings have the same ones, and each is what the code computes.

A formula is read from the page as it is displayed there (`tests/displayed.py`). Those of laws and equations of motion
are compared here, the others in `test_formulas_of_….py`.
"""

import importlib
import math
import re

import numpy as np
import pytest
from vibroscope.engine import (
    ExactPenalty,
    Newmark,
    Reference,
    System,
    effective_restitution,
    equal_restitution_damping,
    simulate,
)
from vibroscope.engine.drivers.parameters import parameters_of
from vibroscope.engine.kernels.equations import contact_law
from vibroscope.engine.kernels.equations.motion import (
    accelerations,
    coefficients,
    joined_generator,
    separated_generator,
)
from vibroscope.engine.kernels.time_stepping import newmark
from vibroscope.engine.law_table import CONTACT_LAWS, formula_damper, restitution_without_pull

from tests.displayed import COMPARED, ROOT, compares, of_docstrings, of_pages, parts, sides, value

PAGES = of_pages()
SYSTEM, ETA = System(), 1.3
RANDOM = np.random.default_rng(20)
NAMES = ("ξ₁", "ξ₁′", "ξ₂", "ξ₂′", "λ", "τ")
POINTS = [dict(zip(NAMES, point, strict=True)) for point in RANDOM.uniform(-3, 3, (20, 6))]


def special():
    """The numbers of which the theory's first page says that pages write the paper's case."""
    sentence = re.search(
        r"these pages write (.*?)\s+for the\s+paper", (ROOT / "docs/theory/index.md").read_text(), re.S
    )[1]
    found = set()
    for first, last in re.findall(r"\((\d+)\)(?:\s+to\s+\((\d+)\))?", sentence):
        found |= set(range(int(first), int(last or first) + 1))
    return found


def test_every_number_is_given_once_and_none_is_left_out():
    assert sorted(PAGES) == list(range(1, max(PAGES) + 1))
    assert of_docstrings().keys() == PAGES.keys()


def test_every_formula_is_compared_with_the_code():
    for path in (ROOT / "tests").glob("test_formulas*.py"):
        importlib.import_module(f"tests.{path.stem}")  # its tests say what they compare
    assert PAGES.keys() == COMPARED


@pytest.mark.parametrize("number", sorted(PAGES))
def test_pages_and_docstrings_have_the_same_formula(number):
    plain = [["".join(part.split()) for part in parts(one)] for one in (PAGES[number], *of_docstrings()[number])]
    same = all(one == plain[0] for one in plain)
    assert same == (number not in special()), plain


def test_every_number_that_the_code_cites_is_that_of_a_formula():
    texts = [path.read_text() for path in (ROOT / "engine").rglob("*.py")]
    cited = {int(number) for text in texts for number in re.findall(r"Eqs?\. \((\d+)\)", text)}
    assert {1, 9, 16, 28} <= cited <= PAGES.keys()


def system_symbols(point):
    """The symbols of the paper's system, and of a point."""
    s, mu = SYSTEM, SYSTEM.mass_ratio
    known = {"η": ETA, "κ": s.kappa, "κ₃": s.kappa3, "d₁": s.d1, "d₂": s.d2, "d₃": s.d3, "μ": mu}
    known |= {"c₁": 2 * s.d1, "k₁": 1.0, "c₂": 2 * s.d2 * s.kappa, "k₂": s.kappa**2}
    return known | point | {"g": point["ξ₂"] - point["ξ₁"], "g′": point["ξ₂′"] - point["ξ₁′"]}


@pytest.mark.parametrize("point", POINTS[:5])
@compares(1, 2, 3, 4, 8)
def test_equations_of_motion(point):
    symbols, p = system_symbols(point), parameters_of(SYSTEM, ETA, Reference())
    turn = math.cos(ETA * point["τ"]), math.sin(ETA * point["τ"])
    state = [point[name] for name in ("ξ₁", "ξ₁′", "ξ₂", "ξ₂′")]
    found = dict(zip((1, 2), accelerations(coefficients(p), *state, point["λ"], *turn), strict=True))
    free = separated_generator(p) @ (*state[:2], symbols["g"], symbols["g′"], *turn, 1.0)
    found[3] = free[3] + (1 + 1 / symbols["μ"]) * point["λ"]
    found[4] = (joined_generator(p) @ (*state[:2], 0.0, 0.0, *turn, 1.0))[1]
    position, velocity = contact_law.joint_force(p)
    found[8] = position * state[0] + velocity * state[1]
    joined = symbols | {"ξ": state[0], "ξ′": state[1]}
    for number, computed in found.items():
        assert value(sides(PAGES[number])[1], joined) == pytest.approx(computed, rel=1e-12, abs=1e-12), number


LAWS = {5: "kelvin-voigt", 6: "cut", 16: "limited", 17: "compression", 18: "flores", 19: "jankowski"}
LAWS |= {20: "constant-restitution", 21: "impact", 60: "bilinear"}


@pytest.mark.parametrize("number", LAWS)
@compares(*LAWS)
def test_contact_laws(number):
    law = CONTACT_LAWS.index(LAWS[number])
    n = 1.5 if number == 19 else 1.7
    for point in POINTS:
        K, c, d, r, depth, v = 50.0, 3.0, 0.8, 4.0, abs(point["ξ₁"]), point["ξ₂"]
        symbols = {
            "K": K,
            "D": c / 2,
            "c": c,
            "h": c,
            "n": n,
            "d": d,
            "δ": depth,
            "v": v,
            "r": r,
            "g": -depth,
            "g′": -v,
        }
        symbols["S"] = lambda x: value(smooth_step(), {"x": min(x, 1.0)})
        found = contact_law.law_force(contact_law.ContactLaw(law, K, n, d, r, c, 0.0), c, depth, v)
        assert value(sides(PAGES[number])[1], symbols) == pytest.approx(found, rel=1e-12, abs=1e-12)


def smooth_step():
    """S(x) as it stands beside (21)."""
    return re.search(r"S\(x\) = ([^,]*),", PAGES[21])[1]


@compares(5)
def test_the_spring_and_damper_of_the_linear_kernels():
    for point in POINTS:
        symbols = {"K": 50.0, "D": 1.5, "g": point["ξ₁"], "g′": point["ξ₂"]}
        found = contact_law.force(50.0, 1.5, point["ξ₁"], point["ξ₂"])
        assert value(sides(PAGES[5])[1], symbols) == pytest.approx(found)


@compares(7)
def test_the_eigenvalue_of_the_contact_mode():
    symbols = {"K": 30.0, "D": 9.0, "M": 1 + 1 / SYSTEM.mass_ratio}
    fast = contact_law.contact_rate(symbols["K"], symbols["D"], symbols["M"])
    assert value(sides(PAGES[7])[0], symbols | {"s": -fast}) == pytest.approx(0, abs=1e-9)


@compares(9)
def test_impacts_obey_the_impact_law():
    impacts = simulate(SYSTEM, 2.76, Reference(), periods=100, keep=20).impacts
    before, after = (np.subtract(*velocity.T[::-1]) for velocity in (impacts.velocity_before, impacts.velocity_after))
    assert len(before) > 10
    for closing, parting, impulse in zip(before, after, impacts.impulse, strict=True):
        symbols = {"e": SYSTEM.restitution, "μ": SYSTEM.mass_ratio, "g′⁻": closing}
        if parting:  # none where permanent contact begins
            assert value(sides(PAGES[9])[1], symbols) == pytest.approx(parting)
            assert value(sides(PAGES[9], 1)[1], symbols) == pytest.approx(impulse)


@pytest.mark.parametrize("point", POINTS[:5])
@compares(10, 11)
def test_a_step_of_newmarks_method(point):
    method = Newmark(stiffness=700.0, damping=4.0, steps=60)
    scheme = newmark.scheme_of(parameters_of(SYSTEM, ETA, method))
    h = 2 * math.pi / (ETA * method.steps)
    p1, q1, p2, q2 = (point[name] for name in ("ξ₁", "ξ₁′", "ξ₂", "ξ₂′"))
    turn = math.cos(ETA * point["τ"])
    a1, a2, push = newmark.step(scheme, p1, h * q1, p2, h * q2, True, turn, turn)
    free1, free2, _ = newmark.step(scheme, p1, h * q1, p2, h * q2, False, turn, turn)
    symbols = system_symbols(point) | {"K": 700.0, "D": 4.0, "Δτ": h, "p₁": p1, "p₂": p2, "q₁": q1, "q₂": q2}
    symbols |= {f"m{i}": 1 + symbols[f"c{i}"] * h / 2 + symbols[f"k{i}"] * h * h / 4 for i in "₁₂"}
    symbols |= {"a₁f": free1 / h**2, "a₂f": free2 / h**2}
    symbols["σ"] = value(sides(PAGES[11], 1)[1], symbols)
    assert value(sides(PAGES[11])[1], symbols) == pytest.approx(push, rel=1e-11)
    for i, sign, p, q, a in (("₁", "−", p1, q1, a1), ("₂", "+", p2, q2, a2)):
        force = push if i == "₁" else push / symbols["μ"]
        body = symbols | {"c": symbols[f"c{i}"], "k": symbols[f"k{i}"], "p": p, "q": q, "λ": force}
        right = value(sides(PAGES[10])[1].replace("∓", sign), body)
        assert right == pytest.approx(symbols[f"m{i}"] * a / h**2, rel=1e-11)


FORMULAS = {22: "hunt-crossley", 23: "lankarani-nikravesh", 24: "flores", 25: "jankowski", 26: "constant-restitution"}


@pytest.mark.parametrize("number", FORMULAS)
@pytest.mark.parametrize("e", [0.2, 0.6, 0.9])
@compares(*FORMULAS)
def test_dampers_of_a_restitution(number, e):
    symbols = {"e": e, "K": 900.0, "m": 0.4, "n": 1.5, "v₀": 0.7}
    found, relative = formula_damper(FORMULAS[number], e, symbols["K"], symbols["m"], symbols["n"])
    assert value(sides(PAGES[number])[1], symbols) == pytest.approx(
        found / (symbols["v₀"] if relative else 1), rel=1e-12
    )


@pytest.mark.parametrize("D", [0.5, 4.0, 12.0])
@compares(28, 29, 30, 31, 32)
def test_restitutions_of_a_damper(D):
    K, m, n, v0 = 900.0, SYSTEM.mass_share, 1.5, 0.7
    symbols = {"K": K, "m": m, "n": n, "c": 2 * D, "v₀": v0, "h": 2 * D / K}

    def given(law):
        return effective_restitution(SYSTEM, ExactPenalty(K, D, law=law), v0)

    symbols["ζ"] = 2 * D / (2 * math.sqrt(K * m))
    symbols["φ"] = math.acos(symbols["ζ"])
    for number, law in ((28, "kelvin-voigt"), (29, "cut"), (30, "compression")):
        assert value(sides(PAGES[number])[1], symbols) == pytest.approx(given(law), rel=1e-9)
    ratio = value(sides(PAGES[31])[1], symbols)
    assert value(sides(PAGES[28])[1], symbols | {"ζ": ratio}) == pytest.approx(given("constant-restitution"))
    left, right = (value(side, symbols | {"e": given("flores")}) for side in sides(PAGES[32]))
    assert left == pytest.approx(right, rel=1e-9)


@compares(33, 34, 54, 55)
def test_formulas_of_the_system_and_of_the_contact_mode():
    symbols = system_symbols(POINTS[0]) | {"K": 3000.0}
    for which, computed in enumerate((SYSTEM.kappa3**2, SYSTEM.mass_ratio, SYSTEM.mass_share)):
        assert value(sides(PAGES[33], which)[1], symbols) == pytest.approx(computed)
    assert value(sides(PAGES[34])[1], symbols) == pytest.approx(SYSTEM.derived_joint_damping)
    for ratio in (0.3, 0.9):
        assert value(sides(PAGES[54])[1], {"ζ": ratio}) == pytest.approx(restitution_without_pull(ratio))
    logarithm = -math.log(SYSTEM.restitution)
    symbols["ζ"] = lambda e: logarithm / math.hypot(math.pi, logarithm)
    right = value(sides(PAGES[55])[1], symbols | {"e": SYSTEM.restitution})
    assert right == pytest.approx(equal_restitution_damping(SYSTEM, 3000.0))
