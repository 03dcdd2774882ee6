"""How a kernel is compiled does not depend on which function calls it first."""

import numba
import pytest
from vibroscope.engine.kernels.compile.options import jit, jit_inlined, jit_uncontracted


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
