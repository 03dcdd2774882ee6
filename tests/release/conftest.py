"""The long tests of `make release`: thousands of fuzzed inputs, faults, hostile clients, a stop under load, a soak.

They print their figures, and the sums at the end. ``RELEASE_INPUTS`` sets how many inputs of each kind are tried,
``RELEASE_SEED`` makes them others, ``RELEASE_SETTINGS`` sets how many settings a verdict is tested of, ``RELEASE_SOAK``
sets the seconds of the soak; many visitors at once, and a thousand that come and go, are measured by
``benchmarks/sessions.py``.
"""

import json
import os
import random
from collections import Counter
from pathlib import Path

import pytest

from tests.served import served

SUMS = pytest.StashKey[Counter]()


def pytest_configure(config):
    config.stash[SUMS] = Counter()


def pytest_collection_modifyitems(items):
    for item in items:
        if Path(__file__).parent in item.path.parents:
            item.add_marker(pytest.mark.release)


def pytest_terminal_summary(terminalreporter, config):
    sums = config.stash[SUMS]
    skipped = [report.longrepr[2].removeprefix("Skipped: ") for report in terminalreporter.stats.get("skipped", [])]
    failed = sum(len(terminalreporter.stats.get(end, [])) for end in ("failed", "error"))
    if sums or skipped:
        text = f"{sums['inputs']} inputs tried, {sums['faults']} faults survived, {sums['sessions']} sessions held"
        end = f"NOT HELD: {failed} checks" if failed else "nothing lost"
        if skipped:
            end += f" in what was tried; NOT TRIED: {len(skipped)} checks ({', '.join(sorted(set(skipped)))})"
        terminalreporter.write_line(f"release: {text}, {end}")


@pytest.fixture(scope="session")
def inputs():
    return int(os.environ.get("RELEASE_INPUTS", "12000"))


@pytest.fixture
def chance(request):
    """Random choices of a test's own; others with another ``RELEASE_SEED``."""
    return random.Random(f"{request.node.name} {os.environ.get('RELEASE_SEED', '1')}")


@pytest.fixture
def report(request, capsys):
    """Prints a line of figures and adds to the sums: ``inputs``, ``faults`` (one per scenario), ``sessions``."""

    def report(text, **counted):
        request.config.stash[SUMS].update(counted)
        with capsys.disabled():
            print(f"\n{text}")

    return report


@pytest.fixture(scope="module")
def server(tmp_path_factory):
    """A server whose log, at the end, is JSON line by line, with no traceback and no answer of 500."""
    with served(tmp_path_factory.mktemp("release") / "log.txt", VIBROSCOPE_LOG_FORMAT="json") as server:
        yield server
    lines = [json.loads(line) for line in server.log.read_text().splitlines()]
    assert not [line for line in lines if "traceback" in line][:1]
    assert not [line for line in lines if line["event"] == "answered" and line.get("status", 0) >= 500]
