"""``vibroscope serve``: start the explorer."""

import argparse
import gc
import os
import sys

from vibroscope.app.commands.parser import Command, OneLineParser
from vibroscope.app.runtime import settings
from vibroscope.app.runtime.settings import Settings, from_environment

_DEFAULT = Settings()


def port_number(text: str) -> int:
    """A TCP port."""
    if not (text.isascii() and text.isdigit() and int(text[:6]) < 65536):
        raise argparse.ArgumentTypeError(f"{text!r} is no port: give 0 to 65535")
    return int(text)


def add(command: OneLineParser) -> None:
    """Add the options."""
    port = f"port to listen on; 0 takes a free one (default {_DEFAULT.port})"
    command.add_argument("--port", type=port_number, metavar="N", help=port)
    command.add_argument("--address", help=f"address to listen on (default {_DEFAULT.address}: this machine only)")
    command.add_argument(
        "--origin",
        action="append",
        metavar="HOST:PORT",
        help="host that browsers may use, if not the address itself; may be repeated",
    )
    command.add_argument("--show", action="store_true", help="open it in a browser")


def run(options: argparse.Namespace) -> int:
    """Start the explorer; a worker solves the first scene while the page's packages are imported."""
    given = {"port": options.port, "address": options.address, "origins": options.origin and ",".join(options.origin)}
    chosen = from_environment(given=given)
    settings.use_settings(chosen)

    from vibroscope.app.commands.report import show_compilation
    from vibroscope.app.explorer import compute
    from vibroscope.app.runtime.compilation import compilation

    gc.disable()  # importing makes a million objects and no garbage; collecting would take half a second
    compute.warm()
    if chosen.log_format == "text":
        compilation.watch(show_compilation)
    from vibroscope.app.server.server import serve

    gc.freeze()
    gc.enable()
    try:
        serve(chosen, show=options.show)
    except BrokenPipeError:  # the reader of the output has closed it
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    except OSError as problem:
        raise OSError(f"cannot listen on {chosen.host}:{chosen.port}: {problem.strerror}") from problem
    return 0


COMMAND = Command("start the explorer", epilog=settings.describe(), add=add, run=run)
