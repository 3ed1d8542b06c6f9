"""Averages over consecutive blocks of a run, the raw material of error bars."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    import numpy.typing as npt

BLOCKS = 50  # that a run is divided into, or fewer if it has fewer samples
FINE, FEW = 400, 200  # short blocks at most, of which those are made; fewer of large samples
LARGE = 20_000  # numbers in a sample


def places_for(*shapes: tuple[int, ...]) -> int:
    """Short blocks for samples of some shapes."""
    return FINE if max(map(math.prod, shapes), default=0) <= LARGE else FEW


class BlockSums:
    """Sums of an array-valued sample in consecutive blocks.

    How long the run will be does not matter: the sums are those of short blocks, first of a sample
    each. Whenever all places are full, each two neighbours become one, and a block holds twice as
    many samples from then on. What is given in the end are `BLOCKS` averages over 4 to 8 of the
    short blocks each, of which the last one may be half full.

    Parameters
    ----------
    shape : tuple of int
        Of one sample.
    places : int
        Short blocks; if not given, see `places_for`.

    Attributes
    ----------
    arrays : dict
        ``sums`` of shape (short blocks,) + shape, ``taken``, the samples so far, and ``each``, the
        samples in a short block.
    """

    def __init__(self, shape: tuple[int, ...], places: int = 0) -> None:
        places = places or places_for(shape)
        self.arrays = {
            "sums": np.zeros((places, *shape)),
            "taken": np.zeros(1, np.int64),
            "each": np.ones(1, np.int64),
        }

    @property
    def taken(self) -> int:
        """Samples so far."""
        return int(self.arrays["taken"][0])

    def add(self, sample: npt.ArrayLike) -> None:
        """Add a sample to its block."""
        sums, each = self.arrays["sums"], self.arrays["each"]
        if self.taken == len(sums) * each[0]:
            half = len(sums) // 2
            sums[:half] = sums[0::2] + sums[1::2]
            sums[half:] = 0.0
            each *= 2
        sums[self.taken // each[0]] += sample
        self.arrays["taken"] += 1

    def _groups(self):
        """The block of each short block, and how many samples that has."""
        each = int(self.arrays["each"][0])
        short = -(-self.taken // each)
        samples = np.minimum(each, self.taken - each * np.arange(short))
        return np.arange(short) * min(BLOCKS, short) // max(short, 1), samples

    def means(self) -> np.ndarray:
        """(blocks,) + shape array of block averages; a single block of NaN without samples."""
        sums, (block, taken) = self.arrays["sums"], self._groups()
        if not len(block):
            return np.full((1, *sums.shape[1:]), np.nan)
        first = np.flatnonzero(np.diff(block, prepend=-1))
        samples = np.bincount(block, taken)
        total = np.add.reduceat(sums[: len(block)], first, axis=0)
        return total / samples.reshape(-1, *[1] * (sums.ndim - 1))

    def largest(self, series: np.ndarray) -> np.ndarray:
        """(blocks,) array: the largest of a series in each block, 0 without samples.

        Parameters
        ----------
        series : (samples,) array
            One number, 0 or more, for each sample.
        """
        block = np.repeat(*self._groups())
        found = np.zeros(max(1, block.max(initial=0) + 1))
        np.maximum.at(found, block, series[: len(block)])
        return found
