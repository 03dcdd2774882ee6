"""The bifurcation diagram as a picture of counts: drawn as circles, so many points would be slow to move."""

from __future__ import annotations

import numpy as np


def raster(
    eta: np.ndarray,
    values: np.ndarray,
    x_range: tuple[float, float],
    y_range: tuple[float, float],
    width: int,
    height: int,
) -> np.ndarray:
    """Shades 0–255 of ``values`` (n, keep) over ``eta`` (n,), row 0 at the bottom.

    Each column of the picture is scaled by its own number of points: a period-one
    line and a chaotic band of as many points are both plain to see. When zoomed
    so far that a column would hold no η at all, columns widen to one η each.
    """
    low, high = x_range
    seen = (eta >= low) & (eta <= high)
    picture = np.zeros((height, width), np.uint8)
    if not seen.any():
        return picture
    columns = min(width, max(1, int(seen.sum())))
    counts = _counts(eta[seen], values[seen], x_range, y_range, columns, height)
    shades = _shade(counts)
    return _thicken(shades[:, np.arange(width) * columns // width])


def _thicken(shades: np.ndarray) -> np.ndarray:
    """Make every point two pixels high and wide: a line of one pixel is hard to see beside the grid."""
    thick = shades.copy()
    thick[1:] = np.maximum(thick[1:], shades[:-1])
    thick[:, 1:] = np.maximum(thick[:, 1:], thick[:, :-1])
    return thick


def _counts(eta, values, x_range, y_range, columns, height) -> np.ndarray:
    column = _bin(eta, *x_range, columns)
    inside = (values >= y_range[0]) & (values <= y_range[1])
    row = _bin(values, *y_range, height)
    flat = row * columns + column[:, None]
    return np.bincount(flat[inside], minlength=height * columns).reshape(height, columns)


def _bin(values: np.ndarray, low: float, high: float, count: int) -> np.ndarray:
    with np.errstate(invalid="ignore"):  # a diverged point is NaN, falls outside and is not counted
        return np.clip((values - low) / (high - low) * count, 0, count - 1).astype(np.intp)


def _shade(counts: np.ndarray) -> np.ndarray:
    # Square root: single points stay visible beside lines that hold all 50.
    share = counts / np.maximum(counts.max(axis=0, keepdims=True), 1)
    shades = np.where(counts > 0, 70 + 185 * np.sqrt(share), 0)
    return shades.astype(np.uint8)
