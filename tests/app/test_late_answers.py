"""In whatever order jobs end, the page shows what belongs together, and at rest that of the last setting.

The rules stand in `app/page/updates.py`. The tab Explore runs with its queues, its explainer, its judge of motions and
the update channel, in a `World` in which hypothesis chooses what happens next.
"""

import random

import pytest
from bokeh.document import Document
from hypothesis import given, settings
from hypothesis import strategies as st
from vibroscope.app.page.updates import UpdateChannel

from tests.app.late_answers import SETTINGS, World
from tests.share import share

PLAY = st.lists(st.integers(0, 10_000), min_size=80, max_size=120)
OFTEN = 12  # one in so many events is by the user


def pick(choices, number):
    return choices[number % len(choices)]


def check_together(world):
    """What the findings say without a reserve is of one setting, that of the figures."""
    tab, content = world.tab, world.tab.findings.content
    shown = tab.shown_setting()
    if shown is None:
        assert content == {}
        return
    assert content["reference"] == f"reference at {shown.eta}"
    assert content.get("pending") or content["headline"] == f"verdict at {shown.eta}"
    assert all(kind[1] == f"kind at {shown.eta}" for kind in content["kinds"].values())


def check_rest(world):
    """Nothing is under way: what is shown is that of the last setting, but for what failed."""
    check_together(world)
    assert world.answered == world.number
    shown, content, failed = world.tab.shown_setting(), world.tab.findings.content, world.failed
    assert shown == world.setting or world.setting.eta in failed["runs"]
    if shown is not None:
        assert not content.get("pending") or shown.eta in failed["verdict"]
        assert content["kinds"] or shown.eta in failed["kinds"]


@settings(deadline=None, max_examples=share(60))
@given(PLAY)
def test_whatever_the_order_what_is_shown_at_rest_is_of_the_last_setting(play):
    with pytest.MonkeyPatch.context() as patch:
        world = World(patch)
        world.move(SETTINGS[0])
        for number in play:
            choice, others = number // OFTEN, world.choices()
            pick(world.user() if number % OFTEN == 0 or not others else others, choice)()
            check_together(world)
        rest = random.Random(sum(play))
        if not world.visible:
            world.back()
        while others := world.choices():
            rest.choice([*others, world.wait])()
        check_rest(world)


def test_an_update_that_had_to_wait_does_not_take_back_the_answer_to_a_newer_move():
    answers = []
    channel = UpdateChannel(Document(), lambda move, update: answers.append((move, update)))
    channel.push(1, lambda: None)
    channel.push(2, lambda: None)  # waits until the browser has painted the first
    channel.answer(3)  # which could not be computed
    channel.painted(1)
    assert answers == [(1, 1), (3, 1), (3, 2)]
    channel.answer()
    assert answers[-1] == (3, 2)
