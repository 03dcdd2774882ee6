"""The claims of the verdict, of 200 settings drawn at random (`python -m tests.claims --write` writes their page)."""

import os

from tests.claims.__main__ import judged
from tests.claims.table import beyond, table

SETTINGS = int(os.environ.get("RELEASE_SETTINGS", "200"))


def test_what_a_verdict_says_is_so(report):
    claims = [claim for number in range(SETTINGS) for claim in judged(number)]
    report(table(claims), inputs=SETTINGS)
    assert beyond(claims) == []
