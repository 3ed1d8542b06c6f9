"""Functions of the time between two samples, with what they are without some of the data."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple, TypeVar

import numpy as np

from dpd.analysis.collect import first_scene
from dpd.analysis.degrees import taped
from dpd.analysis.statistics import jackknife_error

if TYPE_CHECKING:
    from collections.abc import Callable

    import xarray as xr

    Value = TypeVar("Value", bound=float | np.ndarray)

GROUPS = 20  # of molecules, left out in turn
# By which the variance of a mean over parts is larger, as displacements that end in one have begun
# in the one before: of free diffusion 4/3 at the longest lag, 1 at the shortest.
OVERLAP = 1.2


class Resampled(NamedTuple):
    """A mean-square displacement or a correlation at some lags.

    Attributes
    ----------
    time : (lags,) array
        In tau, increasing.
    value : (lags,) array
    without_molecules : (groups, lags) array
        Leaving out a group of molecules in turn.
    without_part : (parts, lags) array
        Leaving out a part of a run in turn: what all molecules do together shows here.
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

        Parameters
        ----------
        function : callable
            Of a (lags,) array of values; gives a number or an array.

        Returns
        -------
        value, error
        """
        molecules = jackknife_error([function(row) for row in self.without_molecules])
        parts = jackknife_error([function(row) for row in self.without_part])
        return function(self.value), np.maximum(molecules, np.sqrt(OVERLAP) * parts)


def part_length(runs: xr.Dataset) -> float:
    """Length in tau of one of the parts that a run's sums are kept for."""
    scene = first_scene(runs)
    return scene.steps.sample * scene.data["integrator"]["dt"] / runs.sizes["part"]


def resampled(
    runs: xr.Dataset, lag: str, members: str, times: str, each: str, sums: str, counts: str
) -> Resampled:
    """What an observable kept of the replicas of one point, taken together.

    Parameters
    ----------
    runs : xarray.Dataset
        One point of a collected sweep, with the dimension ``replica``.
    lag, members : str
        The dimensions of lags and of molecules.
    times, each, sums, counts : str
        Variables: lags in tau, means of each molecule, sums of means over molecules in parts
        of the run, and how many were summed.

    Returns
    -------
    Resampled
        At lags up to the length of a part: beyond, parts are not independent.
    """
    runs = runs.transpose("replica", "part", lag, members, ...)
    time = runs[times].isel(replica=0).values
    seen = time <= part_length(runs) * (1 + 1e-9)
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
    return Resampled(
        time[order], (all_sums / all_counts)[order],
        np.array(without)[:, order], np.array(parts)[:, order],
    )  # fmt: skip
