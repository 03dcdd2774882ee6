"""A tab that was reached by many moves asks what the tab of its link asks: nothing else counts in a question."""

import random

import pytest
from vibroscope.app.codes.catalogue import codes
from vibroscope.app.explorer.presets import opening_setting, shelf
from vibroscope.app.explorer.reading import read_setting
from vibroscope.app.explorer.state import Setting
from vibroscope.app.page.bifurcation.tab import Bifurcation
from vibroscope.app.page.study.tab import StudyView
from vibroscope.app.page.tab import Move
from vibroscope.app.page.tabs import VIEWS
from vibroscope.app.studies.your_code import code_texts

from tests.app.fakes import FakeHost
from tests.app.test_study_tab import opened  # noqa: F401 - a fixture

STUDIES = [tab for tab in VIEWS.values() if issubclass(tab, StudyView)]
MOVES, EVERY = 40, 8  # moves of a walk, and after how many it is compared with its link
SETTINGS = [Setting(), opening_setting(), *(each.setting for each in shelf().values())]
SETTINGS += [read_setting(code_texts(code), Setting()) for code in codes().values()]
CHANGES = {"eta": (0.7, 2.0), "K": (90.0, 2e4), "D": (0.0, 7.0), "steps": (300, 9000), "units": ("none", "si")}
CHANGES |= {"frame": ("absolute", "relative"), "start_xi1": (-1.0, -0.123456789), "base": (0.0, 1.0)}
FACTORS = (0.2, 0.97, 1.3, 5.0)


class Walk:
    """Random moves on one tab."""

    def __init__(self, kind, seed):
        self.tab, self.draw, self.setting = built(kind), random.Random(seed), Setting()
        self.tab.show(Move(1, self.setting))

    def step(self):
        moves = [self._set, self._set, self._choose, self._choose, self._type, self._zoom, self._reopen]
        moves += [self._follow] if isinstance(self.tab, Bifurcation) else []
        self.draw.choice(moves)()

    def _set(self):
        if self.draw.random() < 0.5:
            self.setting = self.draw.choice(SETTINGS)
        else:
            name = self.draw.choice(list(CHANGES))
            self.setting = self.setting._replace(**{name: self.draw.choice(CHANGES[name])})
        self.tab.show(Move(2, self.setting, self.draw.random() < 0.3))

    def _choose(self):
        """Take a choice that the panel does not hide."""
        spec, away = self.tab.panel.spec, self.tab.panel.away
        wanted = {
            each["name"]: self.draw.choice([one for one in each["choices"] if one not in away.get(each["name"], ())])
            for each in spec["switches"]
        }
        if wanted:
            name = self.draw.choice(list(wanted))
            self.tab.panel.receive({"choose": {name: wanted[name]}})

    def _type(self):
        panel = self.tab.panel
        numbers = [each for each in panel.spec.get("numbers", []) if each.get("mode") != "text"]  # not in an address
        names = [each["name"] for each in numbers if each["name"] not in panel.away]
        if names:
            name = self.draw.choice(names)
            number = (panel.chosen.get(name) or 1) * self.draw.choice(FACTORS)
            panel.receive({"choose": {name: f"{number:.9g}"}})

    def _zoom(self):
        owned = self.draw.choice(list(self.tab.ranges.values()))
        (low, high), shares = owned.ends, sorted((self.draw.uniform(0.05, 0.6), self.draw.uniform(0.65, 0.95)))
        owned.range.update(start=low + shares[0] * (high - low), end=low + shares[1] * (high - low))
        self.tab.refresh()

    def _reopen(self):
        self.tab.hide()
        self._set()

    def _follow(self):
        self.tab.follow(self.setting)
        self.tab.show(Move(3, self.setting))


def built(kind):
    tab = kind(FakeHost())
    tab.build()
    return tab


def asked(tab, setting):
    """What a tab computes and where its axes are."""
    found = {"question": tab.question(setting), "chosen": dict(tab.panel.chosen), "view": tab.view_texts()}
    found |= {name: (owned.ends, owned.home) for name, owned in tab.ranges.items()}
    if tab.searches is not None:
        found["searches"] = tab.search_questions(setting)
    return found


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("kind", STUDIES, ids=lambda kind: kind.key)
def test_a_walk_and_its_link_ask_the_same(opened, monkeypatch, kind, seed):  # noqa: F811
    walk = Walk(kind, seed)
    for count in range(1, MOVES + 1):
        walk.step()
        if count % EVERY == 0:
            linked = built(kind)
            linked.restore(kind.read_view(**walk.tab.view_texts()))
            linked.show(Move(1, walk.setting))
            walked, again = asked(walk.tab, walk.setting), asked(linked, walk.setting)
            for name, value in walked.items():
                assert again[name] == value
