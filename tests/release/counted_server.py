"""A server that counts its objects by class, after a full collection, when it gets SIGUSR1: counted_server.py FILE."""

import gc
import json
import signal
import sys
from collections import Counter
from pathlib import Path

from vibroscope.app.commands.cli import main


def count(*_):
    gc.collect()
    counts = Counter(f"{type(each).__module__}.{type(each).__qualname__}" for each in gc.get_objects())
    part = Path(sys.argv[1]).with_suffix(".part")
    part.write_text(json.dumps(counts))
    part.rename(sys.argv[1])  # whoever finds the file finds it whole


if __name__ == "__main__":
    signal.signal(signal.SIGUSR1, count)
    sys.exit(main(["serve"]))
