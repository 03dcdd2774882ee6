"""The numbers of the whole engine before and after a change: same bits, or how far apart.

    .venv/bin/python tools/regression_table.py --write build/before.npz     # on the commit before
    .venv/bin/python tools/regression_table.py --against build/before.npz   # after the change

The table holds every solver on the scenes and the hard cases, every law with every integrator and contact status, 300
random systems (walls and constant forces among them), some 20 sweeps of each kind, 30 comparisons, 30 recommendations,
20 branches with their points and 10 basins. Runs are short (``PERIODS``) where a motion may be chaotic: a difference in
the last bit grows by the largest Lyapunov exponent, and would say nothing about the change after a hundred periods. The
limits of what is compared are those of floating point: machine code may fuse a product and a sum on one version and not
on the other. Speeds are compared in pairs by `benchmarks/against.py`.
"""

import argparse
import sys
import time
import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np

try:
    from vibroscope import engine
    from vibroscope.engine.hardcases.cases import hard_cases
    from vibroscope.engine.law_table import numbers_of
except ImportError:  # before the package had a name of its own
    import engine
    from engine.hardcases.cases import hard_cases
    from engine.law_table import numbers_of

ROOT = Path(__file__).resolve().parents[1]
PERIODS = 12
RANDOM_SYSTEMS = 300
SEED = 20261122
SWEPT = 1.08, 1.35, 1.70, 2.3, 2.76, 3.25, 3.5  # η of planes, of steps and of steps without a solution
LAW_NUMBERS = {"penetration": 1e-3, "stiffening": 4.0}  # of the laws that take them
SAME = 1e-13  # relative to the largest number of an array: a sum in another order


def run(system, eta, method, periods=PERIODS, initial=(0.0, 0.0, 0.0, 0.0), record=None):
    """The numbers of one response."""
    found = engine.simulate(system, eta, method, periods=periods, keep=periods, initial=initial, record=record)
    impacts = found.impacts
    out = {
        "section": found.section,
        "contacts": found.contacts,
        "impacts": np.column_stack([impacts.time, impacts.position, impacts.velocity_before, impacts.velocity_after]),
        "impulse": impacts.impulse,
        "closing": impacts.closing_speed,
    }
    if found.trajectory is not None:
        out["trajectory"] = np.vstack([found.trajectory.displacement, found.trajectory.velocity])
        out["force"] = found.trajectory.force
    return out


def penalty_methods(stiffness, damping, steps):
    """The four solvers of the penalty model."""
    newmark = engine.Newmark(stiffness, damping, steps)
    return {
        "exact": engine.ExactPenalty(stiffness, damping),
        "newmark": newmark,
        "every step": replace(newmark, every_step=True),
        "located": engine.Newmark(stiffness, damping, steps, located=True),
    }


def scenes():
    """Every solver on every scene of the page, sampled."""
    rows = tomllib.loads(next(ROOT.rglob("scenes.toml")).read_text(encoding="utf-8"))["scene"]
    record = engine.Record(2, 200)
    for row in rows:
        methods = penalty_methods(row["K"], row["D"], row["steps"])
        methods |= {f"reference {kind}": engine.Reference(kind) for kind in ("table", "derived")}
        methods["reference limit"] = engine.Reference(threshold=0.0)
        for name, method in methods.items():
            yield f"{row['key']}|{name}", run(engine.System(), row["eta"], method, record=record)


def hard():
    """The hard cases that take less than a second each."""
    for case in hard_cases():
        if case.kind == "states":
            task = case.setup
            yield case.name, run(task.system, task.eta, task.method, min(task.periods, 60), task.initial)


def laws():
    """Every law by every integrator and contact status, with few steps, at two motions; the ends of runs that stop."""
    for eta, stiffness, damping in ((1.08, 2500.0, 8.0), (2.76, 12000.0, 18.0)):
        for law in engine.CONTACT_LAWS:
            more = {name: LAW_NUMBERS[name] for name in LAW_NUMBERS if name in numbers_of(law)}
            exact = engine.ExactPenalty(stiffness, damping, law, **more)
            yield f"{eta}|{law}|exact", run(engine.System(), eta, exact)
            for name, kind in engine.INTEGRATORS.items():
                for status in engine.CONTACT_STATUSES:
                    if status == "end" and kind().explicit:
                        continue
                    how = {"integrator": kind(), "status": status, "law": law, **more}
                    method = engine.TimeStepping(stiffness, damping, 500, **how)
                    yield f"{eta}|{law}|{name}|{status}", run(engine.System(), eta, method, periods=6)
                    if status != "located":
                        every = replace(method, every_step=True)
                        yield f"{eta}|{law}|{name}|{status}|every step", run(engine.System(), eta, every, periods=6)


def random_systems():
    """κ on both sides of 1, e from 0 to 1, starts apart, some at a wall and some loaded; every solver on each."""
    rng = np.random.default_rng(SEED)
    for i in range(RANDOM_SYSTEMS):
        kappa = float(np.exp(rng.uniform(np.log(1.1), np.log(5)))) ** (1 if i % 2 else -1)
        low, high = sorted((1.0, kappa))
        own = {"d1": float(rng.uniform(0, 0.1)), "restitution": float(rng.choice([0.0, 1.0, rng.uniform()]))}
        other = {
            "kappa": kappa,
            "kappa3": float(low + (high - low) * rng.uniform(0.1, 0.9)),
            "d2": float(rng.uniform(0, 0.1)),
            "d3": float(rng.uniform(0, 0.1)),
        }
        own |= {"wall": True} if i % 5 == 4 else other
        if i % 3 == 2:
            own |= {"clearance": float(rng.normal()), "excitation": engine.Excitation(constant2=float(rng.normal()))}
        system = engine.System(**own)
        eta = float(rng.uniform(0.3, 2.5) * max(1.0, system.kappa))
        x, v = rng.normal(size=2).tolist()
        gap, speed = float(rng.exponential()), float(rng.normal())
        initial = (x, v, x + gap - system.clearance, speed)
        if system.wall:
            initial = (system.clearance - gap, v, 0.0, 0.0)
        stiffness = float(10 ** rng.uniform(1, 5))
        methods = penalty_methods(
            stiffness, float(np.sqrt(stiffness) * rng.uniform(0, 0.5)), int(rng.integers(50, 3000))
        )
        methods["reference"] = engine.Reference("derived", float(rng.choice([0.0, 0.002])))
        for name, method in methods.items():
            yield f"{i}|{name}", run(system, eta, method, initial=initial)


def sweeps():
    """Cells of one call over η, over K and D, over the step and over a system's constant; continued ones too."""
    short = {"transient": 30, "sample": 12}
    methods = {"reference": engine.Reference(), **penalty_methods(12000.0, 18.0, 2000)}
    methods["HHT"] = engine.TimeStepping(12000.0, 18.0, 500, integrator=engine.HHT(), status="end")
    etas = np.linspace(0.6, 3.9, 24)
    for name, method in methods.items():
        for direction in ("rest", "up", "down"):
            found = engine.sweep(engine.EtaStudy(engine.System(), method, values=etas, direction=direction, **short))
            yield f"eta {direction}|{name}", numbers(found)
    for over, values in (("restitution", np.linspace(0, 1, 9)), ("kappa", np.linspace(1.9, 4, 9))):
        found = engine.sweep(
            engine.EtaStudy(engine.System(), engine.Reference(), values=values, over=over, eta=2.76, **short)
        )
        yield f"over {over}", numbers(found)
    found = engine.sweep(engine.EtaStudy(engine.System(), engine.Reference(), values=etas, lyapunov=256, **short))
    yield "eta exponents", numbers(found)
    K, D = np.geomspace(100, 6e4, 6), np.geomspace(1, 100, 6)
    for eta in SWEPT:
        for steps in (500, 2000, None):
            method = engine.Newmark(1, 1, steps) if steps else engine.ExactPenalty(1, 1)
            found = engine.sweep(engine.PlaneStudy(engine.System(), method, eta, K=K, D=D, **short))
            yield f"plane {eta}|{steps}", numbers(found)
        for stiffness in (500.0, 12000.0, 60000.0):
            method = engine.Newmark(stiffness, 18.0, 500)
            found = engine.sweep(engine.StepStudy(engine.System(), method, eta, steps=[500, 1000, 2000], **short))
            yield f"step {eta}|{stiffness}", numbers(found)
        for damping in (2.0, 18.0, 60.0):
            axes = {"K": np.geomspace(100, 6e4, 12), "steps": [100, 200, 500]}
            method = engine.TimeStepping(1, damping, 100, status="end")
            found = engine.sweep(engine.NoSolutionStudy(engine.System(), method, eta, **axes, **short))
            yield f"no solution {eta}|{damping}", numbers(found)


def branches():
    """Branches of the reference and of the exact penalty from twenty settings, with the points on them."""
    for eta in np.linspace(1.0, 3.6, 10):
        for name, method in (("reference", engine.Reference()), ("exact", engine.ExactPenalty(2500.0, 8.0))):
            where = {"low": float(eta) - 0.1, "high": float(eta) + 0.1}
            try:
                found = engine.continue_branch(
                    engine.BranchQuestion(engine.System(), float(eta), method, most_orbits=200, **where)
                )
            except ValueError as none:  # no periodic motion there
                yield f"{eta:.2f}|{name}", {"none": np.array(str(none))}
                continue
            out = {"values": found.values, "multipliers": np.ascontiguousarray(found.multipliers).view(float)}
            out["ends"] = np.array([found.sections[0, 0], found.sections[-1, 0]])
            out["points"] = np.array([point.value for point in found.points])
            out["kinds"] = np.array([point.kind for point in found.points], dtype=str)
            yield f"{eta:.2f}|{name}", out


def basins():
    """Ten basins of attraction, each of 12 × 12 starts."""
    x, y = np.linspace(-2, 2, 12), np.linspace(-2, 2, 12)
    for eta in (1.08, 1.7, 2.3, 2.76, 3.25):
        for name, method in (("reference", engine.Reference()), ("newmark", engine.Newmark(2500.0, 8.0, 500))):
            yield (
                f"{eta}|{name}",
                numbers(
                    engine.sweep(
                        engine.BasinStudy.over(engine.System(), method, eta, {"xi2": x, "v2": y}, transient=300)
                    )
                ),
            )


def numbers(dataset):
    """The variables of a study."""
    return {str(name): np.asarray(dataset[name].values) for name in dataset.variables}


def comparisons():
    """Parts, statistics and words at 30 settings whose motion repeats or does not."""
    for eta in (1.08, 1.35, 1.70, 2.3, 2.76, 3.25, 3.5):
        for K, D, steps in ((2500.0, 8.0, 2000), (12000.0, 18.0, 2000), (12000.0, 18.0, 8000), (100.0, 50.0, 500)):
            found = engine.compare(
                engine.ComparisonQuestion(engine.System(), eta, engine.Newmark(K, D, steps), periods=60, keep=24)
            )
            parts = {name: getattr(found, name) for name in ("total", "time_step", "regularisation", "joint_damping")}
            out = {name: np.array(value) for name, value in parts.items()}
            if found.parts is not None:
                out["series"] = found.parts.total
            out["headline"] = np.array(engine.verdict(found).headline)
            yield f"{eta}|{K:g},{D:g},{steps}", out


def recommendations():
    """The front of 30 searches."""
    limits = engine.Tolerances(0.1), engine.Limits(steps_max=2048)
    for eta in np.linspace(2.3, 3.3, 15):
        for located in (False, True):
            scheme = engine.Newmark(1.0, 0.0, 1000, located=located)
            found = engine.recommend(engine.SettingQuestion(engine.System(), float(eta), *limits, scheme))
            rows = [[*trial.setting, trial.error, trial.robust, trial.cost] for trial in found.front]
            yield f"{eta:.3f}|{located}", {"front": np.array(rows).reshape(-1, 6), "reason": np.array(found.reason)}


GROUPS = {
    group.__name__: group
    for group in (scenes, hard, laws, random_systems, sweeps, comparisons, recommendations, branches, basins)
}


def table(groups):
    """All numbers by "group/case/quantity"."""
    found = {}
    for group in groups:
        begin = time.process_time()
        for case, values in GROUPS[group]():
            found |= {f"{group}/{case.replace('/', ':')}/{name}": value for name, value in values.items()}
        print(f"{group}: {time.process_time() - begin:.1f} s of CPU", file=sys.stderr)
    return found


def distance(now, before):
    """0 for the same bits; else the largest difference relative to the largest number, inf if it means nothing."""
    if now.dtype.kind in "US" or now.shape != before.shape:
        return 0.0 if now.shape == before.shape and (now == before).all() else np.inf
    if np.array_equal(now, before, equal_nan=True):
        return 0.0
    if not np.array_equal(np.isfinite(now), np.isfinite(before)):
        return np.inf
    finite = np.isfinite(before)
    size = max(float(np.abs(before[finite]).max(initial=0.0)), 1e-300)
    return float(np.abs(now[finite].astype(float) - before[finite]).max(initial=0.0)) / size


def report(now, before):
    """Print how many arrays of each group have the same bits, and the ones that differ most."""
    print(f"{'group':16}{'arrays':>8}{'same bits':>11}{'to 1e-13':>10}{'further':>9}{'largest':>11}")
    far = []
    for group in GROUPS:
        names = [name for name in before.files if name.startswith(f"{group}/")]
        if not names or not any(name.startswith(f"{group}/") for name in now):
            continue
        apart = {name: distance(now[name], before[name]) if name in now else np.inf for name in names}
        values = np.array(list(apart.values()))
        same, near = int((values == 0).sum()), int(((values > 0) & (values <= SAME)).sum())
        row = f"{group:16}{len(values):8}{same:11}{near:10}{len(values) - same - near:9}{values.max():11.1e}"
        print(row)
        far += [(value, name) for name, value in apart.items() if value > SAME]
    for value, name in sorted(far, reverse=True)[:60]:
        print(f"  {value:9.1e}  {name}")
    return not far


def main():
    """Write the table, or compare with one."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    way = parser.add_mutually_exclusive_group(required=True)
    way.add_argument("--write", metavar="FILE", type=Path)
    way.add_argument("--against", metavar="FILE", type=Path)
    parser.add_argument("--groups", default=",".join(GROUPS), help="some of %(default)s")
    asked = parser.parse_args()
    found = table(asked.groups.split(","))
    if asked.write:
        asked.write.parent.mkdir(parents=True, exist_ok=True)
        np.savez_compressed(asked.write, **found)
        return 0
    return 0 if report(found, np.load(asked.against)) else 1


if __name__ == "__main__":
    sys.exit(main())
