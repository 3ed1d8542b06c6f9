"""Correlation over many decades of time while a run goes on."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

KEPT = 16  # samples kept at each level, and so the lags of the first
COARSER = 4  # steps of a level in those of the level below
PARTS = 10  # of the run, for errors that know about what all molecules share
FARTHEST = 0.5  # of the run: lags reach so far at least
AT_ONCE = 16_384  # numbers of earlier samples, which stay in the cache
EACH = "each"  # name of the array with every contribution to a part of the run


class MultipleTau:
    """Averages of a function of two samples over the time between them.

    A level holds the last `KEPT` samples, each level at steps `COARSER` times as long: every
    lag is exact, none is averaged over samples (Frenkel and Smit, Understanding Molecular
    Simulation, Sec. 4.4.2). Lags reach up to half the run.

    How long a part is and how many levels there are follow from the length of the run. A longer
    run needs more than the sums of a shorter one, see `remember`.

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
        self._samples, self._shape, self._quantities = samples, shape, quantities
        self._levels = 1
        while KEPT * COARSER ** (self._levels - 1) < FARTHEST * samples:
            self._levels += 1
        self.arrays = self._zeros(self._levels)

    def _zeros(self, levels):
        quantities = self._quantities
        return {
            "taken": np.zeros(1, np.int64),
            "kept": np.zeros((levels, KEPT, *self._shape)),
            "sums": np.zeros((levels, KEPT, quantities, self._shape[-1])),
            "part_sums": np.zeros((PARTS, levels, KEPT, quantities)),
            "part_counts": np.zeros((PARTS, levels, KEPT), np.int64),
        }

    @property
    def remembered(self) -> int:
        """Bytes of the contributions that `remember` keeps."""
        return _rows(self._samples) * KEPT * self._quantities * 8

    def remember(self) -> None:
        """Keep from now on what a longer run needs to go on from; before the first sample.

        Those are all contributions to a part of the run, and the levels that a run of any length
        would have, up to one that has seen no more than the first sample.
        """
        levels = self._levels
        while COARSER ** (levels - 1) < self._samples:
            levels += 1
        self.arrays = self._zeros(levels)
        self.arrays[EACH] = np.zeros((_rows(self._samples), KEPT, self._quantities))

    def add(
        self, sample: np.ndarray, compare: Callable[[np.ndarray, np.ndarray], np.ndarray]
    ) -> None:
        """Compare a sample with those before it.

        Parameters
        ----------
        sample : array
        compare : callable
            Of a sample and some earlier ones, along a first axis of their own; gives a (lags,
            quantities, molecules) array.
        """
        taken = int(self.arrays["taken"][0])
        for level in _levels_at(taken, len(self.arrays["kept"])):
            self._compare(level, taken, sample, compare)
        self.arrays["taken"][0] += 1

    def _compare(self, level, taken, sample, compare):
        arrays, number = self.arrays, taken // COARSER**level
        kept = arrays["kept"][level]
        found = np.zeros((KEPT, self._quantities))
        lags, some = _lags(level, number), max(1, AT_ONCE // sample.size)
        for first in range(lags.start, lags.stop, some):
            end = min(first + some, lags.stop)
            earlier = kept[(number - np.arange(first, end)) % KEPT]
            one = compare(sample, earlier)
            arrays["sums"][level, first - 1 : end - 1] += one
            found[first - 1 : end - 1] = one.mean(axis=2)
        self._count(level, taken, found)
        if EACH in arrays and number > 0:
            arrays[EACH][_rows(taken) + level] = found
        kept[number % KEPT] = sample

    def _count(self, level, taken, found):
        """Add means over molecules to the part of the run that a sample is in."""
        part = taken * PARTS // self._samples
        lags = _lags(level, taken // COARSER**level)
        at = slice(lags.start - 1, lags.stop - 1)
        self.arrays["part_sums"][part, level, at] += found[at]
        self.arrays["part_counts"][part, level, at] += 1

    def go_on_from(self, former: Mapping[str, np.ndarray]) -> None:
        """Go on from a shorter run, as if it had been planned as long as this one.

        Parameters
        ----------
        former : dict of str to array
            Arrays of a run that remembered its contributions.
        """
        arrays, levels = self.arrays, len(former["kept"])
        for name in ("kept", "sums"):
            arrays[name][:levels] = former[name][: len(arrays[name])]
        arrays["kept"][levels:, 0] = former["kept"][-1, 0]  # all others are too late for them
        arrays["taken"][0] = taken = int(former["taken"][0])
        rows = _rows(taken)
        if EACH in arrays:
            arrays[EACH][:rows] = former[EACH][:rows]
        for number in range(1, taken):
            for level in _levels_at(number, len(arrays["kept"])):
                self._count(level, number, former[EACH][_rows(number) + level])

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
        arrays, levels = self.arrays, self._levels
        counts = arrays["part_counts"][:, :levels].reshape(PARTS, -1)
        total = counts.sum(axis=0)
        seen = total > 0
        _, _, quantities, molecules = arrays["sums"].shape
        lag = (np.arange(1, KEPT + 1) * COARSER ** np.arange(levels)[:, None]).ravel()
        sums = arrays["sums"][:levels].reshape(-1, quantities, molecules)
        parts = arrays["part_sums"][:, :levels].reshape(PARTS, -1, quantities)
        return (
            lag[seen], sums[seen] / total[seen, None, None], counts[:, seen].astype(float),
            parts[:, seen],
        )  # fmt: skip


def _levels_at(taken, levels):
    """Levels that take up a sample, by its number."""
    for level in range(levels):
        if taken % COARSER**level:
            break
        yield level


def _lags(level, number):
    """Lags of a level, in its own samples, for which it has an earlier sample."""
    return range(1 if level == 0 else KEPT // COARSER + 1, min(number, KEPT) + 1)


def _rows(taken):
    """Contributions of so many samples: each but the first has one at every level that takes it."""
    rows, apart = 0, 1
    while apart < taken:
        rows += (taken - 1) // apart
        apart *= COARSER
    return rows
