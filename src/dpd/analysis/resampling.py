"""Functions of the time between two samples, with what they are without some of the data."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple, TypeVar

import numpy as np

from dpd.analysis.collect import first_scene
from dpd.analysis.degrees import taped, widened_by
from dpd.analysis.statistics import jackknife_error

if TYPE_CHECKING:
    from collections.abc import Callable

    import xarray as xr

    Value = TypeVar("Value", bound=float | np.ndarray)

GROUPS = 20  # of molecules, left out in turn
# By which the variance of a mean over parts is larger, as displacements that end in one have begun
# in the one before: of free diffusion 4/3 at the longest lag, 1 at the shortest.
OVERLAP = 1.2
DECADE = 10.0  # factor in time over which shared motion is measured


class Resampled(NamedTuple):
    """A mean-square displacement or a correlation at some lags.

    - ``time``: (lags,) array; in tau, increasing.
    - ``value``: (lags,) array.
    - ``without_molecules``: (groups, lags) array; leaving out a group of molecules in turn.
    - ``without_part``: (parts, lags) array; leaving out a part of a run in turn: what all molecules
      do together shows here.
    """

    time: np.ndarray
    value: np.ndarray
    without_molecules: np.ndarray
    without_part: np.ndarray

    @taped
    def derived(self, function: Callable[[np.ndarray], Value]) -> tuple[Value, float | np.ndarray]:
        """A quantity with its standard error.

        The larger of two jackknife errors: over molecules, and over parts of the runs, in which
        what all molecules do together shows. Both count as independent, but for `OVERLAP`. NaN
        where either is.

        ``function``: of a (lags,) array of values; gives a number or an array.
        """
        molecules = jackknife_error([function(row) for row in self.without_molecules])
        parts = np.sqrt(OVERLAP) * jackknife_error([function(row) for row in self.without_part])
        sides = len(self.without_molecules), len(self.without_part)
        widened_by(np.where(parts > molecules, sides[1], sides[0]) - 1.0, 1.0)  # it is the larger's
        return function(self.value), np.maximum(molecules, parts)


def part_length(runs: xr.Dataset) -> float:
    """Length in tau of one of the parts that a run's sums are kept for."""
    scene = first_scene(runs)
    return scene.steps.sample * scene.dt / runs.sizes["part"]


def resampled(
    runs: xr.Dataset, lag: str, members: str, times: str, each: str, sums: str, counts: str,
    reach: float = 1.0,
) -> Resampled:  # fmt: skip
    """What an observable kept of the replicas of one point, taken together.

    ``runs``: one point of a collected sweep, with the dimension ``replica``. ``lag``, ``members``:
    the dimensions of lags and of molecules. ``times``, ``each``, ``sums``, ``counts``: variables:
    lags in tau, means of each molecule, sums of means over molecules in parts of the run, and how
    many were summed. ``reach``: length in parts that lags may have. Beyond 1 parts are not
    independent, see `_far`.
    """
    runs = runs.transpose("replica", "part", lag, members, ...)
    time, part = runs[times].isel(replica=0).values, part_length(runs)
    seen = time <= reach * part * (1 + 1e-9)
    time = time[seen]
    count, total = runs[counts].values[:, :, seen], runs[sums].values[:, :, seen]
    order = np.argsort(time)
    single = runs[each].transpose("replica", members, lag).values[:, :, seen]
    weight = count.sum(axis=1)
    molecules = np.flatnonzero(np.isfinite(single[0]).all(axis=1))
    groups = np.array_split(molecules, min(GROUPS, len(molecules)))
    without = []
    for replica in range(len(single)):
        for group in groups:
            means = single[:, molecules].mean(axis=1)
            means[replica] = single[replica, np.setdiff1d(molecules, group)].mean(axis=0)
            without.append((means * weight).sum(axis=0) / weight.sum(axis=0))
    all_sums, all_counts = total.sum(axis=(0, 1)), count.sum(axis=(0, 1))
    parts = [
        (all_sums - total[r, p]) / (all_counts - count[r, p])
        for r in range(len(total))
        for p in range(total.shape[1])
    ]
    found = Resampled(
        time[order], (all_sums / all_counts)[order],
        np.array(without)[:, order], np.array(parts)[:, order],
    )  # fmt: skip
    return _far(found, part * (1 + 1e-9)) if reach > 1 else found


def _far(found, part):
    """With errors at lags longer than a part from molecules alone, as parts overlap there.

    How much larger errors are because molecules share motion is taken from the decade of lags up
    to a part: the ratio of both errors there, if it is above 1. In four groups of walkers that
    share up to 70 % of their steps the rms of z is 0.8 to 1.3, up to half the run.
    """
    value, molecules, parts = found.value, found.without_molecules, found.without_part
    far, near = found.time > part, (found.time > part / DECADE) & (found.time <= part)
    if not far.any() or not near.any():
        return found
    over_parts = np.sqrt(OVERLAP) * jackknife_error(parts[:, near] / value[near])
    over_molecules = jackknife_error(molecules[:, near] / value[near])
    shared = max(1.0, float(np.sqrt((over_parts**2).mean() / (over_molecules**2).mean())))
    return found._replace(
        without_molecules=np.where(far, value + shared * (molecules - value), molecules),
        without_part=np.where(far, value, parts),
    )
