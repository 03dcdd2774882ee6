"""The content security policy is in force; that it blocks nothing the page needs is seen by every test in a browser."""


def test_the_policy_is_in_force_and_a_page_complains_of_what_it_blocks(visit):
    explorer = visit()
    blocked = explorer.page.evaluate(
        "new Promise(done => { document.addEventListener('securitypolicyviolation', e => done(e.violatedDirective), "
        "{once: true}); fetch('http://192.0.2.1/').catch(() => {}); setTimeout(() => done('nothing'), 3000); })"
    )
    assert blocked == "connect-src"
    assert any("Content Security Policy" in complaint for complaint in explorer.complaints)
    explorer.complaints.clear()
    policy = explorer.page.request.get(explorer.server).headers["content-security-policy"]
    assert "unsafe-eval" not in policy
    assert "http" not in policy
