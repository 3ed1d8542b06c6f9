"""Averages over consecutive blocks of a run, the raw material of error bars."""

import numpy as np

BLOCKS = 50


class Blocks:
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
    """

    def __init__(self, shape, samples):
        self._blocks = max(1, min(BLOCKS, samples))
        self._samples = samples
        self.arrays = {
            "sums": np.zeros((self._blocks, *shape)),
            "taken": np.zeros(self._blocks, np.int64),
        }

    def open(self):
        """The sums of the block that the next sample belongs to; counts the sample."""
        taken = self.arrays["taken"]
        block = min(int(taken.sum()) * self._blocks // self._samples, self._blocks - 1)
        taken[block] += 1
        return self.arrays["sums"][block]

    def means(self):
        """(blocks,) + shape array of block averages."""
        taken = self.arrays["taken"]
        return self.arrays["sums"] / taken.reshape(-1, *[1] * (self.arrays["sums"].ndim - 1))
