"""The explorer serves with any cache folder: full, read-only or damaged."""

import json
import shutil
import subprocess
from contextlib import contextmanager, suppress

import pytest
from vibroscope.engine.kernels.compile.options import cache_root, source_digest

from tests.browserless import Client, mapped
from tests.release.odd import damaged, run
from tests.served import served


@contextmanager
def small_disk(folder, kilobytes):
    """A folder on a file system of this size."""
    folder.mkdir()
    if subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={kilobytes}k", "tmpfs", folder]).returncode:
        pytest.skip("mounting needs root")
    try:
        yield folder
    finally:
        subprocess.run(["umount", "--lazy", folder], check=True)


def serves(tmp_path, cache):
    """Assert that a session can move and run a study, without a traceback."""

    async def steps():
        async with Client(server.url) as client:
            client.patience = 1500  # the kernels compile first, all of them where none can be stored
            await client.ready()
            shown = await client.set(1, eta="1.5")
            await client.patch(client.message(mapped({"view": "step", "move": 2}), "Header"))
            while '"complete"' not in json.dumps((await client.receive())["content"]):
                pass
            return shown

    with served(tmp_path / "log.txt", VIBROSCOPE_CACHE_DIR=str(cache)) as server:
        assert run(steps(), 1800)["texts"]["eta"] == "1.5"
    assert "Traceback" not in (tmp_path / "log.txt").read_text()


@pytest.mark.parametrize("fault", ["full", "read-only"])
def test_nothing_can_be_stored(fault, tmp_path, report):
    with small_disk(tmp_path / "cache", 256) as cache:
        if fault == "full":
            with suppress(OSError):
                (cache / "filler").write_bytes(b"x" * 300_000)
        else:
            subprocess.run(["mount", "-o", "remount,ro", cache], check=True)
        serves(tmp_path, cache)
    report(f"cache folder {fault}: served, no traceback", faults=1, sessions=1)


def test_every_tenth_kernel_and_every_other_file_of_a_study_is_damaged(tmp_path, chance, report):
    cache = tmp_path / "cache"
    kernels = cache / f"kernels-{source_digest()}"
    shutil.copytree(cache_root() / kernels.name, kernels)
    serves(tmp_path, cache)  # keeps the study of the time step
    compiled, kept = (
        sorted(path for path in folder.rglob("*") if path.is_file()) for folder in (kernels, cache / "studies")
    )
    assert len(kept) > 2
    hit = chance.sample(compiled, len(compiled) // 10) + chance.sample(kept, len(kept) // 2)
    for path in hit:
        path.write_bytes(damaged(chance, path.read_bytes()))
    for _ in range(2):  # what was damaged does not stop it again
        serves(tmp_path, cache)
    report(
        f"{len(hit)} of {len(compiled)} kept kernels and {len(kept)} files of studies damaged: served, no traceback",
        faults=1,
        inputs=len(hit),
        sessions=3,
    )
