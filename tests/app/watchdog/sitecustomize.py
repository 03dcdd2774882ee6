"""Watches the event loop of a server that is started with this folder in PYTHONPATH.

Each turn of the loop is a line of the file VIBROSCOPE_TURNS: when it began and ended (`time.monotonic`), the processor
time that it took, and how often Bokeh walked over all models of a document in it.
"""

import asyncio.events
import json
import os
import sys
import threading
import time

TURN = "_run"  # the method of `Handle` that is a turn
run = getattr(asyncio.events.Handle, TURN)
_walks = 0
_counted = False
_out = open(os.environ["VIBROSCOPE_TURNS"], "a", buffering=1)  # noqa: SIM115 - for as long as the server


def _count_walks():
    global _counted
    module = sys.modules.get("bokeh.document.models")
    manager = getattr(module, "DocumentModelManager", None)
    if manager is None or _counted:
        return
    _counted, recompute = True, manager.recompute

    def counted(self):
        global _walks
        _walks += threading.current_thread() is threading.main_thread()
        recompute(self)

    manager.recompute = counted


def _watched(self):
    if threading.current_thread() is not threading.main_thread():
        return run(self)
    _count_walks()
    walks, begun, used = _walks, time.monotonic(), time.thread_time()
    try:
        return run(self)
    finally:
        used = time.thread_time() - used
        if used > 0.002 or _walks > walks:
            _out.write(json.dumps([begun, time.monotonic(), used, _walks - walks]) + "\n")


setattr(asyncio.events.Handle, TURN, _watched)
