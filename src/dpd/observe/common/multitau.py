"""Correlation over many decades of time while a run goes on."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable

KEPT = 16  # samples kept at each level, and so the lags of the first
COARSER = 4  # steps of a level in those of the level below
PARTS = 10  # of the run, for errors that know about what all molecules share
FINE = 320  # short parts at most, of which those are made
FARTHEST = 0.5  # of the run: lags reach so far at least
AT_ONCE = 65_536  # numbers of earlier samples, which stay in the cache


class MultipleTau:
    """Averages of a function of two samples over the time between them.

    A level holds the last `KEPT` samples, each level at steps `COARSER` times as long: every
    lag is exact, none is averaged over samples (Frenkel and Smit, Understanding Molecular
    Simulation, Sec. 4.4.2). Lags reach up to half the run.

    A level begins with its second sample, when the level below still holds its first; so it does
    not matter how long the run was planned to be, which only gives the room. Parts of the run are
    made of short ones, of which two neighbours become one whenever all places are full. ``arrays``
    are all that a checkpoint has to hold.

    Parameters
    ----------
    samples : int
        Expected in the run.
    shape : tuple of int
        Of a sample, molecules last.
    quantities : int
        Results per molecule.
    """

    def __init__(self, samples: int, shape: tuple[int, ...], quantities: int) -> None:
        levels = 1
        while COARSER**levels < samples:
            levels += 1
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
                array = arrays[name]
                array[:, : FINE // 2] = array[:, 0::2] + array[:, 1::2]
                array[:, FINE // 2 :] = 0
            arrays["part_each"] *= 2
        for level in range(len(arrays["earlier"])):
            if taken % COARSER**level or (level and not taken):  # nor any level above
                break
            self._compare(level, taken, sample, compare)

    def _compare(self, level, taken, sample, compare):
        from dpd.engine.queries.beads import add_lags

        arrays, number = self.arrays, taken // COARSER**level
        kept, part = arrays["earlier"][level], taken // int(arrays["part_each"][0])
        if level > 0 and number == 1:
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
        """Lags that were seen in so many samples, with means over the run and sums over its parts.

        Returns
        -------
        lag : (lags,) array
            In samples.
        means : (lags, quantities, molecules) array
        counts : (parts, lags) array
        sums : (parts, lags, quantities) array
            Of means over molecules.
        """
        arrays, levels = self.arrays, 1
        while KEPT * COARSER ** (levels - 1) < FARTHEST * taken:
            levels += 1
        short = -(-taken // int(arrays["part_each"][0]))  # the last one may hold fewer samples
        part = np.arange(short) * PARTS // max(short, 1)
        counts, parts = (
            np.zeros((PARTS, *array[:levels].swapaxes(0, 1).shape[1:]))
            for array in (arrays["part_counts"], arrays["part_sums"])
        )
        np.add.at(counts, part, arrays["part_counts"][:levels, :short].swapaxes(0, 1))
        np.add.at(parts, part, arrays["part_sums"][:levels, :short].swapaxes(0, 1))
        counts, parts = counts.reshape(PARTS, -1), parts.reshape(PARTS, counts[0].size, -1)
        total = counts.sum(axis=0)
        seen = total > 0
        _, _, quantities, molecules = arrays["lag_sums"].shape
        lag = (np.arange(1, KEPT + 1) * COARSER ** np.arange(levels)[:, None]).ravel()
        sums = arrays["lag_sums"][:levels].reshape(-1, quantities, molecules)
        return (
            lag[seen], sums[seen] / total[seen, None, None], counts[:, seen], parts[:, seen],
        )  # fmt: skip
