"""What a newcomer meets: the question, the opening scene, the tour to a suggestion, the exercises."""

import pytest
from vibroscope.app import QUESTION
from vibroscope.app.explorer.presets import OPENING, scenes

from tests.ui.axe import AXE, serious
from tests.ui.explorer import PHONE
from tests.waiting import wait_until

# What is seen in a window as high as this without scrolling: controls by name, and words of two letters or more outside
# figures' canvases, but for the progress of a first start.
SEEN = r"""height => {
  const controls = [], words = [], UNCOUNTED = "style, script, option, .screen-reader, .skip, .compiling";
  const inView = box => box.width > 1 && box.height > 1 && box.top < height && box.bottom > 0;
  const shown = node => node.checkVisibility({ visibilityProperty: true, opacityProperty: true });
  const walk = root => {
    const texts = document.createTreeWalker(root, NodeFilter.SHOW_TEXT);
    while (texts.nextNode()) {
      const { currentNode: text } = texts, parent = text.parentElement, range = document.createRange();
      if (!parent || parent.closest(UNCOUNTED) || !shown(parent)) continue;
      range.selectNodeContents(text);
      if ([...range.getClientRects()].some(inView)) words.push(...(text.data.match(/\p{L}[\p{L}’-]+/gu) ?? []));
    }
    for (const node of root.querySelectorAll("*")) {
      if (node.shadowRoot) walk(node.shadowRoot);
      if (!node.matches("button, input, select, summary, a[href]") || !shown(node)) continue;
      if (inView(node.getBoundingClientRect())) controls.push(node.ariaLabel ?? node.textContent ?? node.name);
    }
  };
  walk(document);
  return { controls, words };
}"""
MOST_CONTROLS, MOST_WORDS = 30, 200


def begin_tour(explorer):
    explorer.page.get_by_role("button", name="Tour, keys and help").click()
    explorer.page.get_by_role("button", name="From the problem").click()


@pytest.mark.parametrize("window", [{"width": 1440, "height": 900}, PHONE], ids=["desktop", "phone"])
def test_the_first_screen_states_the_question_shows_a_scene_that_answers_it_and_asks_for_little(kept, window):
    explorer, width, height = kept.anew(**window), window["width"], window["height"]
    for part, text in (("asked", QUESTION), ("caption", scenes()[OPENING].caption)):
        shown = explorer.page.locator(f".question .{part}")
        assert shown.text_content() == text
        box = shown.bounding_box()
        assert box["x"] >= 0
        assert box["x"] + box["width"] <= width
        assert 0 <= box["y"] <= box["y"] + box["height"] <= 0.4 * height
    assert explorer.page.locator("[aria-pressed=true]").get_attribute("data-scene") == OPENING
    verdict = explorer.judged().explained().page.locator(".line.verdict")
    assert verdict.get_attribute("data-agree") == "no"
    if width > 700:
        seen = explorer.page.evaluate(SEEN, height)
        assert len(seen["controls"]) <= MOST_CONTROLS, seen["controls"]
        assert len(seen["words"]) <= MOST_WORDS, " ".join(seen["words"])
        # a phone's first screen has a picture in its place
        box = verdict.bounding_box()
        assert box["y"] + box["height"] <= height  # whole
        assert explorer.page.locator(".cell.findings").get_attribute("data-more") is None  # and all below it
    assert "period" in explorer.page.locator(".line.reference .kind").text_content()
    explorer.moved(lambda: explorer.type("K", "9000"))
    caption = explorer.page.locator(".question .caption")
    wait_until(lambda: "setting of your own" in caption.text_content(), what="another caption: this is no scene")
    explorer.open_tab("Bifurcation")
    wait_until(lambda: caption.text_content() == "", what="no caption: no motions are shown")
    assert caption.bounding_box() is None or caption.bounding_box()["height"] == 0  # and no empty band


def test_the_tour_goes_from_the_problem_to_a_suggestion_that_is_applied(kept):
    explorer = kept.anew("?eta=2.76&K=2000&D=9&steps=2000")
    dialog = explorer.page.get_by_role("dialog", name="Tour")
    assert dialog.count() == 0
    begin_tour(explorer)
    explorer.page.evaluate(AXE)
    assert serious(explorer.page) == []
    behind = dialog.evaluate("dialog => getComputedStyle(dialog, '::backdrop').backgroundColor")
    assert behind == "rgba(0, 0, 0, 0)"  # what it points at is not dimmed
    before = explorer.query()
    for key in ("r", "p", "2", "Shift+2", "?", "t", "l"):
        explorer.page.keyboard.press(key)
    explorer.settle()
    assert explorer.query() == before
    assert explorer.page.locator("dialog[open], .take-away[open]").count() == 1
    seen = [dialog.locator("h2").text_content()]
    dialog.get_by_role("button", name="Next").click()
    explorer.wait_for_address(eta="1.08", K="100", D="50")  # a motion that looks right
    while dialog.get_by_role("button", name="Suggest and set them").count() == 0:
        seen.append(dialog.locator("h2").text_content())
        dialog.get_by_role("button", name="Next").click()
    before = explorer.update()
    dialog.get_by_role("button", name="Suggest and set them").click()
    assert dialog.locator("h2").text_content() in ("Searching", "A suggestion, applied")
    wait_until(lambda: explorer.address()["K"] != "100", what="the suggestion, applied")
    wait_until(lambda: dialog.locator("h2").text_content() == "A suggestion, applied", what="its head")
    explorer.settle(before + 1)
    assert f"K = {explorer.typed('K').input_value()}" in dialog.locator("p").text_content()
    assert len(set(seen)) == 4
    dialog.get_by_role("button", name="Done").click()
    dialog.wait_for(state="detached")
    begin_tour(explorer)
    dialog.get_by_role("button", name="Skip").click()
    dialog.wait_for(state="detached")
    explorer.page.evaluate("localStorage.clear()")


def test_each_exercise_is_predicted_tried_and_answered_by_the_page(kept):
    explorer = kept.anew()
    explorer.page.evaluate(AXE)
    begin_tour(explorer)
    tour = explorer.page.get_by_role("dialog", name="Tour")
    for _ in range(4):
        tour.get_by_role("button", name="Next").click()
    tour.get_by_role("button", name="Suggest and set them").click()
    tour.get_by_role("button", name="Exercises").click()
    dialog = explorer.page.get_by_role("dialog", name="Exercise")
    # The search of the tour is cancelled: it would set other numbers in the middle of the first exercise.
    wait_until(lambda: explorer.page.locator(".suggest[data-phase=idle]").count() == 1, what="no search")
    answers = []
    for number in (1, 2, 3):
        wait_until(lambda number=number: dialog.locator("h2").text_content().startswith(f"Exercise {number}"))
        attempt = dialog.get_by_role("button", name="Try it")
        assert attempt.is_disabled()  # a prediction comes first
        dialog.get_by_label("it becomes less than half").check()
        before = dialog.locator(".seen")
        wait_until(lambda before=before: before.text_content().startswith("Now: a difference of"), what="the start")
        attempt.click()
        wait_until(lambda before=before: "you predicted: " in before.text_content(), what="the answer")
        answers.append(before.text_content())
        shown = explorer.page.locator(".part.total .number").text_content()
        assert f"to a difference of {shown}." in answers[-1]
        if number == 3:
            assert serious(explorer.page) == []
        dialog.get_by_role("button", name="Next").or_(dialog.get_by_role("button", name="Done")).click()
    assert [answer.startswith("As you predicted") for answer in answers] == [True, True, False]
    assert "it more than doubles" in answers[2]
    dialog.wait_for(state="detached")
    explorer.page.evaluate("localStorage.clear()")


def test_each_step_of_the_tour_lies_within_the_window_with_its_buttons(kept):
    explorer = kept.anew()
    dialog = explorer.page.get_by_role("dialog", name="Tour")
    for width, height in ((1440, 900), (1280, 720), (320, 568)):
        explorer.page.set_viewport_size({"width": width, "height": height})
        explorer.settle()
        begin_tour(explorer)
        for step in range(5):
            box = dialog.bounding_box()
            assert box["x"] >= 0, (width, step)
            assert box["y"] >= 0, (width, step)
            assert box["x"] + box["width"] <= width, (width, step)
            assert box["y"] + box["height"] <= height, (width, step)
            dialog.locator(".row button:visible").last.click()
        dialog.get_by_role("button", name="Done").wait_for()
        box = dialog.bounding_box()
        assert 0 <= box["y"] <= height - box["height"]
        explorer.page.keyboard.press("Escape")
        dialog.wait_for(state="detached")
    explorer.page.evaluate("localStorage.clear()")
