"""Accessibility faults, as axe-core finds them."""

from pathlib import Path

import axe_playwright_python

AXE = Path(axe_playwright_python.__file__).with_name("axe.min.js").read_text(encoding="utf-8")
# Of what passes axe would list every element with a selector, which takes longer than to check them.
VIOLATIONS = """axe.run(document, {
  runOnly: ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa"], resultTypes: ["violations"], selectors: false,
}).then(({ violations }) => violations)"""


def serious(page):
    """What axe calls serious or critical, shadow roots included: rule and elements."""
    return [
        (fault["id"], [node["html"][:200] for node in fault["nodes"]])
        for fault in page.evaluate(VIOLATIONS)
        if fault["impact"] in ("serious", "critical")
    ]


def serious_in(page, *schemes):
    """What is serious once the page is in each of these colour schemes, and in which."""
    found = []
    for scheme in schemes:
        page.emulate_media(color_scheme=scheme, reduced_motion="reduce")
        page.evaluate("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")
        found += [(scheme, *fault) for fault in serious(page)]
    return found
