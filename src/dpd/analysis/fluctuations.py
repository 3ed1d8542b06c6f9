"""Viscosity of a fluid at rest, from the fluctuations of its stress."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from dpd.analysis.flow import Measured
from dpd.analysis.statistics import independent_mean_and_error

if TYPE_CHECKING:
    pass

PARTS = 20  # of a run, each long beside the memory of the stress


def viscosity_of_fluctuations(
    tensor: np.ndarray, dt: float, volume: float, kT: float, memory: float
) -> Measured:
    """Shear viscosity by the Einstein relation (Helfand 1960) of the pressure tensor.

    With S_ab(t), the integral of P_ab over a time t,

        <S_ab(t)^2>  =  2 eta kT t / V + constant

    as soon as t is longer than the memory of the stress. P must hold all forces, friction and noise
    too, and each step: noise has no memory, and what it adds up to in one step counts. The slope is
    that from t to 3 t. Five components are independent: xy, xz, yz, (xx - yy) / 2 and
    (2 zz - xx - yy) / sqrt(12).

    ``tensor``: (n, 3, 3) array; the pressure tensor with all forces at each step, in kT / r_c^3.
    ``dt``: time step in tau. ``volume``: in r_c^3. ``memory``: t in tau, from which the slope is
    taken. Result: eta in kT tau / r_c^3. The error is that of the mean over `PARTS` parts of the
    run, which count as independent. Raises `ValueError` if a part would be shorter than 9 t.
    """
    first = max(1, round(memory / dt))
    size = len(tensor) // PARTS
    if size < 9 * first:
        raise ValueError(
            f"a run of {len(tensor)} steps has parts of {size} steps; {9 * first} are needed"
        )
    stress = shear_components(tensor)
    parts = stress[: size * PARTS].reshape(PARTS, size, -1)
    slopes = [(_spread(part, 3 * first) - _spread(part, first)) / (2 * first) for part in parts]
    eta = np.array(slopes) * dt * volume / (2 * kT)
    mean, error = independent_mean_and_error(eta)
    return Measured(float(mean), float(error))


def shear_components(tensor: np.ndarray) -> np.ndarray:
    """Five components of a pressure tensor, each with the variance of an off-diagonal one.

    ``tensor``: (n, 3, 3) array. Result: (n, 5) array.
    """
    xx, yy, zz = (tensor[:, k, k] for k in range(3))
    off = [(tensor[:, a, b] + tensor[:, b, a]) / 2 for a, b in ((0, 1), (0, 2), (1, 2))]
    return np.stack([*off, (xx - yy) / 2, (2 * zz - xx - yy) / np.sqrt(12)], axis=1)


def _spread(stress, steps):
    """Mean square of the sum of the stress over so many steps, all components together."""
    sums = np.concatenate([np.zeros((1, stress.shape[1])), np.cumsum(stress, axis=0)])
    return ((sums[steps:] - sums[:-steps]) ** 2).mean()
