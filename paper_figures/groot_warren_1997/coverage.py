"""How often 95 % intervals hold the truth: of pieces of a long run, whose mean is the truth."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from dpd.analysis.statistics import COVERAGE, averaged, block_mean_and_error, by_window

if TYPE_CHECKING:
    from collections.abc import Callable

    import numpy.typing as npt

    from dpd.analysis.statistics import Values

    Estimate = Callable[[np.ndarray], tuple[Values, Values]]


class Coverage(NamedTuple):
    """What became of the intervals of many runs of one length.

    - ``share``, ``error``: of the runs that have an error those whose interval holds the truth;
      standard error of a binomial count, by Agresti and Coull 1998 so that it is not 0 where all
      do.
    - ``too_short``: share of runs that were found too short for an error.
    - ``width``: median width of the intervals over that of a perfect one, 1.96 times the scatter of
      the means.
    - ``count``: runs that have an error.
    """

    share: float
    error: float
    too_short: float
    width: float
    count: int  # type: ignore[assignment]  # in place of tuple.count


def coverage(
    pieces: np.ndarray,
    truth: float,
    estimate: Estimate = block_mean_and_error,
    whole: float = np.inf,
) -> Coverage:
    """Coverage of the intervals of many runs.

    ``pieces``: (n, runs) array; time runs along the first axis. ``estimate``: mean and standard
    error of each column. ``whole``: number of such runs that the truth is the mean of, if these are
    among them: a mean is then nearer to it, its variance smaller by 1 / whole. Result: NaN where no
    run has an error.
    """
    mean, error = estimate(pieces)
    known = np.isfinite(error)
    count = int(known.sum())
    if count == 0:
        return Coverage(np.nan, np.nan, 1.0, np.nan, 0)
    apart, error = np.abs(mean - truth), error * np.sqrt(1 - 1 / whole)
    held = float((apart < COVERAGE * error)[known].sum())
    likely = (held + 2) / (count + 4)
    width = np.median(error[known]) / np.sqrt((apart**2).mean())
    return Coverage(
        held / count, np.sqrt(likely * (1 - likely) / (count + 4)), 1 - count / len(known),
        float(width), count,
    )  # fmt: skip


def slow_time(series: npt.ArrayLike) -> float:
    """Integrated autocorrelation time, in samples, of the slow part of a long series.

    Of its averages over one integrated autocorrelation time of the samples each, in which faster
    parts have faded. Of a single exponential it is 1.36 times that of the samples; where little
    of the variance is slow it is several times as long, and the one that decides how long a run
    has to be.
    """
    x = np.asarray(series)
    size = max(1, round(float(len(x) / by_window(x).times)))
    means = averaged(x, size)
    return size * float(len(means) / by_window(means).times)


def cut(series: np.ndarray, size: int) -> np.ndarray:
    """A long series cut into runs of so many samples, (size, runs)."""
    count = len(series) // size
    return series[: count * size].reshape(count, size).T


def coverage_of_pieces(
    series: npt.ArrayLike,
    size: int,
    estimate: Estimate = block_mean_and_error,
) -> Coverage:
    """Coverage of the pieces of one long series, its own mean being the truth."""
    pieces = cut(np.asarray(series), size)
    if pieces.shape[1] < 2:
        return Coverage(np.nan, np.nan, np.nan, np.nan, 0)
    return coverage(pieces, pieces.mean(), estimate, pieces.shape[1])
