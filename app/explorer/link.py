"""What a link restores of the open tab beside the setting: zoomed axes, choices, muted legend entries. No panel import.

In the address: ``zoom=time:0.2,0.7;x1:-1,2``, ``choice=quantity:error;limit:40``, ``mute=force:penalty,pinned``, each
only where it is not as the page has it by itself. Like a setting it is taken whole or not at all.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from vibroscope.app.explorer.state import Refused, print_number, quoted, read_choice, read_number

Span = tuple[float, float]

# What the ends of an axis may be; nobody has anything to see beyond.
LINEAR: Span = (-1e12, 1e12)
LOGARITHMIC: Span = (1e-30, 1e30)
_LEAST = 1e-30  # width of an axis
_NARROWEST = 1e-9  # width of an axis as a share of its ends: the numbers of a browser resolve no less
_SHARPNESS = 1e-5  # share of the width to which an end is printed: a hundredth of a pixel


class View(NamedTuple):
    """How a tab is seen: ends of the axes that are zoomed, what is not chosen as at first, what is muted by figure."""

    zoom: Mapping[str, Span] = {}
    choice: Mapping[str, str | int] = {}
    mute: Mapping[str, Sequence[str]] = {}


def read_view(
    zoom: str, choice: str, mute: str, axes: Mapping[str, Span], spec: Mapping, legends: Mapping[str, Sequence[str]]
) -> View:
    """The view that an address holds; raises `Refused` at the first fault.

    Parameters
    ----------
    zoom, choice, mute : str
        As they stand in the address.
    axes : mapping of str to Span
        Axes of the tab, and what their ends may be.
    spec : mapping
        ``switches`` (name, choices) and ``limits`` (name, low, high) of the tab.
    legends : mapping of str to sequence of str
        Figures of the tab that have a legend, and the names of its entries.
    """
    spans = {name: _span(name, text, axes[name]) for name, text in _parts("zoom", zoom, axes)}
    rules = {switch["name"]: list(switch["choices"]) for switch in spec.get("switches", [])}
    rules |= {limit["name"]: (limit["low"], limit["high"]) for limit in spec.get("limits", [])}
    chosen = {name: _chosen(name, text, rules[name]) for name, text in _parts("choice", choice, rules)}
    muted = {figure: _muted(figure, text, legends[figure]) for figure, text in _parts("mute", mute, legends)}
    return View(spans, chosen, muted)


def _parts(what: str, text: str, known: Mapping) -> Iterator[tuple[str, str]]:
    """Name and value of each ``name:value``."""
    seen = set()
    for part in text.split(";") if text else []:
        name, _, value = part.partition(":")
        if name not in known:
            offered = f"it is one of {', '.join(known)}" if known else "it has none"
            raise Refused(what, f"The open tab has no {what} of {quoted(name)}: {offered}.")
        if name in seen:
            raise Refused(what, f"The address gives the {what} of {name} twice.")
        seen.add(name)
        yield name, value


def _span(name: str, text: str, limits: Span) -> Span:
    ends = text.split(",")
    if len(ends) != 2:
        raise Refused("zoom", f"The zoom of {name} must be two numbers, as 0.2,0.7, not {quoted(text)}.")
    low, high = (read_number(f"An end of the zoom of {name}", end, limits, whole=False) for end in ends)
    if not _can_be_shown((low, high), limits):
        raise Refused("zoom", f"The zoom of {name} must go from a smaller to a larger number, not {quoted(text)}.")
    return low, high


def _chosen(name: str, text: str, rule: list[str] | Span) -> str | int:
    return read_choice(name, text, rule) if isinstance(rule, list) else read_number(name, text, rule, whole=True)


def _muted(figure: str, text: str, entries: Sequence[str]) -> list[str]:
    names = text.split(",")
    for name in names:
        if name not in entries:
            raise Refused("mute", f"The legend of {figure} has {', '.join(entries)}, not {quoted(name)}.")
    if len(set(names)) < len(names):
        raise Refused("mute", f"The address mutes an entry of {figure} twice.")
    return names


def _can_be_shown(span: Span, limits: Span) -> bool:
    low, high = span
    return limits[0] <= low <= high <= limits[1] and high - low > max(_NARROWEST * max(abs(low), abs(high)), _LEAST)


def print_zoom(zoom: Mapping[str, Span], axes: Mapping[str, Span]) -> str:
    """As `read_view` takes it back, sharper than a pixel; what nobody could see is left out."""
    return ";".join(
        f"{name}:{','.join(print_number(_rounded(end, span, axes[name])) for end in span)}"
        for name, span in zoom.items()
        if _can_be_shown(span, axes[name])
    )


def _rounded(end: float, span: Span, limits: Span) -> float:
    width = span[1] - span[0]
    size = min(end, width) if limits is LOGARITHMIC else width
    return float(np.clip(round(end, -math.floor(math.log10(_SHARPNESS * size))), *limits))


def print_choice(choice: Mapping[str, str | int]) -> str:
    """As `read_view` takes it back."""
    return ";".join(f"{name}:{value}" for name, value in choice.items())


def print_mute(mute: Mapping[str, Sequence[str]]) -> str:
    """As `read_view` takes it back."""
    return ";".join(f"{figure}:{','.join(names)}" for figure, names in mute.items())
