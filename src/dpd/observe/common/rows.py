"""Samples one by one, means over frames or over the run, and what was found last."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping

    import numpy.typing as npt

KINDS = ("sample", "frame", "run", "last")


class Rows:
    """Arrays with a row for each sample, or each frame, or a single one.

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

    Attributes
    ----------
    arrays : dict
        By name. Samples that are yet to come are NaN.
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
