"""Explanations: that of the setting that is shown, whatever else is being explained, and never another one."""

import time

import pytest
from vibroscope.app.explorer.state import Setting
from vibroscope.app.page.explore import explainer as module
from vibroscope.app.page.explore.explainer import Explainer
from vibroscope.app.runtime.cache import Cache
from vibroscope.engine import Cancelled

from tests.app.fakes import QueueingHost
from tests.waiting import wait_until

SLOW, NEXT, LAST = (Setting()._replace(eta=eta) for eta in (1.0, 1.1, 1.2))
SEARCHED = Setting()._replace(eta=1.3)  # whose curves come first


class Document:
    """Calls back at once what should be called after a rest."""

    def add_timeout_callback(self, callback, _):
        callback()


@pytest.fixture
def explained(monkeypatch):
    """Stands for the engine: the explanation of SLOW never ends by itself."""
    seen = []

    def explain(runs, cancelled, on_judged, on_alone):
        seen.append(runs)
        if runs is SEARCHED:
            on_alone(f"curves of {runs.eta}")
            on_alone("curves a moment later")
        while runs is SLOW:
            if cancelled():
                raise Cancelled
            time.sleep(0.002)
        return f"of {runs.eta}"

    monkeypatch.setattr(module, "EXPLANATIONS", Cache(1))
    monkeypatch.setattr(module, "compute_runs", lambda setting, cancelled: setting)
    monkeypatch.setattr(module, "explain", explain)
    return seen


def explaining(seen, setting):
    wait_until(lambda: setting in seen, what=f"the explanation of {setting} begun")


def test_an_explanation_that_takes_for_ever_keeps_neither_another_session_waiting_nor_its_own(explained):
    host, other, shown = QueueingHost(doc=Document()), QueueingHost(doc=Document()), []
    explainer = Explainer(host, lambda: True, shown.append)
    explainer.follow(SLOW)
    explaining(explained, SLOW)
    Explainer(other, lambda: True, shown.append).follow(NEXT)
    other.catch_up()
    assert shown == ["of 1.1"]
    explainer.drop()  # the page computes the next setting
    explainer.follow(LAST)
    host.catch_up()
    assert shown == ["of 1.1", "of 1.2"]


def test_an_explanation_that_comes_too_late_is_not_shown_and_a_full_cache_loses_none(explained):
    host, shown = QueueingHost(doc=Document()), []
    explainer = Explainer(host, lambda: True, shown.append)
    explainer.follow(NEXT)
    explaining(explained, NEXT)
    explainer.follow(LAST)
    explaining(explained, LAST)
    host.catch_up()  # NEXT is ready, and the page shows LAST
    assert shown == []
    module.EXPLANATIONS.put("other sessions", "fill the cache")
    host.catch_up()
    assert shown == ["of 1.2"]


def test_curves_come_before_the_explanation_and_those_of_another_setting_are_not_shown(explained):
    host, shown = QueueingHost(doc=Document()), []
    explainer = Explainer(host, lambda: True, shown.append, shown.append)
    explainer.follow(SEARCHED)
    host.catch_up()
    assert shown == ["curves of 1.3"]
    host.catch_up()  # the loop has other things to do: no second curves at once
    assert shown == ["curves of 1.3", "of 1.3"]
    module.EXPLANATIONS.put("other sessions", "fill the cache")
    explained.clear()
    explainer.follow(SEARCHED)
    explaining(explained, SEARCHED)
    explainer.follow(LAST)
    for _ in range(3):  # curves and explanation of SEARCHED, which is shown no more, and LAST
        host.catch_up()
    assert shown[2:] == ["of 1.2"]
