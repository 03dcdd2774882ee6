"""Watches the event loop of a server that is started with this folder in PYTHONPATH.

Each turn of the loop is a line of the file VIBROSCOPE_TURNS: when it began and ended (`time.monotonic`), how many
functions were called in it, which unlike its time does not depend on what else the machine does, and how often Bokeh
walked over all models of a document.
"""

import asyncio.events
import json
import os
import sys
import threading
import time

TURN = "_run"  # the method of `Handle` that is a turn
run = getattr(asyncio.events.Handle, TURN)
FEW = 1000  # calls of a turn that is not noted
_walks = _calls = 0
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


def _count(frame, event, argument):
    global _calls
    _calls += event in ("call", "c_call")


def _watched(self):
    if threading.current_thread() is not threading.main_thread():
        return run(self)
    _count_walks()
    global _calls
    walks, begun, _calls = _walks, time.monotonic(), 0
    sys.setprofile(_count)
    try:
        return run(self)
    finally:
        sys.setprofile(None)
        if _calls > FEW or _walks > walks:
            _out.write(json.dumps([begun, time.monotonic(), _calls, _walks - walks]) + "\n")


setattr(asyncio.events.Handle, TURN, _watched)
