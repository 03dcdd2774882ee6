"""``vibroscope serve``: start the explorer."""

import argparse
import gc
import os
import signal
import sys

from .options import port_number


def add(commands) -> None:
    """``vibroscope serve``."""
    command = commands.add_parser("serve", allow_abbrev=False, help="start the explorer")
    command.add_argument(
        "--port",
        type=port_number,
        default=5006,
        metavar="N",
        help="port to listen on; 0 takes a free one (default %(default)s)",
    )
    command.add_argument(
        "--address", default="127.0.0.1", help="address to listen on (default %(default)s: this machine only)"
    )
    command.add_argument(
        "--origin",
        action="append",
        metavar="HOST:PORT",
        help="host that browsers may use, if not the address itself; may be repeated",
    )
    command.add_argument("--show", action="store_true", help="open it in a browser")
    command.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Start the explorer; the first scene is solved while the page's packages are imported, which takes longer."""
    from app import compute

    gc.disable()  # importing makes a million objects and no garbage; looking for it would take half a second
    compute.warm()
    from app.main import serve

    gc.freeze()
    gc.enable()
    # Panel's server ends gracefully on an interrupt; a service manager sends the other signal
    signal.signal(signal.SIGTERM, lambda number, frame: signal.raise_signal(signal.SIGINT))
    try:
        serve(address=options.address, port=options.port, show=options.show, origins=options.origin)
    except BrokenPipeError:  # whoever read the output has enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    except OSError as problem:
        raise OSError(f"cannot listen on {options.address}:{options.port}: {problem.strerror}") from problem
    return 0
