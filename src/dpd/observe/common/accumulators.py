"""What is kept of samples: series, averages over blocks of the run, and over the time between."""

import math
from collections.abc import Callable, Collection, Mapping
from itertools import count

import numpy as np
import numpy.typing as npt

BLOCKS = 50  # that a run is divided into, or fewer if it has fewer samples
SHORT, FEW = 400, 200  # short blocks at most, of which those are made; fewer of large samples
LARGE = 20_000  # numbers in a sample
# How a sample is joined to those before it in its row; others have a row for each, or only one.
JOIN = {"block": np.add, "largest": np.maximum, "frame": np.add, "run": np.add}

KEPT = 16  # samples kept at each level, and so the lags of the first
COARSER = 4  # steps of a level in those of the level below
PARTS = 10  # of the run, for errors that know about what all molecules share
FINE = 320  # short parts at most, of which those are made
FARTHEST = 0.5  # of the run: lags reach so far at least
AT_ONCE = 65_536  # numbers of earlier samples, which stay in the cache


def _halve(array, join=np.add):
    """Make one row of each two neighbours, which leaves the second half free."""
    half = len(array) // 2
    array[:half] = join(array[0::2], array[1::2])
    array[half:] = 0


class Series:
    """Arrays with rows for samples, frames, or blocks of the run, or with a single one.

    So that blocks need not know how long the run will be, short ones are kept, first of a sample
    ``each``; whenever all places are full, each two neighbours become one. What is given are
    `BLOCKS` blocks of 4 to 8 of them each, of which the last one may be half full.

    ``shapes``: by name, the kind (`dpd.page.Observable.gives`) and the shape of a sample.
    ``average``: samples of a frame. ``single``: names of what is kept in single precision.
    """

    def __init__(
        self, shapes: Mapping[str, tuple[str, tuple[int, ...]]], samples: int, average: int = 1,
        single: Collection[str] = (),
    ) -> None:  # fmt: skip
        self._kinds = {name: kind for name, (kind, _) in shapes.items()}
        self._average, self._frames = average, -(-samples // average)
        blocked = [shape for kind, shape in shapes.values() if kind in ("block", "largest")]
        self._places = SHORT if sum(map(math.prod, blocked)) <= LARGE else FEW
        rows = {"sample": samples, "frame": self._frames, "run": 1, "last": 1}
        self.each = np.ones(1, np.int64)
        self.arrays = {}
        for name, (kind, shape) in shapes.items():
            dtype = np.float32 if name in single else np.float64
            self.arrays[name] = np.zeros((rows.get(kind, self._places), *shape), dtype)
            if kind == "sample":
                self.arrays[name][...] = np.nan

    def add(self, taken: int, values: Mapping[str, npt.ArrayLike]) -> None:
        """Add a sample of each, after so many before it."""
        if taken == self._places * self.each[0]:
            for name, kind in self._kinds.items():
                if kind in ("block", "largest"):
                    _halve(self.arrays[name], JOIN[kind])
            self.each *= 2
        block = taken // int(self.each[0])
        rows = {"sample": taken, "frame": taken // self._average, "run": 0, "last": 0}
        for name, array in self.arrays.items():
            kind, value = self._kinds[name], np.asarray(values[name], array.dtype)
            row = rows.get(kind, block)
            array[row] = JOIN[kind](array[row], value) if kind in JOIN else value

    def results(self, taken: int) -> dict[str, np.ndarray]:
        """By name, of so many samples; NaN, in a single block, without any."""
        return {name: self._result(name, kind, taken) for name, kind in self._kinds.items()}

    def _result(self, name, kind, taken):
        array = self.arrays[name]
        if kind == "sample":
            return array.copy()
        if kind == "frame":
            return _over(array, self.looks(taken))
        if kind in ("run", "last"):
            return _over(array, taken if kind == "run" else min(taken, 1))[0]
        if not taken:
            return np.full_like(array[:1], np.nan)
        each = int(self.each[0])
        short = -(-taken // each)
        block = np.arange(short) * min(BLOCKS, short) // short
        first = np.flatnonzero(np.diff(block, prepend=-1))
        found = JOIN[kind].reduceat(array[:short], first, axis=0)
        looks = np.diff(np.append(first * each, taken))
        return found if kind == "largest" else _over(found, looks)

    def looks(self, taken: int) -> np.ndarray:
        """(frames,) array: how many of so many samples are in each frame."""
        return np.clip(taken - self._average * np.arange(self._frames), 0, self._average)


def _over(sums, looks):
    """Means of so many samples in each row, to the precision of their sums."""
    looks = np.reshape(looks, (-1, *[1] * (sums.ndim - 1))).astype(sums.dtype)
    with np.errstate(invalid="ignore"):
        return sums / looks


class MultipleTau:
    """Averages of a function of two samples over the time between them, while a run goes on.

    A level holds the last `KEPT` samples, each level at steps `COARSER` times as long: every
    lag is exact, none is averaged over samples (Frenkel and Smit, Understanding Molecular
    Simulation, Sec. 4.4.2). Parts of the run are made of short ones, as blocks of `Series` are.

    ``shape``: of a sample, molecules last. ``quantities``: results per molecule.
    """

    def __init__(self, samples: int, shape: tuple[int, ...], quantities: int) -> None:
        levels = next(n for n in count(1) if COARSER**n >= samples)
        self.arrays = {
            "part_each": np.ones(1, np.int64),
            "earlier": np.zeros((levels, KEPT, *shape)),
            "lag_sums": np.zeros((levels, KEPT, quantities, shape[-1])),
            "part_sums": np.zeros((levels, FINE, KEPT, quantities)),
            "part_counts": np.zeros((levels, FINE, KEPT), np.int64),
        }

    def add(self, taken: int, sample: np.ndarray, compare: Callable[..., np.ndarray]) -> None:
        """Compare a sample with those ``taken`` before it, by a page's `compare`."""
        arrays, sample = self.arrays, np.ascontiguousarray(sample)
        if taken == FINE * arrays["part_each"][0]:
            for name in ("part_sums", "part_counts"):
                _halve(arrays[name].swapaxes(0, 1))
            arrays["part_each"] *= 2
        for level in range(len(arrays["earlier"])):
            if taken % COARSER**level or (level and not taken):  # nor any level above
                break
            self._compare(level, taken, sample, compare)

    def _compare(self, level, taken, sample, compare):
        from dpd.engine.measure import add_lags

        arrays, number = self.arrays, taken // COARSER**level
        kept, part = arrays["earlier"][level], taken // int(arrays["part_each"][0])
        if level > 0 and number == 1:  # a level begins when that below still holds its first
            kept[0] = arrays["earlier"][level - 1, 0]
        # Earlier samples by their number, in the order in which they lie: the longest lag first.
        first, last = max(0, number - KEPT), number - (1 if level == 0 else KEPT // COARSER + 1)
        while first <= last:
            place = first % KEPT
            end = min(last + 1, first + KEPT - place, first + max(1, AT_ONCE // sample.size))
            at, then = slice(number - end, number - first), kept[place : place + end - first]
            sums, found = arrays["lag_sums"][level, at], compare(sample, then)
            if found.shape[1] not in (1, sums.shape[1]) or found.shape[::2] != sums.shape[::2]:
                raise ValueError(f"'compare' gives {found.shape}, instead of {sums.shape}")
            found = np.ascontiguousarray(found, float)
            add_lags(sums, arrays["part_sums"][level, part, at], found)
            arrays["part_counts"][level, part, at] += 1
            first = end
        kept[number % KEPT] = sample

    def results(self, taken: int) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Lags that were seen in so many samples, in samples, with what was found over each.

        Means over the run, (lags, quantities, molecules); how many pairs of samples end in each
        part of the run, (parts, lags); sums over these of means over molecules, (parts, lags,
        quantities).
        """
        arrays = self.arrays
        levels = next(n for n in count(1) if KEPT * COARSER ** (n - 1) >= FARTHEST * taken)
        short = -(-taken // int(arrays["part_each"][0]))  # the last one may hold fewer samples
        part = np.arange(short) * PARTS // max(short, 1)
        found = []
        for name in ("part_counts", "part_sums"):
            array = arrays[name][:levels, :short].swapaxes(0, 1)
            sums = np.zeros((PARTS, *array.shape[1:]))
            np.add.at(sums, part, array)
            found.append(sums.reshape(PARTS, levels * KEPT, -1))
        counts, parts = found[0][..., 0], found[1]
        total = counts.sum(axis=0)
        seen = total > 0
        lag = (np.arange(1, KEPT + 1) * COARSER ** np.arange(levels)[:, None]).ravel()
        sums = arrays["lag_sums"][:levels].reshape(levels * KEPT, *arrays["lag_sums"].shape[2:])
        means = sums[seen] / total[seen, None, None]
        return lag[seen], means, counts[:, seen], parts[:, seen]
