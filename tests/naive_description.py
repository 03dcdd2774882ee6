"""Slow, obvious twin of the section statistics: a motion described by numpy from its section and its events."""

import numpy as np


def describe(response, tolerance=1e-5, near_tolerance=0.03, longest_near_period=4):
    """The numbers that the engine gives for the kept periods, by name."""
    section, period_length = response.section, response.period
    size, rows = np.abs(section).max(initial=0.0), len(section)
    period = next(
        (
            p
            for p in range(1, rows // 2 + 1)
            if np.abs(section[p:] - section[:-p]).max() <= tolerance * max(size, 1e-12)
        ),
        0,
    )
    near = period or next(
        (
            p
            for p in range(1, min(longest_near_period, rows // 2) + 1)
            if np.sqrt(np.mean((section[p:] - section[:-p]) ** 2)) <= near_tolerance * size
        ),
        0,
    )
    cycles = rows // max(near, 1) * max(near, 1)
    end = response.window[1]
    begin = end - cycles * period_length
    spans = np.clip(response.contacts, begin, end)
    observed = section[:, 0 if response.system.wall else 2]
    points = observed[rows - cycles :].reshape(-1, max(near, 1))
    shares = response.impacts.time / period_length
    recent = shares[shares > end / period_length - max(near, 1)]
    return {
        "period": period,
        "near_period": near,
        "impacts_per_period": np.sum(response.impacts.time > begin) / cycles,
        "contacts_per_period": np.sum(response.contacts[:, 0] > begin) / cycles,
        "contact_share": np.diff(spans, axis=1).sum() / (end - begin),
        "spread": np.std(observed),
        "scatter": np.sqrt(np.mean(np.var(points, axis=0))),
        "longest_contact": np.diff(response.contacts, axis=1).max(initial=0.0),
        "impact_phase": recent.min() % 1.0 if len(recent) else np.nan,
    }
