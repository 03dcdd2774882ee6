"""A world in which a test decides what happens next: threads, timers, loop, clock and browser around the tab Explore.

Jobs run in threads, but only one thread runs at any time: a job waits before it begins, after each lock that it has
held, and in its solver, until the test lets it go on.
"""

import threading
from types import SimpleNamespace
from unittest.mock import MagicMock

from bokeh.document import Document
from vibroscope.app.explorer import compute
from vibroscope.app.explorer.compute import JobQueue, RunPair
from vibroscope.app.explorer.explanation import Description, Explanation
from vibroscope.app.explorer.motion_kind import MotionKind
from vibroscope.app.explorer.state import Setting
from vibroscope.app.page.explore import explainer
from vibroscope.app.page.explore import tab as explore
from vibroscope.app.page.explore.result import Result
from vibroscope.app.page.tab import Move
from vibroscope.app.page.updates import UpdateChannel
from vibroscope.app.runtime.cache import Cache
from vibroscope.engine import Cancelled

SETTINGS = [Setting()._replace(eta=eta) for eta in (1.0, 1.1, 1.2)]
SETTINGS.append(SETTINGS[0]._replace(frame="absolute"))  # the same runs, drawn in another way
# What Explore is made of but for its findings: figures, and what neither explains nor judges.
DRAWN = ("pn", "MotionView", "EtaMapView", "ColumnSender", "Mechanism")
DRAWN += ("Suggester", "CoexistingMotions", "OpenedMotion", "Muting", "PinComparison")
DRAWN += ("PinnedResults", "Overlay", "MapSource", "AloneView")


class Job:
    """Work of a pool, in a thread that runs only within `go_on`."""

    def __init__(self, work):
        self._turn, self._back = threading.Semaphore(0), threading.Semaphore(0)
        self._thread = threading.Thread(target=self._run, args=[work], daemon=True)
        self._thread.job = self
        self.begun = self.done = self.solves = False
        self._order = ""

    def _run(self, work):
        work()
        self.done = True
        self._back.release()

    def go_on(self, order):
        """Run to the next stop; ``order`` says what the solver does: "ask" whether it is cancelled, "end" or "fail"."""
        self._order = order
        if self.begun:
            self._turn.release()
        else:
            self.begun = True
            self._thread.start()
        self._back.acquire()

    def stop(self, *, solves=False):
        self.solves = solves
        self._back.release()
        self._turn.acquire()
        return self._order


class Lock:
    """After it was held in a job, anything else may happen."""

    def __enter__(self):
        pass

    def __exit__(self, *_):
        if (job := getattr(threading.current_thread(), "job", None)) is not None:
            job.stop()


class Queue(JobQueue):
    def __init__(self, *parts, **options):
        super().__init__(*parts, **options)
        self._lock = Lock()


class World(Document):
    """The document of a session and the `TabHost` of its tab, and everything that may happen next: see `choices`."""

    view_titles = MagicMock()
    pinned = ()

    def __init__(self, monkeypatch):
        super().__init__()
        self.doc = self
        self.jobs, self.timers, self.calls = [], [], []
        self.now, self.number, self.answered, self.painted = 0.0, 0, 0, 0
        self.setting, self.visible = SETTINGS[0], True
        self.failed = {"runs": set(), "verdict": set(), "kinds": set()}
        self.known = {}
        channel = UpdateChannel(self, lambda move, _: setattr(self, "answered", move))
        self.channel, self.push = channel, channel.push
        self._stand_in(monkeypatch)
        self.tab = explore.Explore(self)
        self.tab.build()

    def _stand_in(self, monkeypatch):
        """For the engine, the pools and the clock."""
        put = monkeypatch.setattr
        put(compute, "own_time", lambda: self.now)
        for part in DRAWN:
            put(explore, part, MagicMock())
        explore.MotionView.return_value.draw_beside.return_value = []  # no curves are missing
        put(compute.compilation, "when_done", lambda act, needs=None: act())
        put(compute, "give_way", lambda: None)
        put(explore, "JobQueue", lambda deliver, solve: Queue(deliver, solve=solve, pool=self))
        put(explore, "compute_runs", self._solve_runs)
        put(explore, "prepare", lambda runs: Result(runs.setting, MagicMock(), description_of(runs.setting)))
        put(explainer, "background_worker", lambda: SimpleNamespace(submit=self.submit, jobs=0))
        put(explainer, "kind_threads", lambda: self)
        put(explainer, "EXPLANATIONS", Cache(2))
        put(explainer, "compute_runs", lambda setting, _: RunPair(setting, None, None))
        put(explainer, "explain", lambda runs, cancelled, *_: self._solve("verdict", runs.setting, cancelled))
        put(explainer, "judge_motions", lambda setting, cancelled: self._solve("kinds", setting, cancelled))
        put(explainer, "known_kinds", lambda setting: self.known.get(setting.eta))

    def _solve_runs(self, setting, cancelled):
        return self._solve("runs", setting, cancelled)

    def _solve(self, what, setting, cancelled):
        while (order := threading.current_thread().job.stop(solves=True)) == "ask":
            if cancelled():
                raise Cancelled
        if order == "fail":
            self.failed[what].add(setting.eta)
            raise ValueError("no result")
        if what == "kinds":
            self.known[setting.eta] = kinds_of(setting)
        runs = RunPair(setting, None, None)
        return {"runs": runs, "verdict": explanation_of(setting), "kinds": kinds_of(setting)}[what]

    # -- what a tab asks of the page, a queue of its pool, and a channel of the document

    def submit(self, work, session=""):
        self.jobs.append(Job(work))

    def call_later(self, callback):
        self.calls.append(callback)

    def add_models(self, add, then):
        add()
        then()

    def add_timeout_callback(self, callback, _):
        self.timers.append(callback)

    def report_error(self, text, move=None):
        self.channel.answer(self.number if move is None else move)

    def set(self, texts):
        pass

    def summarise(self, text):
        pass

    def update_offers(self):
        pass

    # -- what may happen

    def choices(self):
        """What may happen of itself, as functions."""
        self.jobs = [job for job in self.jobs if not job.done]
        found = [lambda job=job, order=order: job.go_on(order) for job in self.jobs for order in _orders(job)]
        found += [lambda i=i: self.timers.pop(i)() for i in range(len(self.timers))]
        found += [lambda: self.calls.pop(0)()] if self.calls else []  # a loop calls in the order of the requests
        return found + ([self.paint] if self.channel.count > self.painted else [])

    def paint(self):
        """The browser has painted the last update."""
        self.painted = self.channel.count
        self.channel.painted(self.painted)

    def user(self):
        """What the user may do, and the time that passes."""
        found = [lambda setting=setting: self.move(setting) for setting in SETTINGS]
        return [*found, self.leave if self.visible else self.back, self.wait]

    def move(self, setting):
        self.setting = setting
        self.number += 1
        if self.visible:
            self.tab.show(Move(self.number, setting))

    def leave(self):
        self.visible = False
        self.tab.hide()
        self.push(self.number, lambda: None)  # of the other tab

    def back(self):
        self.visible = True
        self.number += 1
        self.tab.show(Move(self.number, self.setting))

    def wait(self):
        self.now += 1.0


def _orders(job):
    return ("ask", "end", "end", "fail") if job.solves else ("",)


def description_of(setting):
    return Description((f"reference at {setting.eta}", ""), (f"penalty at {setting.eta}", ""), ())


def explanation_of(setting):
    return Explanation(
        headline=f"verdict at {setting.eta}",
        agree="yes",
        kinds={},
        measure="",
        parts={},
        note="",
        change={},
        details=(),
        series={},
    )


def kinds_of(setting):
    return {"reference": MotionKind("periodic", f"kind at {setting.eta}", "")}
