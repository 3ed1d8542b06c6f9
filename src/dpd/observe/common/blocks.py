"""What is kept of samples: averages over blocks, the raw material of error bars; rows of them."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping

    import numpy.typing as npt

BLOCKS = 50  # that a run is divided into, or fewer if it has fewer samples
FINE, FEW = 400, 200  # short blocks at most, of which those are made; fewer of large samples
LARGE = 20_000  # numbers in a sample
KINDS = ("sample", "frame", "run", "last")
JOIN: dict[str, np.ufunc] = {"block": np.add, "largest": np.maximum}


class Blocks:
    """Sums of samples in consecutive blocks (``block``), or the largest numbers (``largest``).

    How long the run will be does not matter: what is kept, in ``arrays``, is that of short blocks,
    first of a sample ``each``. Whenever all places are full, each two neighbours become one, and a
    block holds twice as many samples from then on. What is given in the end are `BLOCKS` blocks of
    4 to 8 of the short ones each, of which the last one may be half full.

    Parameters
    ----------
    shapes : dict of str to (str, tuple of int)
        By the name of each array: which of both (numbers of 0 or more for the largest), and the
        shape of a sample.
    """

    def __init__(self, shapes: Mapping[str, tuple[str, tuple[int, ...]]]) -> None:
        numbers = sum(math.prod(shape) for _, shape in shapes.values())
        self._places = FINE if numbers <= LARGE else FEW
        self._blocks = {
            name: np.zeros((self._places, *shape)) for name, (_, shape) in shapes.items()
        }
        self._join = {name: JOIN[kind] for name, (kind, _) in shapes.items()}
        self._each = np.ones(1, np.int64)
        self.arrays = self._blocks | ({"each": self._each} if shapes else {})

    def add(self, taken: int, values: Mapping[str, npt.ArrayLike]) -> None:
        """Add a sample of each array, after so many before it."""
        if taken == self._places * self._each[0]:
            half = self._places // 2
            for name, array in self._blocks.items():
                array[:half] = self._join[name](array[0::2], array[1::2])
                array[half:] = 0.0
            self._each *= 2
        place = taken // int(self._each[0])
        for name, array in self._blocks.items():
            array[place] = self._join[name](array[place], values[name])

    def results(self, taken: int) -> dict[str, np.ndarray]:
        """(blocks,) + shape arrays of so many samples; a single block of NaN without any."""
        short = -(-taken // int(self._each[0]))
        if not short:
            return {name: np.full((1, *a.shape[1:]), np.nan) for name, a in self._blocks.items()}
        block = np.arange(short) * min(BLOCKS, short) // short
        first = np.flatnonzero(np.diff(block, prepend=-1))
        samples = np.diff(np.append(first * self._each[0], taken))
        found = {}
        for name, array in self._blocks.items():
            found[name] = self._join[name].reduceat(array[:short], first, axis=0)
            if self._join[name] is np.add:
                found[name] /= samples.reshape(-1, *[1] * (array.ndim - 1))
        return found


class Rows:
    """Arrays with a row for each sample (NaN until it comes), or each frame, or a single one.

    Parameters
    ----------
    shapes : dict of str to (str, tuple of int)
        One of `KINDS`, and the shape of a sample, by the name of each array.
    samples : int
        In the run.
    average : int
        Samples in a frame; the last frame may have fewer.
    single : collection of str
        Names of those in single precision.
    """

    def __init__(
        self, shapes: Mapping[str, tuple[str, tuple[int, ...]]], samples: int, average: int,
        single: Collection[str] = (),
    ) -> None:  # fmt: skip
        self._kinds = {name: kind for name, (kind, _) in shapes.items()}
        self._average, self._frames = average, -(-samples // average)
        rows = {"sample": samples, "frame": self._frames, "run": 1, "last": 1}
        self.arrays = {
            name: np.full(
                (rows[kind], *shape),
                np.nan if kind == "sample" else 0,
                np.float32 if name in single else np.float64,
            )
            for name, (kind, shape) in shapes.items()
        }

    def add(self, taken: int, values: Mapping[str, npt.ArrayLike]) -> None:
        """Add a sample, after so many before it."""
        for name, array in self.arrays.items():
            kind, value = self._kinds[name], np.asarray(values[name], array.dtype)
            place = {"sample": taken, "frame": taken // self._average}.get(kind, 0)
            if kind in ("sample", "last"):
                array[place] = value
            else:
                array[place] += value

    def results(self, taken: int) -> dict[str, np.ndarray]:
        """By name; NaN without samples."""
        found = {}
        for name, array in self.arrays.items():
            kind = self._kinds[name]
            if kind == "sample":
                found[name] = array.copy()
            else:
                looks = self.looks(taken) if kind == "frame" else np.array([taken])
                looks = np.minimum(looks, 1) if kind == "last" else looks
                looks = looks.reshape(-1, *[1] * (array.ndim - 1)).astype(array.dtype)
                with np.errstate(invalid="ignore"):
                    array = array / looks
                found[name] = array if kind == "frame" else array[0]
        return found

    def looks(self, taken: int) -> np.ndarray:
        """(frames,) array: how many of so many samples are in each frame."""
        return np.clip(taken - self._average * np.arange(self._frames), 0, self._average)
