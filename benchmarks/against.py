"""Cost of this checkout against another one, the same work in turns: the ratio of each kind of work.

    .venv/bin/python benchmarks/against.py OTHER_CHECKOUT

Each checkout has its own interpreter (.venv, set up by make), worker process and kernel cache. A round runs every kind
of work once in each worker, and the ratio is the median of the rounds' own ratios: what slows the machine for a while
slows both. A second worker of this checkout takes part, and its ratio to the first shows the noise of the measurement.
Workers start anew several times, since a process keeps the memory layout that it starts with. Seconds are the
processor's, except for the start of a process, which counts by the wall.
"""

import argparse
import json
import os
import statistics
import subprocess
import sys
import time
from pathlib import Path

HERE = Path(__file__).resolve().parents[1]
TARGET = 0.02  # seconds that one measurement takes at least
LIMIT = 1.05  # a larger ratio is marked
SCENES = {"A": (1.08, 2500, 8, 2000), "B": (1.70, 12000, 18, 2000), "C": (2.76, 12000, 18, 8000)}
SCENES["D"] = (3.25, 12000, 18, 8000)
IMPORT = """\
try:
    import vibroscope.engine
except ImportError:  # before the package had a name of its own
    import engine
"""
SIMULATE = ("simulate", "--solver", "newmark", "--eta", "2.76", "--K", "12000", "--D", "18", "--steps", "2000")


# --- in a worker ------------------------------------------------------------------------------------------------------


def works():
    """Each kind of work by its name: a function that does it once and returns its processor seconds."""
    try:
        from vibroscope import engine
    except ImportError:  # before the package had a name of its own
        import engine
    import numpy as np

    system = engine.System()
    found = {}

    def add(name, function, *arguments, **options):
        def run():
            begin = time.process_time()
            function(*arguments, **options)
            return time.process_time() - begin

        found[name] = run

    def add_solver(name, eta, method, periods):
        def run():
            begin = time.process_time()
            response = engine.simulate(system, eta, method, periods=periods, keep=1)
            # The response counts by the wall; where other programs interfere, the call's seconds are the closer bound.
            return min(response.cost.seconds, time.process_time() - begin)

        found[name] = run

    for scene, (eta, stiffness, damping, steps) in SCENES.items():
        newmark = (stiffness, damping, steps)
        add_solver(f"reference [{scene}]", eta, engine.Reference(), 2050)
        add_solver(f"exact penalty [{scene}]", eta, engine.ExactPenalty(stiffness, damping), 2050)
        add_solver(f"Newmark, skipping [{scene}]", eta, engine.Newmark(*newmark), 2050)
        add_solver(f"Newmark, every step [{scene}]", eta, engine.Newmark(*newmark, every_step=True), 200)
        add_solver(f"Newmark, located [{scene}]", eta, engine.Newmark(*newmark, located=True), 200)
    for scene, (eta, stiffness, damping, steps) in SCENES.items():
        newmark = engine.Newmark(stiffness, damping, steps)
        short = {"periods": 20, "keep": 20}
        add(f"call, reference, 20 periods [{scene}]", engine.simulate, system, eta, engine.Reference(), **short)
        add(f"call, Newmark, 20 periods [{scene}]", engine.simulate, system, eta, newmark, **short)
        add(f"steady [{scene}]", engine.steady, system, eta, engine.Reference())
        add(f"compare [{scene}]", engine.compare, engine.ComparisonQuestion(system, eta, newmark))
    etas = np.linspace(0.5, 4, 200)
    many = {"transient": 400, "sample": 50, "threads": 1}
    for name, method in {"reference": engine.Reference(), "exact": engine.ExactPenalty(12000, 18)}.items():
        add(f"200 cells over eta, {name}", engine.run_cells, engine.Cells(system, etas, method), **many)
    K, D = (axis.ravel() for axis in np.meshgrid(np.geomspace(100, 6e4, 16), np.geomspace(1, 100, 16)))
    for name, method in {"Newmark": engine.Newmark(1, 1, 2000), "exact": engine.ExactPenalty(1, 1)}.items():
        cells = engine.Cells(system, np.full(K.size, 2.76), method, stiffness=K, damping=D)
        add(f"plane of 256 cells, {name}", engine.run_cells, cells, **many)
    add("recommend, eta 3.25", engine.recommend, system, 3.25, tolerance=0.5, steps_max=64)
    return found


def work():
    """Serve requests, one a line: a name and how often to do that work; answer with its mean seconds."""
    answers = os.dup(1)
    os.dup2(2, 1)  # whatever else is printed is no answer
    with os.fdopen(answers, "w") as out:
        known = works()
        print(json.dumps(list(known)), file=out, flush=True)
        for line in sys.stdin:
            name, times = json.loads(line)
            print(json.dumps(sum(known[name]() for _ in range(times)) / times), file=out, flush=True)


# --- the checkouts ----------------------------------------------------------------------------------------------------


class Worker:
    """A checkout whose interpreter does the work in a process of its own."""

    def __init__(self, checkout, cache):
        self.checkout, self.bin = checkout, checkout / ".venv" / "bin"
        if not (self.bin / "python").exists():
            raise SystemExit(f"{checkout} has no .venv: make it there with `make .venv/run`")
        # Byte code is kept, as for a user: its folder lies beside the kernels, so that the checkouts stay clean.
        self.environment = {key: value for key, value in os.environ.items() if key != "PYTHONDONTWRITEBYTECODE"}
        self.environment |= {"VIBROSCOPE_CACHE_DIR": str(cache), "PYTHONPYCACHEPREFIX": str(cache / "byte-code")}
        self.process = None

    def start(self):
        """A new process; returns the names of what it can do."""
        self.process = subprocess.Popen(
            [self.bin / "python", __file__, "--worker"],
            cwd=self.checkout,
            env=self.environment,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        return self.answer()

    def stop(self):
        """End the process."""
        self.process.stdin.close()
        self.process.wait()

    def answer(self):
        """The next answer."""
        line = self.process.stdout.readline()
        if not line:
            raise SystemExit(f"{self.bin}: the worker ended with status {self.process.wait()}")
        return json.loads(line)

    def seconds(self, name, times):
        """Mean seconds of one kind of work."""
        if name in STARTS:
            return self.wall(*STARTS[name])
        self.process.stdin.write(json.dumps([name, times]) + "\n")
        self.process.stdin.flush()
        return self.answer()

    def wall(self, command, *arguments):
        """Seconds on the wall of a command of this checkout."""
        options = {"cwd": self.checkout, "env": self.environment, "stdout": subprocess.DEVNULL, "check": True}
        begin = time.perf_counter()
        subprocess.run([self.bin / command, *arguments], **options)
        return time.perf_counter() - begin


STARTS = {
    "start: import of the engine, wall": ("python", "-c", IMPORT),
    "start: vibroscope simulate, wall": ("vibroscope", *SIMULATE),
}


def measure(workers, starts, rounds):
    """Seconds of each kind of work, a list for each worker, one entry a round; workers take turns."""
    seconds = {}
    for _ in range(starts):
        names = [*workers[0].start(), *STARTS]
        for worker in workers[1:]:
            worker.start()
        # The first run compiles; the second decides how often a measurement repeats the work, alike for all.
        for worker in workers:
            for name in names:
                worker.seconds(name, 1)
        times = {name: max(1, round(TARGET / max(workers[0].seconds(name, 1), 1e-6))) for name in names}
        for turn in range(rounds):
            order = [0, 1, 2] if turn % 2 else [2, 1, 0]
            for name in names:
                found = seconds.setdefault(name, [[] for _ in workers])
                for number in order:
                    found[number].append(workers[number].seconds(name, times[name]))
        for worker in workers:
            worker.stop()
    return seconds


def ratios(upper, lower):
    """The rounds' own ratios: lower quartile, median, upper quartile."""
    found = [a / b for a, b in zip(upper, lower, strict=True)]
    return statistics.quantiles(found, n=4) if len(found) > 1 else 3 * found


def main():
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("other", type=Path, nargs="?", metavar="OTHER_CHECKOUT", help="default: this one")
    parser.add_argument("--rounds", type=int, default=7, help="turns of each process (default %(default)s)")
    parser.add_argument("--starts", type=int, default=3, help="starts of the processes (default %(default)s)")
    parser.add_argument("--worker", action="store_true", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.worker:
        work()
        return
    other = (options.other or HERE).resolve()
    caches = HERE / "build" / "against"
    workers = [Worker(HERE, caches / "this"), Worker(other, caches / "other"), Worker(HERE, caches / "again")]
    print(f"this: {HERE}\nother: {other}\n")
    print(f"{'':40}{'this, ms':>12}{'other, ms':>12}{'this/other':>12}{'quartiles':>16}{'this/this':>12}")
    seconds = measure(workers, options.starts, options.rounds)
    slower, noise = [], []
    for name, (this, there, again) in seconds.items():
        (low, found, high), floor = ratios(this, there), ratios(again, this)[1]
        middle = [1e3 * statistics.median(column) for column in (this, there)]
        mark = "  slower" if found > LIMIT else ""
        spread = f"{low:.3f} to {high:.3f}"
        print(f"{name:40}{middle[0]:12.4g}{middle[1]:12.4g}{found:12.3f}{spread:>16}{floor:12.3f}{mark}")
        slower += [name] if mark else []
        noise.append(abs(floor - 1))
    print(f"\nslower by more than {100 * (LIMIT - 1):.0f} %: {', '.join(slower) or 'nothing'}")
    print(f"noise (this checkout against itself): median {statistics.median(noise):.1%}, largest {max(noise):.1%}")


if __name__ == "__main__":
    main()
