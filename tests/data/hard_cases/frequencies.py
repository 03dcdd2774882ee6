"""Long runs from rest, resonance, no damping, and nearly equal frequencies."""

from high_precision import Problem

from hard_cases.methods import exact, reference


def from_rest():
    """Long runs from rest, both joint dampings: the paper's four η and twelve others; motion at 1.70 is chaotic."""
    for joint in ("table", "derived"):
        for eta in (1.08, 1.70, 2.76, 3.25):
            yield f"rest|{eta:.2f}|{joint}", Problem(eta, reference(joint), 15 if eta == 1.70 else 30)
        for eta in (0.5, 0.62, 0.77, 0.93, 1.21, 1.38, 1.55, 1.93, 2.2, 2.5, 3.0, 4.0):
            yield f"rest|{eta:.2f}|{joint}", Problem(eta, reference(joint), 10)


def close_frequencies():
    """κ only just above 1: almost nothing but the difference of the dampers drives the gap."""
    for excess in (1e-4, 1e-7):
        system = {"kappa": 1 + excess, "kappa3": 1 + excess / 2}
        for eta in (1.0, 2.0):
            for joint in ("table", "derived"):
                yield f"kappa|1+{excess:g}|{eta}|{joint}", Problem(eta, reference(joint), 5, system)
            yield f"kappa|1+{excess:g}|{eta}|12000,18", Problem(eta, exact(12000, 18), 4, system)


def resonance():
    """Excitation at 1, κ and κ₃: damped, hardly damped, and undamped (secular growth)."""
    for eta in (1.0, 2.41, 1.8):
        for name, d in (("damped", None), ("1e-9", 1e-9), ("undamped", 0.0)):
            system = {} if d is None else {"d1": d, "d2": d, "d3": d}
            yield f"resonance|{eta}|{name}|table", Problem(eta, reference(), 5, system)
            if d is None:
                yield f"resonance|{eta}|{name}|derived", Problem(eta, reference("derived"), 5, system)
            yield f"resonance|{eta}|{name}|12000,18", Problem(eta, exact(12000, 18), 4, system)


def undamped():
    """No damper at all."""
    system = {"d1": 0.0, "d2": 0.0, "d3": 0.0}
    yield "undamped|2.76|e=0.5", Problem(2.76, reference(), 5, system)
    yield "undamped|2.76|e=1", Problem(2.76, reference(), 5, system | {"restitution": 1.0})
    for stiffness in (100, 12000):
        yield f"undamped|2.76|{stiffness},0", Problem(2.76, exact(stiffness, 0), 5, system)
