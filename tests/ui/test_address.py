"""The address restores the page; a bad one is refused as a whole, in words."""

from urllib.parse import quote
from urllib.request import urlopen

from tests.waiting import PATIENCE


def test_a_link_restores_its_state_in_a_session_that_is_independent(kept, visit):
    first = kept.anew()
    first.moved(lambda: first.type("eta", "2.7612345"))
    first.unfold("Solver", "Display")
    first.moved(lambda: first.page.locator("[name=vibroscope-joint_damping][value=derived]").set_checked(True))
    first.moved(lambda: first.page.get_by_text("absolute", exact=True).click())
    first.wait_for_address(eta="2.7612345", joint_damping="derived", frame="absolute")
    second = visit(first.query())
    assert second.sources() == first.sources()
    assert second.typed("eta").input_value() == "2.7612345"
    second.unfold("Display")
    assert second.page.get_by_role("radio", name="absolute", exact=True).is_checked()
    before = second.sources()
    first.moved(lambda: first.scene("C"))
    assert second.sources() == before
    assert second.typed("eta").input_value() == "2.7612345"
    second.moved(lambda: second.type("eta", "3.1"))
    assert first.typed("eta").input_value() == "2.76"


def test_a_half_valid_address_is_refused_as_a_whole_and_leaves_complete_controls(visit):
    explorer = visit("?eta=2.76&K=nan&D=18")
    assert "The link was not accepted" in explorer.error()
    assert "K must be a number from 1e-6 to 1e12" in explorer.error()
    assert explorer.typed("eta").input_value() == "1.08"
    assert explorer.page.locator("[aria-invalid=true]").count() == 0
    assert explorer.query() == "?eta=2.76&K=nan&D=18"
    explorer.moved(lambda: explorer.type("eta", "2"))
    assert explorer.error() == ""
    explorer.wait_for_address(eta="2")


def test_hostile_addresses_never_break_the_page(server):
    """What the page says of them: tests/app/test_hostile_clients.py."""
    long = "?steps=" + "9" * 5000
    for query in ("?eta=²", "?eta=" + "9" * 1900, "?eta=%FF%FE", "?eta=1&eta=2", "?eta=1e999", "?pin=eta%3D²", long):
        assert urlopen(server + "/" + quote(query, safe="?&=%"), timeout=PATIENCE).status == 200, query
