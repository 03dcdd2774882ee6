"""Whether a Poincaré section is regular (periodic or quasi-periodic) or not, and its rotation number."""

import numpy as np
from vibroscope.engine.drivers.section import TOLERANCE, sizes_of
from vibroscope.engine.motions.averages import smooth_weights

MOST_TUBES = 4  # of a torus, which the motion visits in turn


def irregularity(section: np.ndarray) -> float:
    """Largest difference between smoothly weighted averages over the two halves of a section.

    Averaged are the four coordinates and their squares, in units of the largest standard deviation. The difference is
    of the order of 1/√n for chaotic motion and many orders of magnitude less for periodic and quasi-periodic motion
    (Sander and Meiss, Physica D 411 (2020) 132569). A transient makes it large, too.

    Parameters
    ----------
    section : (n, 4) ndarray
        Thousands of rows; a hundred do not suffice to separate the two cases.
    """
    half = len(section) // 2
    size = max(section.std(axis=0).max(), TOLERANCE * sizes_of(section[None])[0])
    scaled = (section - section.mean(axis=0)) / size
    observed = np.hstack([scaled, scaled**2])
    return float(np.abs(smooth_weights(half) @ (observed[:half] - observed[half : 2 * half])).max())


def rotation_number(section: np.ndarray) -> float:
    """Strongest frequency of a quasi-periodic section, in turns per excitation period, from 0 to ½.

    A torus may consist of several tubes, up to MOST_TUBES, that the motion visits in turn. Their common period is
    removed first: from the rows of each visit the mean of these rows is subtracted. The peak of the weighted spectrum
    is then interpolated between its lines, which lie 1/n apart, by a parabola through the logarithms of three values.

    Parameters
    ----------
    section : (n, 4) ndarray
    """
    deviation = section - section.mean(axis=0)
    visits = np.lcm.reduce(np.arange(1, MOST_TUBES + 1))
    for first in range(visits):
        tube = deviation[first::visits]
        tube -= smooth_weights(len(tube)) @ tube
    power = (np.abs(np.fft.rfft(deviation * smooth_weights(len(deviation))[:, None], axis=0)) ** 2).sum(axis=1)
    line = int(np.clip(power.argmax(), 1, len(power) - 2))
    left, top, right = np.log(np.maximum(power[line - 1 : line + 2], 1e-300))
    curvature = left - 2 * top + right
    return float((line + (0.5 * (left - right) / curvature if curvature < 0 else 0.0)) / len(section))
