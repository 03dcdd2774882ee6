"""Contact laws that are not linear, beside Taylor series of another solver, where it is installed."""

import numpy as np
import pytest
from vibroscope.engine import ExactPenalty, System, simulate

CASES = [  # law, D, more numbers
    ("hunt-crossley", None, {}),
    ("hunt-crossley", 300.0, {}),
    ("lankarani-nikravesh", None, {}),
    ("flores", None, {}),
    ("jankowski", None, {}),
    ("jankowski", 8.0, {}),
    ("constant-restitution", None, {}),
    ("constant-restitution", None, {"exponent": 2.0}),
    ("impact", 8.0, {"penetration": 1.0}),
]


@pytest.mark.parametrize(("law", "damping", "numbers"), CASES)
def test_three_periods_are_those_of_taylor_series(law, damping, numbers):
    pytest.importorskip("heyoka", reason="optional: docs/validation.md says how to install it")
    from tests.heyoka_laws import Motion

    system, eta, start = System(), 2.76, (0.0, 0.0, 1.0, -1.0)
    method = ExactPenalty(1200.0, damping, law, **numbers)
    run = simulate(system, eta, method, periods=3, keep=3, initial=start)
    twin = Motion(system, eta, method)
    expected = twin.run(start, 3 * run.period)
    np.testing.assert_allclose(run.section[-1], expected, rtol=0, atol=1e-10)
    assert twin.contacts == len(run.contacts) > 2
