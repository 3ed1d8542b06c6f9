"""Correlation over many decades of time while a run goes on."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable

KEPT = 16  # samples kept at each level, and so the lags of the first
COARSER = 4  # steps of a level in those of the level below
PARTS = 10  # of the run, for errors that know about what all molecules share


class MultipleTau:
    """Averages of a function of two samples over the time between them.

    A level holds the last `KEPT` samples, each level at steps `COARSER` times as long: every
    lag is exact, none is averaged over samples (Frenkel and Smit, Understanding Molecular
    Simulation, Sec. 4.4.2). Lags reach up to the length of one part of the run; beyond, no
    error is to be had.

    Parameters
    ----------
    samples : int
        Expected in the run.
    shape : tuple of int
        Of a sample, molecules last.
    quantities : int
        Results per molecule.

    Attributes
    ----------
    arrays : dict
        All that a checkpoint has to hold.
    """

    def __init__(self, samples: int, shape: tuple[int, ...], quantities: int) -> None:
        self._samples = samples
        levels = 1
        while KEPT * COARSER ** (levels - 1) < samples / PARTS:
            levels += 1
        self.arrays = {
            "taken": np.zeros(1, np.int64),
            "kept": np.zeros((levels, KEPT, *shape)),
            "sums": np.zeros((levels, KEPT, quantities, shape[-1])),
            "part_sums": np.zeros((PARTS, levels, KEPT, quantities)),
            "part_counts": np.zeros((PARTS, levels, KEPT), np.int64),
        }

    def add(
        self, sample: np.ndarray, compare: Callable[[np.ndarray, np.ndarray], np.ndarray]
    ) -> None:
        """Compare a sample with those before it.

        Parameters
        ----------
        sample : array
        compare : callable
            Of a sample and an earlier one; gives a (quantities, molecules) array.
        """
        taken = int(self.arrays["taken"][0])
        for level in range(len(self.arrays["kept"])):
            if taken % COARSER**level:
                break
            self._compare(level, taken // COARSER**level, sample, compare)
        self.arrays["taken"][0] += 1

    def _compare(self, level, number, sample, compare):
        arrays = self.arrays
        kept = arrays["kept"][level]
        part = int(arrays["taken"][0]) * PARTS // self._samples
        for lag in range(1 if level == 0 else KEPT // COARSER + 1, min(number, KEPT) + 1):
            found = compare(sample, kept[(number - lag) % KEPT])
            arrays["sums"][level, lag - 1] += found
            arrays["part_sums"][part, level, lag - 1] += found.mean(axis=1)
            arrays["part_counts"][part, level, lag - 1] += 1
        kept[number % KEPT] = sample

    def results(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Lags that were seen, with means over the run and sums over its parts.

        Returns
        -------
        lag : (lags,) array
            In samples.
        means : (lags, quantities, molecules) array
        counts : (parts, lags) array
        sums : (parts, lags, quantities) array
            Of means over molecules.
        """
        arrays = self.arrays
        counts = arrays["part_counts"].reshape(PARTS, -1)
        total = counts.sum(axis=0)
        seen = total > 0
        levels, _, quantities, molecules = arrays["sums"].shape
        lag = (np.arange(1, KEPT + 1) * COARSER ** np.arange(levels)[:, None]).ravel()
        means = arrays["sums"].reshape(-1, quantities, molecules)[seen] / total[seen, None, None]
        sums = arrays["part_sums"].reshape(PARTS, -1, quantities)
        return lag[seen], means, counts[:, seen].astype(float), sums[:, seen]
