"""Checks of recommendations by runs that know nothing of the search: as a user makes them, from rest.

Systems other than the paper's are of a random sample: gaps and preloads, a wall, forces on both bodies.
"""

import numpy as np
from vibroscope.engine import (
    ComparisonQuestion,
    ExactPenalty,
    Excitation,
    Limits,
    Newmark,
    Record,
    Reference,
    SettingQuestion,
    System,
    Tolerances,
    compare,
    simulate,
)

PAPER = System()
CLOSE = System(kappa=2.214, mu=0.2215, d2=0.0342, d3=None, d1=0.00589, restitution=0.277, clearance=-0.368)
APART = System(kappa=1.773, mu=1.152, d2=0.00816, d3=0.054, d1=0.0293, restitution=0.385, clearance=1.04)
WALL = System(wall=True, d1=0.0107, restitution=0.129, clearance=-0.658)
FORCED = System(
    kappa=2.389, mu=0.9817, d2=0.0305, d3=0.0501, d1=0.0276, restitution=0.515, clearance=-0.58,
    excitation=Excitation(base=1.0, force1=0.79, force2=1.98, force2_phase=3.58, constant1=0.0634),
)  # fmt: skip
LIVELY = System(kappa=3.617, mu=3.377, d2=0.00398, d3=0.0522, d1=0.0175, restitution=0.74, clearance=1.04)
SOFTER = System(kappa=0.9117, mu=0.2788, d2=0.0444, d3=None, d1=0.0405, restitution=0.789)


def question(system, etas, *, scheme=None, located=False, reference=None, **numbers):
    """What is asked, with the tolerances and limits of these names."""
    names = {"tolerance": "displacement", "restitution_tolerance": "restitution", "force_tolerance": "force"}
    tolerances = {own: numbers.pop(name) for name, own in names.items() if name in numbers}
    scheme = scheme or Newmark(1, 0, 1000, located=located)
    return SettingQuestion(system, etas, Tolerances(**tolerances), Limits(**numbers), scheme, reference or Reference())


class Question:
    """One question, and what is found to be wrong with its answer.

    Parameters
    ----------
    system : System
    eta, tolerance : float
        Of the displacements; those of restitution and peak force are 0.1 and 20 %.
    """

    def __init__(self, system, eta, tolerance):
        self.system, self.eta, self.tolerance = system, eta, tolerance

    def run(self, K, D, n):
        """Error, restitution and peak force of one setting, by `compare` and a plain simulation."""
        compared = compare(ComparisonQuestion(self.system, self.eta, Newmark(K, D, n)))
        if compared.encounters is None:  # it ended early
            return np.inf, np.nan, np.nan
        return compared.total, compared.encounters.restitution, self.peak(Newmark(K, D, n), n)

    def peak(self, method, per_period):
        record = Record(max(4, min(50, 200_000 // per_period)), per_period)
        return simulate(self.system, self.eta, method, record=record).trajectory.force.max()

    def misses(self, K, D, n, without_step=None):
        """Which tolerances a setting misses."""
        error, bounce, peak = self.run(K, D, n)
        without_step = without_step or self.peak(ExactPenalty(K, D), max(4 * n, 20_000))
        found = [] if error <= self.tolerance else [f"error {error:.3%}"]
        if abs(bounce - self.system.restitution) > 0.1:
            found.append(f"restitution {bounce:.3f} for {self.system.restitution:.3f}")
        return found if abs(peak / without_step - 1) <= 0.2 else [*found, f"peak {peak / without_step - 1:+.1%}"]

    def complaints(self, found, neighbours, seed=0):
        """What is wrong with a recommendation: empty if what is printed of it is true."""
        K, D, n = found.best.setting
        rng, wrong = np.random.default_rng(seed), []
        wrong += [f"as printed: {miss}" for miss in self.misses(K, D, n)]
        wrong += [f"with half the step: {miss}" for miss in self.misses(K, D, 2 * n)]
        if (
            f"{compare(ComparisonQuestion(self.system, self.eta, Newmark(K, D, n))).total:.2g}"
            != f"{found.best.error:.2g}"
        ):
            wrong.append(f"the error printed, {found.best.error:.2%}, is not that of compare")
        around = [
            (K * (1 + u / 100), D * (1 + v / 100), n + round(w * n / 50))
            for u, v, w in rng.uniform(-1, 1, (neighbours, 3))
        ]
        wrong += self._of_many("neighbours", around)
        for i, name in enumerate(("stiffness", "damping")):
            values = np.exp(rng.uniform(*np.log(found.ranges[name]), neighbours // 2))
            wrong += self._of_many(f"values of the {name} in its range", [
                tuple(value if j == i else other for j, other in enumerate((K, D, n))) for value in values
            ])  # fmt: skip
        return wrong

    def cheaper(self, found, share):
        """Settings nearby with a share of the steps that keep to all tolerances, as their neighbours do."""
        K, D, n = found.best.setting
        steps = round(share * n)
        for k in (share**2, share, 0.8, 1.0, 1.25):
            for d in (0.85, 1.0, 1.15):
                near = K * k, D * np.sqrt(k) * d
                around = [(near[0] * (1 + u), near[1] * (1 + v), round(steps * (1 + w))) for u, v, w in _AROUND]
                settings = [(*near, steps), (*near, 2 * steps), *around]
                if not any(self.misses(*one) for one in settings):
                    more = np.random.default_rng(7).uniform(-1, 1, (30, 3)) * (0.01, 0.01, 0.02) + 1
                    if not self._of_many("", [(near[0] * k, near[1] * d, round(steps * m)) for k, d, m in more]):
                        yield (*near, steps)

    def _of_many(self, what, settings):
        missed = [miss for miss in (self.misses(*one) for one in settings) if miss]
        return [f"{len(missed)} of {len(settings)} {what} miss: {missed}"] if len(missed) > len(settings) / 10 else []


_AROUND = [(0.008, -0.006, 0.014), (-0.007, 0.009, -0.017), (0.004, 0.005, -0.006), (-0.003, -0.008, 0.009)]
