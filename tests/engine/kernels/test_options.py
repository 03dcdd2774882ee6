"""How a kernel is compiled does not depend on which function calls it first."""

import numba
import numpy as np
import pytest
from vibroscope.engine.kernels.compile.options import jit, jit_inlined, jit_uncontracted
from vibroscope.engine.kernels.equations.contact_law import IMPACT, ContactLaw, law_force, to_power


@pytest.fixture
def compile_in(tmp_path, monkeypatch):
    monkeypatch.setattr(numba.config, "CACHE_DIR", str(tmp_path))


@pytest.mark.parametrize("caller", [jit, jit_inlined])
def test_a_sum_with_a_known_rounding_is_not_fused_for_a_caller_that_fuses(compile_in, caller):
    def fused(a, b, c):
        return a * b + c

    kernel = jit_uncontracted(fused)

    def call(a, b, c):
        return kernel(a, b, c) * 2.0

    a = 1.0 + 2.0**-30
    assert caller(call)(a, a, -1.0 - 2.0**-29) == 0.0  # 2⁻⁵⁹ if it were fused
    assert kernel(a, a, -1.0 - 2.0**-29) == 0.0
    assert jit(fused)(a, a, -1.0 - 2.0**-29) in (0.0, 2.0**-60)  # the processor decides whether it is fused


def test_no_power_is_taken_where_none_is_needed(compile_in):
    """LLVM moves its own power, "llvm.pow", out of the case that needs it into all."""
    found = jit_uncontracted(law_force.py_func)
    assert found(ContactLaw(IMPACT, 2.0, 2.3, 1.0, 0.0, 0.0, 0.0), 0.0, 0.7, 0.0) == 2.0 * 0.7**2.3
    (code,) = found.inspect_llvm().values()
    assert "@pow(" in code
    assert "llvm.pow" not in code


def test_a_power_has_the_bits_of_python():
    numbers = np.random.default_rng(3).uniform(0.0, 3.0, (1000, 2))
    kernel = numba.njit(lambda base, exponent: to_power(base, exponent))
    assert all(kernel(base, exponent) == to_power(base, exponent) == base**exponent for base, exponent in numbers)
