"""Hypothesis strategy of valid settings."""

from hypothesis import strategies as st
from vibroscope.app.explorer.state import FIELDS, Explorer, Setting, bounds_of


def _values(name):
    rule = Explorer.param[name]
    if name == "kappa3":
        return st.floats(1.01, 1.8)  # below every kappa drawn
    if name == "kappa":
        return st.floats(1.9, 10)
    if name == "steps":
        return st.integers(rule.bounds[0], 65_536)  # more would cost more than the server allows
    return st.sampled_from(rule.objects) if hasattr(rule, "objects") else st.floats(*bounds_of(name))


def _apart(setting):
    """The setting with pendulums that do not overlap at the start."""
    first, second = sorted((setting.start_xi1, setting.start_xi2))
    return setting._replace(start_xi1=first, start_xi2=second)


settings = st.builds(Setting, **{name: _values(name) for name in FIELDS}).map(_apart)
