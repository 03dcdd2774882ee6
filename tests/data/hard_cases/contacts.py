"""Chatter and its limit, contact stiffness and damping over their whole ranges, and every kind of initial state."""

from high_precision import Problem
from mpmath import mp, mpf

from hard_cases.methods import exact, reference

REST = (0.0, 0.0, 0.0, 0.0)
# so far out, the springs press the pendulums together: chatter ends even at e = 0.99
PRESSED = (100.0, 0.0, 100.0, -1.0)


def chatter():
    """Restitution from 0 to 1, thresholds 0.002 and 1e-6: from rest, and pressed so that chatter ends in contact."""
    for threshold in (0.002, 1e-6):
        method = reference("table", threshold)
        for e in (0.0, 0.1, 0.5, 0.9, 0.99):
            system, periods = {"restitution": e}, 3 if e < 0.9 else 8
            yield f"chatter|{e}|{threshold:g}", Problem(1.08, method, periods, system)
            yield f"chatter-pressed|{e}|{threshold:g}", Problem(2.76, method, 1, system, PRESSED)
    for joint in ("table", "derived"):
        yield f"elastic|2.76|{joint}", Problem(2.76, reference(joint), 5, {"restitution": 1.0})
    yield "elastic-pressed|2.76|table", Problem(2.76, reference(), 1, {"restitution": 1.0}, PRESSED)


def limits():
    """ε → 0 by ε = 1e-8, 1e-16, 1e-24; the last one equals the limit to many more digits than a double has."""
    for joint in ("table", "derived"):
        for threshold in (1e-8, 1e-16, 1e-24):
            method = reference(joint, threshold)
            for e in (0.5, 0.9):
                system, periods = {"restitution": e}, 3 if e < 0.9 else 8
                yield f"limit|1.08|{e}|{joint}|{threshold:g}", Problem(1.08, method, periods, system)
                yield f"limit-pressed|2.76|{e}|{joint}|{threshold:g}", Problem(2.76, method, 1, system, PRESSED)
    method = reference("table", 1e-24)
    for eta in (0.77, 1.70, 2.20):
        yield f"limit|{eta:.2f}|0.5|table|1e-24", Problem(eta, method, 3)
    for e in (0.1, 0.99):
        yield f"limit-pressed|2.76|{e}|table|1e-24", Problem(2.76, method, 1, {"restitution": e}, PRESSED)


def stiffness():
    """The exact penalty over K and D: underdamped, critically damped, overdamped, and with an extreme damper."""
    for eta, k, d in ((2.76, 12000, 18), (1.08, 2500, 8), (1.08, 100, 50), (3.25, 12000, 18), (1.70, 12000, 18)):
        yield f"exact|{eta:.2f}|{k},{d}", Problem(eta, exact(k, d), 10)
    share = Problem(2.76, exact(1, 0), 1).mass_share
    ratios = {"0": 0, "0.2": mpf("0.2"), "1": 1, "1-1e-9": 1 - mpf("1e-9"), "1+1e-9": 1 + mpf("1e-9"), "5": 5}
    for k in (1, 100, 10**4, 10**6, 10**9):
        for name, ratio in ratios.items():
            method = exact(k, ratio * mp.sqrt(k * share))
            quick = (k, name) != (10**9, "0")
            yield f"stiffness|2.76|K={k:.0e}|zeta={name}", Problem(2.76, method, 4 if quick else 2)
            if quick and name in ("0", "0.2", "1", "5"):
                yield f"stiffness|1.08|K={k:.0e}|zeta={name}", Problem(1.08, method, 2)
    for eta, periods in ((2.76, 4), (1.08, 2)):
        for k in (1, 10**9):
            yield f"stiffness|{eta}|K={k:.0e}|D=1e6", Problem(eta, exact(k, 1e6), periods)


def starts():
    """Every kind of allowed initial state, and runs in which contact never changes."""
    both = {"reference": reference(), "exact": exact(12000, 18)}
    where = {
        "separated": (2.76, (-0.5, 1.0, 0.75, -2.0), 5),
        "approaching": (2.76, (0.25, 1.0, 0.25, -2.0), 5),
        "leaving": (2.76, (0.25, -1.0, 0.25, 2.0), 5),
        "compressed": (1.08, (1.5, 0.25, 1.5, 0.25), 3),  # g = g′ = 0 and λ > 0
        "pulled": (1.08, (-1.5, 0.25, -1.5, 0.25), 3),  # g = g′ = 0 and g″ > 0: they part at once
        "at-rest": (2.2, REST, 5),
        "barely-approaching": (2.76, (0.25, 1.0, 0.25, 1.0 - 1e-12), 3),
        "barely-leaving": (2.76, (0.25, 1.0, 0.25, 1.0 + 1e-12), 3),
        "contact-never-ends": (500.0, (20.0, 0.0, 20.0, 0.0), 5),
        "contact-never-comes": (80.0, (-3.0, 0.0, 4.0, 0.0), 5),
        "far-away": (2.76, (-1e4, 0.0, 1e4, 0.0), 3),
        "slow": (0.02, REST, 1),
        "fast": (200.0, REST, 20),
    }
    for name, (eta, initial, periods) in where.items():
        for law, method in both.items():
            yield f"start|{name}|{law}", Problem(eta, method, periods, initial=initial)
    yield "start|penetrating|exact", Problem(2.76, both["exact"], 5, initial=(0.5, 0.0, 0.25, 1.0))
    yield "start|never-ends|D=1e6", Problem(2.76, exact(1, 1e6), 5, initial=(1.0, 0.0, 0.5, 0.0))
