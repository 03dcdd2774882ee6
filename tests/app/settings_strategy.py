"""Hypothesis strategy of valid settings."""

from hypothesis import strategies as st
from vibroscope.app.explorer.parameters import FIELDS, START_FIELDS, STEPPING_FIELDS
from vibroscope.app.explorer.state import Setting
from vibroscope.engine import INTEGRATORS


def _values(name):
    field = FIELDS[name]
    if name == "kappa3":
        return st.floats(1.01, 1.8)  # below every kappa drawn
    if name == "kappa":
        return st.floats(1.9, 10)
    if name == "clearance":
        return st.floats(-10, 10)
    if name == "steps":
        return st.integers(field.bounds[0], 65_536)  # more would cost more than the server allows
    return st.sampled_from(list(field.choices)) if field.choices else st.floats(*field.bounds)


def _together(setting):
    """The setting with a contact status that its integrator has."""
    if setting.located == "yes":
        setting = setting._replace(**{name: getattr(Setting(), name) for name in STEPPING_FIELDS})
    setting = setting._replace(status="start") if INTEGRATORS[setting.integrator].explicit else setting
    if setting.follows_step:
        K = setting.stiffness_of_step
        low, high = FIELDS["K"].bounds
        setting = setting._replace(**({"K": K} if low <= K <= high else {"stiffness": "typed"}))
    if setting.follows_system:
        setting = setting._replace(K=setting.stiffness_of_system)
    try:
        _ = setting.damping
        return setting._replace(D=setting.damping_of_restitution) if setting.finds_damping else setting
    except ValueError:  # no damper, or formula, gives so small a restitution
        return setting._replace(damper="typed")


def _apart(setting):
    """The setting with bodies that do not overlap at the start; a wall does not move."""
    if setting.bodies == "wall":
        setting = setting._replace(start_xi2=0.0, start_v2=0.0, coordinate="xi1")
    if setting.bodies == "two":  # a spring of body 1, or none
        setting = setting._replace(spring1=float(setting.spring1 > 0.5))
    room = setting.start_xi2 + min(setting.clearance, 0.0) - 1
    if setting.start_xi1 > room:
        low = FIELDS["start_xi1"].bounds[0]
        setting = setting._replace(start_xi1=max(room, low), start_xi2=max(setting.start_xi2, -1e5))
    if setting.stops == "two":  # some play, and the start within it
        least = max(1.0 - setting.clearance, setting.start_xi2 - setting.start_xi1)
        high = FIELDS["clearance2"].bounds[1]
        within = {"clearance2": max(setting.clearance2, least)} if least <= high else {"stops": "one"}
        setting = setting._replace(**within)
    own = any(getattr(setting, name) for name in START_FIELDS)
    return setting._replace(zero_start="rest") if own else setting


settings = st.builds(Setting, **{name: _values(name) for name in FIELDS}).map(_apart).map(_together)
