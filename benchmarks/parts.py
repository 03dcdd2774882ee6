"""Prints cycles of each part of a flight, beside the least that its arithmetic could take.

    .venv/bin/python benchmarks/parts.py

There are two bounds. **Width**: a table product consists of fused products and sums, of which the processor does two
vectors a cycle. **Latency**: Horner's rule and Halley's method are chains, in which each operation waits for the one
before, four cycles for a product and sum, some fourteen for a division or a root. Each part is repeated on its own
result, so that it cannot overlap with itself, as in a run, where the next flight waits for this one. The clock is taken
from a chain of products and sums, four cycles each.

A flight of the reference with one impact a period (η = 2.76) consists of its first interval, one block, the interval of
the root, and the state there. A run takes longer than these parts by the impact law, time keeping and moves between
registers.

A skip of accelerated Newmark consists of rounds, one for each level of the tables: chunks of signed gaps, formed side
by side until one of them shows where contact may change, and a move. Their bound is the width of the chunks and the
latency of two sums of six products a round; turning 32 comparisons into one index, some twenty cycles, depends on the
processor.
"""

import time

import numba
from vibroscope.engine import Newmark, Reference, System, simulate
from vibroscope.engine.drivers.event_driven import set_up
from vibroscope.engine.kernels.accelerated.certificate import GROUP
from vibroscope.engine.kernels.linear import first_root, tables

LANES = 8  # of a vector: AVX-512; with AVX2 it is 4
FUSED, DIVISION = 4, 14  # cycles until the result is there
REPEATS = 100_000
TURNS = 7
# a state on the surface that has just parted, and one that reaches it within an interval
PARTED, FALLING = (-1.0, 3.0, 0.0, 5.0, 1.0, 0.0), (-1.0, 3.0, 0.05, -5.0, 1.0, 0.0)

compiled = numba.njit(error_model="numpy", fastmath={"contract"}, _nrt=False)
part = numba.njit(error_model="numpy", fastmath={"contract"}, _nrt=False, forceinline=True)


@part
def block(phase, z, scratch):
    """All values of a block, and the first that does not exceed the curvature bound."""
    tables.find_values(phase, z, scratch)
    level = tables.curvature_bound(phase, z)
    return float(first_root.first_at_most(scratch.products[: tables.POINTS], level, 0))


@part
def first_interval(phase, z, scratch):
    """An interval without a zero."""
    return first_root.first_zero_in_interval(phase, z, 1, scratch)[0]


@part
def zero(phase, z, scratch):
    """An interval with a zero, and the zero."""
    return first_root.first_zero_in_interval(phase, z, 0, scratch)[0]


@part
def state_there(phase, z, scratch):
    """ξ₁ and ξ₁′ within an interval."""
    return tables.position_at(phase, tables.state_after(phase, z, 30), 0.3, scratch)[1]


def width(products):
    """Cycles for so many products and sums side by side."""
    return products / LANES / 2


def chain(fused, divisions=0):
    """Cycles for operations that wait for each other."""
    return fused * FUSED + divisions * DIVISION


# even and odd powers apart: half as many steps as terms, then two to join them
POLYNOMIAL = chain(tables.TERMS // 2 + 2)
PARTS = {
    "first interval": (first_interval, PARTED, width(6 * 2 * tables.TERMS)),
    "block of 64 instants": (block, PARTED, width(6 * tables.POINTS)),
    # guess, three steps of Halley's method, the slope
    "interval of the zero": (
        zero,
        FALLING,
        width(6 * 2 * tables.TERMS) + chain(0, 1) + 3 * (POLYNOMIAL + chain(2, 1)) + POLYNOMIAL,
    ),
    "state there": (state_there, FALLING, width(6 * 6 + 6 * tables.TERMS) + POLYNOMIAL),
}

# η, K, D; chunks and rounds in a period of T/2000, counted once the motion has settled
SKIPS = {"A": (1.08, 2500.0, 8.0, 21, 9), "C": (2.76, 12000.0, 18.0, 5, 3)}


@compiled
def clock(n, x):
    """A chain of n products and sums."""
    for _ in range(n):
        x = x * x + 0.1
    return x


def least(run):
    """Least seconds of several turns; the first, which compiles, does not count."""
    run()
    seconds = []
    for _ in range(TURNS):
        begin = time.perf_counter()
        run()
        seconds.append(time.perf_counter() - begin)
    return min(seconds)


def repeated(function):
    """The function, each time on a state that depends on its last result."""

    @compiled
    def loop(phase, start, scratch, n):
        z = start
        for _ in range(n):
            result = function(phase, z, scratch)
            z = (start[0], start[1], start[2], start[3] + 1e-300 * result, start[4], start[5])
        return z[3]

    return loop


def run_seconds(eta, method, periods=20_000):
    """Seconds per period."""
    runs = [simulate(System(), eta, method, periods=periods, keep=1) for _ in range(TURNS)]
    return min(run.cost.seconds for run in runs) / periods


def main():
    """Print the table."""
    system = set_up(System(), 2.76, Reference("derived")).views
    cycle = least(lambda: clock(10_000_000, 0.1)) / 10_000_000 / FUSED
    print(f"{1e-9 / cycle:.2f} GHz\n\n{'part':24}{'ns':>8}{'cycles':>9}{'bound':>8}")
    total = floor = 0.0
    for name, (function, z, bound) in PARTS.items():
        loop = repeated(function)
        spent = least(lambda loop=loop, z=z: loop(system.flight, z, system.scratch, REPEATS)) / REPEATS
        total, floor = total + spent, floor + bound
        print(f"{name:24}{spent * 1e9:8.1f}{spent / cycle:9.0f}{bound:8.0f}")
    spent = run_seconds(2.76, Reference("derived"))
    print(f"{'sum':24}{total * 1e9:8.1f}{total / cycle:9.0f}{floor:8.0f}")
    print(f"{'a run, a period':24}{spent * 1e9:8.1f}{spent / cycle:9.0f}\n")
    for name, (eta, stiffness, damping, chunks, rounds) in SKIPS.items():
        spent = run_seconds(eta, Newmark(stiffness, damping, 2000))
        bound = chunks * width(6 * GROUP) + rounds * chain(12)
        print(f"{f'skips, a period [{name}]':24}{spent * 1e9:8.1f}{spent / cycle:9.0f}{bound:8.0f}")


if __name__ == "__main__":
    main()
