"""Prints cost of Zarr and npz chunks of a study, and an estimate of a plane of 10⁸ cells on 100 machines.

.venv/bin/python benchmarks/stores.py

First the same plane is stored twice: by the sweeps' own Zarr store, and as one npz file a chunk, renamed into place,
from which a Zarr result is made in the end. Then the inputs of the estimate, all measured here: seconds of computing a
cell and of encoding and writing a chunk, its bytes, and the cost of sending it through a Dask scheduler on this
machine. The cost of a network is not measured: a chunk is a minute of work and a megabyte.
"""

import os
import pickle
import statistics
import tempfile
import time
from pathlib import Path

import numpy as np
import xarray
from vibroscope.engine import Newmark, System
from vibroscope.engine.sweeps.batches import chunk_shape, chunks
from vibroscope.engine.sweeps.plane_study import PlaneStudy
from vibroscope.engine.sweeps.store import Store
from vibroscope.engine.sweeps.store_location import StoreLocation

REPEATS = 3
CELLS, MACHINES, CORES = 10**8, 100, 16  # of the estimate
TRANSIENT, SAMPLE, STEPS = 450, 50, 2000


def study(side, parts=True):
    K, D = np.geomspace(100, 60_000, side), np.geomspace(1, 100, side)
    return PlaneStudy(
        System(), Newmark(K[0], D[0], STEPS), 2.76, transient=TRANSIENT, sample=SAMPLE, K=K, D=D, parts=parts
    )


def as_zarr(plane, order, results, folder):
    """Seconds to write all chunks, to look through them as a resumed run does, and to open them as a Dataset."""
    store = Store(StoreLocation(folder))
    store.claim(plane)
    store.create(plane, tuple(part.stop for part in order[0]))
    write = timed(lambda: [store.write_now(chunk, values) for chunk, values in zip(order, results, strict=True)])
    look = timed(lambda: [store.read(chunk) for chunk in order])
    return write, look, timed(lambda: xarray.open_zarr(folder).load())


def as_npz(plane, order, results, folder):
    """The same; to open them is to read all files and write the Dataset."""
    folder.mkdir()
    names = [folder / f"{'-'.join(str(part.start) for part in chunk)}.npz" for chunk in order]

    def write():
        for name, values in zip(names, results, strict=True):
            part = name.with_suffix(".part")
            with part.open("wb") as file:
                np.savez_compressed(file, **values)
            os.replace(part, name)

    def read():
        found = []
        for name in names:
            with np.load(name) as content:
                found.append({key: content[key] for key in content.files})
        return found

    def gather():
        as_zarr(plane, order, read(), folder.with_name("gathered"))

    return timed(write), timed(read), timed(gather)


def timed(work):
    begun = time.perf_counter()
    work()
    return time.perf_counter() - begun


def size(folder):
    return sum(path.stat().st_size for path in Path(folder).rglob("*") if path.is_file())


def compare(plane, order, results):
    """Print both, interleaved, medians."""
    seconds = {as_zarr: [], as_npz: []}
    sizes = {}
    with tempfile.TemporaryDirectory() as root:
        for repeat in range(REPEATS):
            for keep in seconds:
                folder = Path(root) / f"{keep.__name__}-{repeat}" / "data"
                folder.parent.mkdir()
                seconds[keep].append(keep(plane, order, results, folder))
                sizes[keep] = size(folder)
    print(f"{len(order)} chunks of {results[0]['status'].size} cells, {len(results[0])} variables; ms a chunk")
    print(f"{'':8}{'write':>10}{'look through':>14}{'open all':>12}{'kB a chunk':>12}{'files a chunk':>15}")
    for keep, rounds in seconds.items():
        write, look, opened = (1e3 * statistics.median(column) / len(order) for column in zip(*rounds, strict=True))
        files = 1 if keep is as_npz else len(results[0])
        print(
            f"{keep.__name__[3:]:8}{write:10.1f}{look:14.1f}{opened:12.1f}"
            f"{sizes[keep] / len(order) / 1e3:12.1f}{files:15}"
        )
    return statistics.median(write for write, *_ in seconds[as_zarr]) / len(order), sizes[as_zarr] / len(order)


def send(values):
    """Seconds and bytes of sending a chunk from a worker to this process."""
    from distributed import Client, LocalCluster

    with LocalCluster(n_workers=1, threads_per_worker=1, dashboard_address=None) as cluster, Client(cluster) as client:
        futures = [client.submit(result_of, values, pure=False) for _ in range(3)]
        client.gather(futures)  # warm
        futures = [client.submit(result_of, values, pure=False) for _ in range(20)]
        seconds = timed(lambda: [future.result() for future in futures]) / len(futures)
    return seconds, len(pickle.dumps(values))


def result_of(values):
    """Stands for the computation on a worker."""
    return values


def estimate(rows, cells, write, stored, sent):
    """Print the estimate and its inputs, with and without errors."""
    seconds, weight = sent
    pieces = CELLS / cells
    one_by_one = pieces * (seconds + write) / 3600
    print(f"\na chunk of {cells} cells: {1e3 * write:.0f} ms to encode and write, {stored / 1e3:.0f} kB stored,")
    print(f"{weight / 1e3:.0f} kB sent in {1e3 * seconds:.1f} ms from a worker to the client, both on this machine")
    size_of_all = pieces * stored / 1e9
    print(f"\n{CELLS:.0e} cells on {MACHINES} machines of {CORES} such cores:", end=" ")
    print(f"{pieces:.0f} chunks, {size_of_all:.1f} GB")
    for name, compute in rows.items():
        hours = (CELLS * compute + pieces * write) / MACHINES / CORES / 3600
        print(f"  {name:24}{1e6 * compute:8.0f} us a cell and core {60 * hours:8.1f} min, workers writing to a bucket")
    print(f"  a client that writes all to its own folder takes {60 * one_by_one:.1f} min at least")


def main():
    """Measure and print."""
    small = {"Newmark alone": study(32, parts=False), "with exact and errors": study(32)}
    for plane in small.values():
        plane.cut((slice(0, 4), slice(0, 4))).compute(threads=1)  # compiled, or read from the cache
    rows = {name: timed(lambda plane=plane: plane.compute(threads=1)) / plane.cells for name, plane in small.items()}
    large = small["with exact and errors"]
    sides = chunk_shape((10_000, 10_000), large.periods_per_cell, large.numbers_per_cell)
    plane = study(2 * sides[0])
    order = list(chunks(plane.shape, sides))
    computed = large.compute()  # its numbers stand for those of every chunk
    results = [{name: np.resize(values, sides) for name, values in computed.items()} for _ in order]
    write, stored = compare(plane, order, results)
    estimate(rows, int(np.prod(sides)), write, stored, send(results[0]))


if __name__ == "__main__":
    main()
