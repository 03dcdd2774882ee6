"""The hard cases: what a solver of impacts can get wrong, each with the outcome that is expected of this engine."""

import json
import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cache
from importlib.resources import files

from vibroscope import assets

from ..methods import ExactPenalty, Newmark, Reference
from ..model import System
from ..result import Status
from .condition import EPSILON, MARGIN, Run

TRUTH = files(assets) / "truth" / "hard.json"
SIGMAS = 5.0  # by which statistics of the same motion may differ: once in two million times


@dataclass(frozen=True)
class Case:
    """One hard case.

    Attributes
    ----------
    name : str
        The group, a colon, and what is special about the case.
    run : Run
        What is solved.
    truth : str
        Name of its solution in hard.json; empty if there is none.
    clear : str
        Of a grazing case: the same but for the graze, whose conditioning tells how far the graze's error grows.
    allowed : float or None
        Largest error that is allowed; None: what double precision can attain.
    statuses : tuple of Status
        How the run may end.
    mentions : str
        What the message of a run that ends early must name.
    compared : Run or None
        A solution to compare with in place of the truth: the last row of the section.
    kind : {"states", "statistics", "drift"}
        Whether states, statistics of a chaotic motion, or states before and after very many periods are compared.
    """

    name: str
    run: Run
    truth: str = ""
    clear: str = ""
    allowed: float | None = None
    statuses: tuple[Status, ...] = (Status.OK,)
    mentions: str = ""
    compared: Run | None = None
    kind: str = "states"

    @property
    def expected(self) -> str:
        """In words."""
        return " or ".join(self.statuses)


@cache
def solutions() -> dict:
    """The solutions with 60 digits, by name."""
    return json.loads(TRUTH.read_text(encoding="utf-8"))["cases"]


def run_of(truth: str, **changed) -> Run:
    """The run of which hard.json has the solution; ``changed`` replaces attributes of the method."""
    entry = solutions()[truth]
    numbers = {name: value for name, value in (entry["method"] | changed).items() if name != "name"}
    method = (Reference if entry["method"]["name"] == "reference" else ExactPenalty)(**numbers)
    return Run(System(**entry["system"]), entry["eta"], method, entry["periods"], tuple(entry["initial"]))


def hard_cases() -> list[Case]:
    """All of them."""
    groups = (_grazing, _chatter, _close, _resonance, _stiffness, _steps, _long, _endless, _starts, _chaos, _refused)
    return [case for group in groups for case in group()]


def _known(group: str, *truths: str, **changed) -> Iterable[Case]:
    """Cases of which the truth is known."""
    for truth in truths:
        yield Case(f"{group}: {truth}", run_of(truth, **changed), truth=truth)


def _grazing():
    for law, flows in (("grazing", "abcde"), ("grazing-exact", "abc"), ("grazing-force", "ab")):
        for flow in flows:
            for dip in ("1e-14", "-1e-14", "0"):
                truth = f"{law}|{flow}|{dip}"
                yield Case(f"grazing: {truth}", run_of(truth), truth=truth, clear=f"{law}|{flow}|1e-06")


def _chatter():
    for e in ("0.0", "0.1", "0.5", "0.9", "0.99"):
        for threshold in ("0.002", "1e-06"):
            yield from _known("chatter", f"chatter|{e}|{threshold}", f"chatter-pressed|{e}|{threshold}")
    for e in ("0.1", "0.5", "0.9", "0.99"):
        yield from _known("chatter, limit of the threshold", f"limit-pressed|2.76|{e}|table|1e-24", threshold=0.0)
    yield from _known("chatter, limit of the threshold", "limit|1.08|0.5|derived|1e-24", threshold=0.0)
    yield from _known("elastic", "elastic|2.76|table", "elastic|2.76|derived", "elastic-pressed|2.76|table")


def _close():
    for eta in ("1.0", "2.0"):
        for law in ("table", "derived", "12000,18"):
            yield from _known("κ close to 1", f"kappa|1+0.0001|{eta}|{law}", f"kappa|1+1e-07|{eta}|{law}")


def _resonance():
    for eta in ("1.0", "2.41", "1.8"):
        for d in ("damped", "1e-9", "undamped"):
            yield from _known("resonance", f"resonance|{eta}|{d}|table", f"resonance|{eta}|{d}|12000,18")
    yield from _known("undamped", *(f"undamped|2.76|{law}" for law in ("e=0.5", "e=1", "100,0", "12000,0")))


def _stiffness():
    for k in ("1e+00", "1e+02", "1e+04", "1e+06", "1e+09"):
        for zeta in ("0", "0.2", "1-1e-9", "1", "1+1e-9", "5"):
            yield from _known("stiffness", f"stiffness|2.76|K={k}|zeta={zeta}")
    for k in ("1e+00", "1e+09"):
        yield from _known("damping", f"stiffness|2.76|K={k}|D=1e6", f"stiffness|1.08|K={k}|D=1e6")


def _steps():
    """Newmark: T/20 to T/10⁶, and steps that are far too long for the contact."""
    system, eta, k, d, periods = System(), 2.76, 12000.0, 18.0, 2
    exact = Run(system, eta, ExactPenalty(k, d), periods)
    pole, fastest = math.sqrt(k / system.mass_share), max(system.kappa, eta)
    size = 10.0  # of the motion
    for n in (20, 200, 2000, 20_000, 1_000_000):
        h = 2 * math.pi / eta / n
        # a change of contact is missed by up to a step: the speed is off by that much of the contact's own
        missed = 4 * size * pole * h if pole * h < 1 else math.inf
        cut = size * (fastest * h) ** 2 * 2 * math.pi / eta * fastest * periods
        rounded = MARGIN * EPSILON * size * n * periods
        for located, allowed in ((False, missed + rounded), (True, cut + rounded)):
            method = Newmark(k, d, n, located=located)
            blows = (Status.OK, Status.DIVERGED) if not located and pole * h > 1 else (Status.OK,)
            name = f"time step: T/{n}, {'located' if located else 'plain'}"
            yield Case(name, replace(exact, method=method), allowed=allowed, statuses=blows, compared=exact)
    for k, d in ((1e9, 0.0), (1e9, 1e3), (1.0, 1e6)):
        for located in (False, True):
            method = Newmark(k, d, 20, located=located)
            name = f"K Δτ² ≫ 1: K = {k:g}, D = {d:g}, T/20, {'located' if located else 'plain'}"
            blows = (Status.OK,) if located else (Status.OK, Status.DIVERGED)
            yield Case(name, Run(system, eta, method, 500), statuses=blows, mentions="step")
    method = Newmark(6e4, 1.0, 100)
    yield Case("K Δτ² ≫ 1: blows up", Run(system, eta, method, 500), statuses=(Status.DIVERGED,), mentions="step")


def _long():
    for method in (Reference(), ExactPenalty(12000, 18)):
        yield Case(f"a million periods: {method.name}", Run(System(), 2.76, method, 1_000_000), kind="drift")


def _endless():
    both = ("reference", "exact")
    yield from _known("contact never ends", *(f"start|contact-never-ends|{law}" for law in both))
    yield from _known("contact never ends", "start|never-ends|D=1e6")
    yield from _known("contact never comes", *(f"start|contact-never-comes|{law}" for law in both))


def _starts():
    names = (
        "at-rest approaching leaving compressed pulled barely-approaching barely-leaving separated far-away slow fast"
    )
    for name in names.split():
        yield from _known("start", f"start|{name}|reference", f"start|{name}|exact")
    yield from _known("start", "start|penetrating|exact")


def _chaos():
    system, periods = System(), 8000
    moved = (1e-9, 0.0, 1e-9, 0.0)
    for name, one, other in (
        ("two starts", Reference("derived"), Reference("derived")),
        ("two thresholds", Reference("derived", 0.002), Reference("derived", 0.0)),
        ("two starts, exact penalty", ExactPenalty(12000, 18), ExactPenalty(12000, 18)),
    ):
        first, second = Run(system, 1.70, one, periods), Run(system, 1.70, other, periods, moved)
        yield Case(f"chaos: {name}", first, compared=second, allowed=SIGMAS, kind="statistics")


def _refused():
    """What cannot be solved says so: elastic impacts that pile up without end."""
    pressed = (1e5, 0.0, 1e5, -1e-3)
    method, system = Reference(threshold=0.0), System(restitution=1.0)
    run = Run(system, 0.01, method, 1, pressed)
    yield Case("no end: elastic chatter", run, statuses=(Status.PILED_UP,), mentions="restitution")
