"""Averages over consecutive blocks of a run, the raw material of error bars."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Mapping

    import numpy.typing as npt

BLOCKS = 50
EACH = "each"  # name of the array with every sample


class BlockSums:
    """Sums of an array-valued sample in consecutive blocks of equal length.

    How long a block is follows from the length of the run. A longer run therefore cannot go on
    from these sums: it needs every sample again, see `remember`.

    Parameters
    ----------
    shape : tuple of int
        Of one sample.
    samples : int
        Expected in the run.

    Attributes
    ----------
    arrays : dict
        ``sums`` of shape (blocks,) + shape, and ``taken``, the samples in each block.
    """

    def __init__(self, shape: tuple[int, ...], samples: int) -> None:
        self._count = max(1, min(BLOCKS, samples))
        self._samples = samples
        self.arrays = {
            "sums": np.zeros((self._count, *shape)),
            "taken": np.zeros(self._count, np.int64),
        }

    @property
    def taken(self) -> int:
        """Samples so far."""
        return int(self.arrays["taken"].sum())

    @property
    def remembered(self) -> int:
        """Bytes that `remember` takes."""
        return self._samples * self.arrays["sums"][0].nbytes

    def remember(self) -> None:
        """Keep every sample from now on, for a longer run to go on from."""
        shape = self.arrays["sums"].shape[1:]
        self.arrays[EACH] = np.full((self._samples, *shape), np.nan)

    def add(self, sample: npt.ArrayLike) -> None:
        """Add a sample to its block."""
        if EACH in self.arrays:
            self.arrays[EACH][self.taken] = sample
        self._add(sample)

    def _add(self, sample):
        block = self._block_of(self.taken)
        self.arrays["sums"][block] += sample
        self.arrays["taken"][block] += 1

    def _block_of(self, number):
        """The block of a sample, or of each of some, by its number."""
        return np.minimum(number * self._count // self._samples, self._count - 1)

    def go_on_from(self, former: Mapping[str, np.ndarray]) -> None:
        """Put the samples of a shorter run into the blocks of this one.

        Parameters
        ----------
        former : dict of str to array
            Arrays of a run that remembered its samples.
        """
        for sample in former[EACH][: former["taken"].sum()]:
            self.add(sample)

    def means(self) -> np.ndarray:
        """(blocks,) + shape array of block averages, NaN for a block without samples."""
        sums, taken = self.arrays["sums"], self.arrays["taken"]
        with np.errstate(invalid="ignore"):
            return sums / taken.reshape(-1, *[1] * (sums.ndim - 1))

    def largest(self, series: np.ndarray) -> np.ndarray:
        """(blocks,) array: the largest of a series in each block, 0 for a block without samples.

        Parameters
        ----------
        series : (samples,) array
            One number, 0 or more, for each sample.
        """
        found = np.zeros(self._count)
        np.maximum.at(found, self._block_of(np.arange(self.taken)), series[: self.taken])
        return found
