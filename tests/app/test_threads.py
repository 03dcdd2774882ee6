"""The threads of a server follow its setting, not the number of cores."""

import asyncio
import os
import re
from pathlib import Path

import pytest
import yaml

from tests.browserless import Client, get, mapped
from tests.served import ROOT, served
from tests.waiting import PATIENCE

CORES = 64
# Two solvers, and two of the loop; two explanations; four studies and two searches, of which each starts two; the
# checks and what they start; one each for kinds of motion, files and compiler; four of the stores.
FEW, MOST = 8, 40


def threads(server):
    return len(os.listdir(f"/proc/{server.process.pid}/task"))


TABS = ("view=plane", "view=bifurcation", "view=step", "view=paper")  # sweeps
TABS += ("view=bifurcation&choice=branches:on", "view=plane&choice=curves:on", "view=basin")  # searches


@pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="counts threads in /proc")
def test_a_server_with_two_threads_starts_few_on_a_machine_with_many_cores(tmp_path):
    (tmp_path / "sitecustomize.py").write_text(f"import os\nos.cpu_count = lambda: {CORES}\n")
    counted = []

    async def busy(server, query, number):
        async with Client(server.url, f"eta=1.{number}71&{query}") as client:
            await client.ready()
            await client.patch(client.message(mapped({"take": "report"}), "Header"))
            looks = 0
            while looks < 10 or max(counted) <= FEW:
                looks += 1
                await asyncio.wait([asyncio.ensure_future(client.receive())], timeout=0.5)
                counted.append(threads(server))

    async def all_of_them(server):
        scripts = set(re.findall(r'src="(static/[^"]+)"', (await get(server.url)).body.decode()))
        fetched = [get(f"{server.url}/{path}", headers={"Accept-Encoding": "gzip"}) for path in scripts]
        await asyncio.gather(*fetched, *(busy(server, query, number) for number, query in enumerate(TABS)))

    with served(tmp_path / "log.txt", VIBROSCOPE_THREADS="2", PYTHONPATH=str(tmp_path)) as server:
        asyncio.run(asyncio.wait_for(all_of_them(server), PATIENCE))
    allowed = yaml.safe_load((ROOT / "compose.yaml").read_text())["x-app"]["pids_limit"]
    assert FEW < max(counted) <= MOST < allowed
