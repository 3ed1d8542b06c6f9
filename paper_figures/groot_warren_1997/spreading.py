"""Self-diffusion from how labelled beads spread."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from dpd.analysis.statistics import jackknife_error
from dpd.analysis.viscosity import Measured

if TYPE_CHECKING:
    import numpy.typing as npt


class Spreading(NamedTuple):
    """The decay of a wave of labelled beads.

    - ``diffusion``: D in r_c^2 / tau.
    - ``height``: of the wave at time 0.
    - ``wave``: (runs, n) array; height of the wave in each run at each time, in 1 / r_c^3.
    """

    diffusion: Measured
    height: float
    wave: np.ndarray


def diffusion_of_labels(
    density: np.ndarray, z: np.ndarray, time: npt.ArrayLike, length: float
) -> Spreading:
    """Self-diffusion from beads of two names that differ in nothing else.

    One of them begins in the lower half of a periodic box, the other in the upper half. As nothing
    tells them apart, the mean of their densities is that of single beads which diffuse: a wave with
    the wave number q = 2 pi / L decays as exp(-D q^2 t), once velocities are forgotten. The heights
    of all times, the mean over runs, are fitted with one weight, as their noise hardly changes.

    ``density``: (runs, n, 2, slices) array; of the names at each time, that of the lower half
    first. ``z``: (slices,) array; middles of slices in r_c. ``time``: (n,) array; in tau.
    ``length``: L in r_c. Result: the error of D by leaving out runs in turn; NaN for a single run.
    """
    from scipy.optimize import curve_fit  # most jobs need no SciPy

    q = 2 * np.pi / length
    wave = (density[:, :, 0] - density[:, :, 1]) @ np.sin(q * z) * (2 / len(z))
    time = np.asarray(time, dtype=float)

    def decay(t, height, rate):
        return height * np.exp(-rate * t)

    def fitted(heights):
        return curve_fit(decay, time, heights, p0=(heights[0], 1 / time[-1]))[0]

    runs = len(wave)
    height, rate = fitted(wave.mean(axis=0))
    error = np.nan
    if runs > 1:
        left_out = [fitted(np.delete(wave, k, axis=0).mean(axis=0))[1] for k in range(runs)]
        error = float(jackknife_error(left_out)) / q**2
    return Spreading(Measured(float(rate / q**2), error), float(height), wave)
