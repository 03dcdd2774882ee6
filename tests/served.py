"""A server in a process of its own, started as a user would start it."""

import os
import signal
import socket
import subprocess
import sys
import time
import urllib.request
from contextlib import contextmanager
from pathlib import Path

from tests.waiting import PATIENCE

ROOT = Path(__file__).parents[1]
COMMAND = (str(Path(sys.executable).parent / "vibroscope"), "serve")


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


class Served:
    """One server: its address, log, metrics, memory and processor time."""

    def __init__(self, log, command=COMMAND, cwd=ROOT, environment=None, **settings):
        """``settings`` are variables of the environment beside those of ``environment`` (default: this process's)."""
        self.port = free_port()
        address = settings.get("VIBROSCOPE_ADDRESS", "127.0.0.1")
        self.url = f"http://{f'[{address}]' if ':' in address else address}:{self.port}"
        self.log = log
        variables = {**(environment or os.environ), **settings, "VIBROSCOPE_PORT": str(self.port)}
        with log.open("w") as output:
            self.process = subprocess.Popen(command, cwd=cwd, env=variables, stdout=output, stderr=subprocess.STDOUT)

    def wait(self):
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end and self.process.poll() is None:
            try:
                urllib.request.urlopen(f"{self.url}/liveness", timeout=2).close()
                return self
            except OSError:
                time.sleep(0.05)
        raise AssertionError(f"no server: {self.log.read_text()}")

    def wait_for(self, holds, seconds=PATIENCE):
        """Poll until ``holds()``."""
        end = time.monotonic() + seconds
        while not holds():
            assert time.monotonic() < end, self.log.read_text()
            time.sleep(0.05)

    def metric(self, line):
        """One number of /metrics by the beginning of its line, 0 if there is none yet."""
        text = urllib.request.urlopen(f"{self.url}/metrics", timeout=PATIENCE).read().decode()
        return next((float(row.split()[-1]) for row in text.splitlines() if row.startswith(line)), 0.0)

    def memory(self):
        """Resident megabytes."""
        status = Path(f"/proc/{self.process.pid}/status").read_text()
        return int(status.split("VmRSS:")[1].split()[0]) / 1000

    def cpu(self):
        """Seconds of processor time so far."""
        fields = Path(f"/proc/{self.process.pid}/stat").read_text().rsplit(")", 1)[1].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")

    def stop(self, number=signal.SIGTERM):
        """Exit status."""
        if self.process.poll() is None:
            self.process.send_signal(number)
        try:
            return self.process.wait(PATIENCE)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
            raise


@contextmanager
def served(log, **options):
    server = Served(log, **options)
    try:
        yield server.wait()
    finally:
        server.stop()
