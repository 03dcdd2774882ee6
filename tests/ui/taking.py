"""The menu Take away in the terms of its user, for tests in a browser."""

import time
from pathlib import Path

from playwright.sync_api import TimeoutError as Late

_APART = 0.1  # s between two downloads: Chromium drops all but ten in a second, and reports nothing to wait for


def taken(explorer, name):
    """Click a button of the menu and read the file that comes."""
    menu = explorer.page.locator("details.take-away")
    if not menu.evaluate("menu => menu.open"):
        menu.locator("summary").click()
    time.sleep(_APART)
    try:
        with explorer.page.expect_download() as download:
            menu.get_by_role("button", name=name, exact=True).click()
    except Late:
        said = {
            "open": menu.evaluate("menu => menu.open"),
            "status": menu.locator("[role=status]").text_content(),
            "error": explorer.error(),
            "complaints": explorer.complaints,
            "updates": explorer.update(),
        }
        raise AssertionError(f"no file for {name!r}: {said}") from None
    return download.value.suggested_filename, Path(download.value.path()).read_bytes()


def menu(explorer):
    """Titles in the open menu, each with the texts of its buttons, read at one moment: the menu may change."""
    box = explorer.page.locator("details.take-away")
    if not box.evaluate("menu => menu.open"):
        box.locator("summary").click()
    return box.evaluate("""menu => Object.fromEntries(
        [...menu.querySelectorAll(".item")].filter(item => item.checkVisibility()).map(item => [
            item.querySelector("span").textContent,
            [...item.querySelectorAll("button")].map(button => button.textContent)]))""")
