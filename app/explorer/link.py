"""The address of the page, read and printed: the setting, and the open view with its state. No panel import.

A link holds the values of the setting by name; ``view``, ``pin`` (settings as addresses of their own, joined by
semicolons), ``theme``; and the state of the view, as ``zoom=time:0.2,0.7;x1:-1,2``, ``choice=quantity:error;limit:40``
or ``choice=phase:0.35``, ``mute=force:penalty,pinned``.
Only what differs from the default is in it, except for the four sliders. All of a link is accepted, or nothing.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple
from urllib.parse import parse_qsl, urlencode

from vibroscope.app.explorer.errors import Refused
from vibroscope.app.explorer.parameters import FIELDS, MAIN_FIELDS, SECOND_STOP_FIELDS
from vibroscope.app.explorer.reading import read_choice, read_number, read_setting
from vibroscope.app.explorer.state import Setting
from vibroscope.app.runtime.number_text import print_number, quote

VIEW_FIELDS = ("view", "pin", "zoom", "choice", "mute", "theme")  # in a link beside the setting

Span = tuple[float, float]

# Limits of the ends of an axis.
LINEAR: Span = (-1e12, 1e12)
LOGARITHMIC: Span = (1e-30, 1e30)
_LEAST_WIDTH = 1e-30  # of an axis
_LEAST_RELATIVE_WIDTH = 1e-9  # of an axis, relative to its ends: the numbers of a browser resolve no less
_RESOLUTION = 1e-5  # of an end that is rounded, relative to the width of the axis: a hundredth of a pixel
_LONGEST_ADDRESS = 4000
MOST_PINS = 4


# ---- the whole address ----------------------------------------------------------------------------------------------


def parse_address(query: str) -> dict[str, str]:
    """The known names in a query string, as text, each at most once; raises `Refused`."""
    query = query.removeprefix("?")
    if len(query) > _LONGEST_ADDRESS:
        raise Refused("address", "This address is too long to be an address of this page.")
    texts: dict[str, str] = {}
    for name, text in parse_qsl(query, keep_blank_values=True, errors="replace"):
        if name not in FIELDS and name not in VIEW_FIELDS:
            continue  # mail programs and other pages add parameters of their own to links
        if name in texts:
            raise Refused(name, f"The address gives {name} twice.")
        texts[name] = text
    return texts


def idle_numbers(texts: Mapping[str, str], setting: Setting) -> str:
    """A sentence on the numbers of a link that the bodies or stops of its setting do not have; empty if there is none.

    They are accepted: the page itself keeps them in its links, for when others are chosen again.
    """
    of_bodies = [name for name, field in FIELDS.items() if name in texts and setting.bodies not in field.bodies]
    of_stop = [name for name in SECOND_STOP_FIELDS if name in texts and setting.stops == "one"]
    return " ".join(
        f"The link gives {kind} and {', '.join(idle)}: {why}, {'it has' if len(idle) == 1 else 'they have'} no effect."
        for kind, idle, why in (
            (f"bodies={setting.bodies}", of_bodies, _WHY_IDLE[setting.bodies]),
            ("stops=one", of_stop, "there is no second stop"),
        )
        if idle
    )


_WHY_IDLE = {
    "pendulums": "the mass ratio follows from kappa and kappa3",
    "two": "the mass ratio is given instead",
    "wall": "a wall has no such number",
}


def read_pins(text: str) -> tuple[Setting, ...]:
    """The pinned settings that an address holds; raises `Refused` at the first fault."""
    parts = text.split(";") if text else []
    if len(parts) > MOST_PINS:
        raise Refused("pin", f"At most {MOST_PINS} settings can be pinned; the address has {len(parts)}.")
    if "" in parts:
        raise Refused("pin", "One of the pinned settings of the address is empty.")
    return tuple(dict.fromkeys(read_setting(parse_address(part)) for part in parts))


def print_address(setting: Setting, view: str = "", pins: Sequence[Setting] = (), **state: str) -> str:
    """The query string from which `parse_address` restores the page; ``state``: texts by the names in `VIEW_FIELDS`."""
    default = Setting()
    values = {
        name: text
        for name, text in setting.texts().items()
        if name in MAIN_FIELDS or getattr(setting, name) != getattr(default, name)
    }
    state = {"view": view, "pin": ";".join(map(print_address, pins))} | state
    return urlencode(values | {name: text for name, text in state.items() if text}, safe=":;,")


# ---- the state of a view: text → object -----------------------------------------------------------------------------


class ViewChoice(NamedTuple):
    """What can be chosen in a view: one of some values, a number, or a text of any words.

    Attributes
    ----------
    name, label : str
        In an address, and beside its list or its field.
    first : str, float or None
        What is chosen at first; an int of a whole number. None: the field is empty then, and may be emptied again.
    words : mapping of str to str
        What can be chosen, in words; empty for a number and for a text.
    bounds : tuple of float
        Smallest and largest number; empty for a text.
    hint, quantity, natural : str
        Of a number with a unit: what it is, the quantity, and what one of it is where numbers have no dimension.
    when : mapping of str to str
        The other choices with which it has an effect.
    of_body_2 : tuple of str
        The values that a wall does not have; of a number that it does not have, its name.
    linked, shown : bool
        Whether it stands in an address, and in the panel.
    """

    name: str
    label: str
    first: str | float | None
    words: Mapping[str, str] = {}
    bounds: Span | tuple[()] = ()
    hint: str = ""
    quantity: str = ""
    natural: str = ""
    when: Mapping[str, str] = {}
    of_body_2: tuple[str, ...] = ()
    linked: bool = True
    shown: bool = True

    @property
    def whole(self) -> bool:
        """Whether it is a whole number."""
        return isinstance(self.first, int)


class View(NamedTuple):
    """The state of a view: ends of the zoomed axes, choices other than the default, muted legend entries by figure."""

    zoom: Mapping[str, Span] = {}
    choice: Mapping[str, str | float] = {}
    mute: Mapping[str, Sequence[str]] = {}


def read_view(
    zoom: str,
    choice: str,
    mute: str,
    axes: Mapping[str, Span],
    choices: Sequence[ViewChoice],
    legends: Mapping[str, Sequence[str]],
) -> View:
    """The view that an address holds; raises `Refused` at the first fault.

    Parameters
    ----------
    zoom, choice, mute : str
        As they are in the address.
    axes : mapping of str to Span
        Limits of the ends of each axis of the view.
    choices : sequence of ViewChoice
        Of the view.
    legends : mapping of str to sequence of str
        Names of the legend entries of each figure of the view that has a legend.
    """
    spans = {name: _read_span(name, text, axes[name]) for name, text in _parts("zoom", zoom, axes)}
    linked = {each.name: each for each in choices if each.linked}
    chosen = {name: _read_choice(text, linked[name]) for name, text in _parts("choice", choice, linked)}
    muted = {figure: _read_muted(figure, text, legends[figure]) for figure, text in _parts("mute", mute, legends)}
    return View(spans, chosen, muted)


def _parts(kind: str, text: str, known: Mapping) -> Iterator[tuple[str, str]]:
    """Name and value of each ``name:value``."""
    seen = set()
    for part in text.split(";") if text else []:
        name, _, value = part.partition(":")
        if name not in known:
            offered = f"it is one of {', '.join(known)}" if known else "it has none"
            raise Refused(kind, f"The open view has no {kind} of {quote(name)}: {offered}.")
        if name in seen:
            raise Refused(kind, f"The address gives the {kind} of {name} twice.")
        seen.add(name)
        yield name, value


def _read_span(name: str, text: str, limits: Span) -> Span:
    ends = text.split(",")
    if len(ends) != 2:
        raise Refused("zoom", f"The zoom of {name} must be two numbers, as 0.2,0.7, not {quote(text)}.")
    low, high = (read_number(f"An end of the zoom of {name}", end, limits, whole=False) for end in ends)
    if not _is_drawable((low, high), limits):
        raise Refused("zoom", f"The zoom of {name} must go from a smaller to a larger number, not {quote(text)}.")
    return low, high


def _read_choice(text: str, choice: ViewChoice) -> str | int | float:
    if choice.words:
        return read_choice(choice.name, text, list(choice.words))
    return read_number(choice.name, text, choice.bounds, choice.whole)


def _read_muted(figure: str, text: str, entries: Sequence[str]) -> list[str]:
    names = text.split(",")
    for name in names:
        if name not in entries:
            raise Refused("mute", f"The legend of {figure} has {', '.join(entries)}, not {quote(name)}.")
    if len(set(names)) < len(names):
        raise Refused("mute", f"The address mutes an entry of {figure} twice.")
    return names


def _is_drawable(span: Span, limits: Span) -> bool:
    low, high = span
    least = max(_LEAST_RELATIVE_WIDTH * max(abs(low), abs(high)), _LEAST_WIDTH)
    return limits[0] <= low <= high <= limits[1] and high - low > least


# ---- the state of a view: object → text -----------------------------------------------------------------------------


def rounded_span(span: Span) -> Span:
    """The ends of an axis as a mouse moves it, in few digits, more precise than a pixel also of a logarithmic axis.

    What is computed of a view is computed of these ends, so that a link, which holds them, leads to the same numbers.
    """
    width = span[1] - span[0]
    return tuple(_rounded(end, width) for end in span) if 0 < width < math.inf else span


def _rounded(end: float, width: float) -> float:
    size = max(min(abs(end), width), _LEAST_WIDTH)
    return float(round(end, -math.floor(math.log10(_RESOLUTION * size))))


def print_zoom(zoom: Mapping[str, Span], axes: Mapping[str, Span]) -> str:
    """Text from which `read_view` reads exactly the same ends; axes that cannot be drawn are left out."""
    return ";".join(
        f"{name}:{','.join(map(print_number, span))}" for name, span in zoom.items() if _is_drawable(span, axes[name])
    )


def print_choice(choice: Mapping[str, str | float]) -> str:
    """Text for `read_view`."""
    return ";".join(f"{name}:{value}" for name, value in choice.items())


def print_mute(mute: Mapping[str, Sequence[str]]) -> str:
    """Text for `read_view`."""
    return ";".join(f"{figure}:{','.join(names)}" for figure, names in mute.items())
