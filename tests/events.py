"""Events of a response in the form of the solutions with many digits."""

import numpy as np
from vibroscope.engine import Reference


def events_of(response):
    """[(τ, kind, g′ before; nan where the response does not hold it)], kinds as in hard.json and systems.json."""
    impacts, contacts, end = response.impacts, response.contacts, response.window[1]
    rigid = isinstance(response.method, Reference)
    ends = [(t, 2 if rigid else 1, np.nan) for t in contacts[:, 1] if t < end]
    struck = list(zip(impacts.time, -impacts.closing_speed, strict=True))
    if rigid:
        begun = [(t, 0, speed) for t, speed in struck] + [(t, 1, 0.0) for t in contacts[:, 0]]
    else:
        begun = [(t, 0, dict(struck).get(t, np.nan)) for t in contacts[:, 0]]
    return sorted(ends + begun, key=lambda event: event[:2])
