"""Numbers, texts, arrays, records and mappings of those as JSON: of a command, and of a file to take away."""

import json
import math
from collections.abc import Mapping

import numpy as np


def json_text(content: object, *, ascii_only: bool = False) -> str:
    """The content as JSON: lists for arrays and tuples, pairs for complex numbers, null for nan and infinite values.

    >>> json_text({"multipliers": np.array([1 + 2j]), "peak": np.nan, "at": (1, 2.0)})
    '{"multipliers": [[1.0, 2.0]], "peak": null, "at": [1, 2.0]}'
    """
    return json.dumps(_plain(content), ensure_ascii=ascii_only, allow_nan=False)


def _plain(value: object) -> object:
    if isinstance(value, Mapping):
        return {name: _plain(item) for name, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if isinstance(value, np.ndarray):
        return _plain_array(value)
    if isinstance(value, np.generic):
        return _plain(value.item())
    if isinstance(value, complex):
        return [_plain(value.real), _plain(value.imag)]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _plain_array(array: np.ndarray) -> list:
    if array.dtype.kind == "c":
        array = np.stack([array.real, array.imag], axis=-1)
    if array.dtype.kind != "f":
        return array.tolist()
    digits = array.astype(str).astype(float) if array.dtype == np.float32 else array
    return np.where(np.isfinite(digits), digits.astype(object), None).tolist()
