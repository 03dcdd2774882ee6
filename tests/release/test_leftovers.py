"""Visitors who use everything leave no object of theirs behind: no session, model, component, job, task or handle.

What they computed may stay in caches, whose entries are bounded; those are objects of the engine and of studies.
"""

import asyncio
import itertools
import json
import signal
import sys
import time
from pathlib import Path

from tests.release.odd import run
from tests.release.soak import FREED, Soak
from tests.served import served

FIRST, MORE, AT_ONCE = 16, 16, 4  # visits; until the first have been, modules are loaded and pools fill
OF_VISITS = (
    *("bokeh.", "panel.", "param.", "tornado.", "socket.", "ssl.", "_io.", "threading.", "concurrent."),
    *("asyncio.tasks.", "asyncio.futures.", "_asyncio.", "builtins.coroutine", "builtins.async", "builtins.generator"),
    *(
        "builtins.method",
        "builtins.cell",
        "builtins.frame",
        "functools.",
    ),  # functions come with kernels that are loaded
    *("vibroscope.app.page.", "vibroscope.app.server.", "vibroscope.app.runtime.", "vibroscope.app.export."),
)


def counted(server, file):
    """How many objects of each class the server has while nobody is there."""
    server.wait_for(lambda: not server.metric("vibroscope_sessions "), 120)
    time.sleep(FREED)
    file.unlink(missing_ok=True)
    server.process.send_signal(signal.SIGUSR1)
    server.wait_for(file.exists, 60)
    return json.loads(file.read_text())


async def visits(soak, numbers):
    async def visitor():
        for number in numbers:
            await soak.visit(number)

    await asyncio.gather(*(visitor() for _ in range(AT_ONCE)))


def test_visits_leave_no_object_of_theirs(tmp_path, report):
    file, numbers = tmp_path / "counts.json", itertools.count()
    command = (sys.executable, Path(__file__).with_name("counted_server.py"), file)
    with served(tmp_path / "log.txt", command=command, VIBROSCOPE_LOG_LEVEL="warning") as server:
        soak, counts = Soak(server), []
        for number in (FIRST, MORE):
            run(visits(soak, itertools.islice(numbers, number)))
            counts.append(counted(server, file))
    before, after = counts
    grown = {name: n - before.get(name, 0) for name, n in after.items() if n - before.get(name, 0) >= MORE}
    report(f"{soak.visits} visits: after {MORE} more than {FIRST}, grown: {grown}", sessions=soak.visits)
    assert any(name.startswith("bokeh.") for name in after)  # of the session that is kept ready
    assert not [name for name in grown if name.startswith(OF_VISITS)]
