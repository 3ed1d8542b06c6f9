"""Averages over consecutive blocks of a run, the raw material of error bars."""

import numpy as np

BLOCKS = 50


class BlockSums:
    """Sums of an array-valued sample in consecutive blocks of equal length.

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
    count : int
        Number of blocks.
    current : int
        The block that was opened last.
    """

    def __init__(self, shape: tuple[int, ...], samples: int) -> None:
        self.count = max(1, min(BLOCKS, samples))
        self._samples = samples
        self.arrays = {
            "sums": np.zeros((self.count, *shape)),
            "taken": np.zeros(self.count, np.int64),
        }

    def open(self) -> np.ndarray:
        """The sums of the block that the next sample belongs to; counts the sample."""
        taken = self.arrays["taken"]
        self.current = min(int(taken.sum()) * self.count // self._samples, self.count - 1)
        taken[self.current] += 1
        return self.arrays["sums"][self.current]

    def means(self) -> np.ndarray:
        """(blocks,) + shape array of block averages, NaN for a block without samples."""
        sums, taken = self.arrays["sums"], self.arrays["taken"]
        with np.errstate(invalid="ignore"):
            return sums / taken.reshape(-1, *[1] * (sums.ndim - 1))
