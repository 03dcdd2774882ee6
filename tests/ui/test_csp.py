"""The content security policy in a real browser: it is in force and blocks nothing that the page needs."""

from vibroscope.app.page.tabs import TABS

VIOLATIONS = """() => {
  window.blocked = [];
  const note = event => window.blocked.push(`${event.violatedDirective} ${event.blockedURI}`);
  document.addEventListener("securitypolicyviolation", note);
}"""


def test_the_page_works_and_nothing_is_blocked(visit, server, windows):
    windows().context.add_init_script(f"({VIOLATIONS})()")
    explorer = visit()
    explorer.moved(lambda: explorer.type("eta", "1.4"))
    assert len(explorer.source("displacements")) > 0
    for tab in TABS:
        for view in tab.views:
            explorer.open_tab(tab.title, view.title if len(tab.views) > 1 else "")
            explorer.settle()
    assert explorer.page.evaluate("window.blocked") == []
    answer = explorer.page.request.get(server)
    policy = answer.headers["content-security-policy"]
    assert "unsafe-eval" not in policy
    assert "http" not in policy


def test_the_policy_is_in_force(visit):
    explorer = visit()
    blocked = explorer.page.evaluate(
        "new Promise(done => { document.addEventListener('securitypolicyviolation', e => done(e.violatedDirective), "
        "{once: true}); fetch('http://192.0.2.1/').catch(() => {}); setTimeout(() => done('nothing'), 3000); })"
    )
    assert blocked == "connect-src"
    explorer.complaints.clear()
