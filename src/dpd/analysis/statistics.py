"""Means, errors that know about correlation, and fits."""

from typing import NamedTuple

import numpy as np

GROUPS = 10  # of blocks, left out in turn
BLOCKS = 50  # samples that a window needs to sum an autocorrelation
COVERAGE = 1.96  # standard errors on either side of a 95 % interval


def correlation_time(series):
    """Integrated autocorrelation time in samples, at least 1/2.

    The largest of `windowed_correlation_time` of the series and of the series averaged in pairs,
    in pairs of pairs and so on, as long as fifty remain. Noise from one sample to the next fades
    in averages, and a slow part below it, at which a window on the series itself would close too
    early, comes out. On white noise the largest is a fifth too large, and the error 8 %.

    Parameters
    ----------
    series : (n,) array

    Returns
    -------
    float
        The variance of the mean is 2 tau / n times the variance.
    """
    x = np.asarray(series, dtype=float)
    variance, length = x.var(), 1
    tau = windowed_correlation_time(x)
    while len(x) >= 2 * BLOCKS and variance > 0:
        x, length = joined_in_pairs(x), 2 * length
        tau = max(tau, length * windowed_correlation_time(x) * x.var() / variance)
    return tau


def windowed_correlation_time(series, window=5.0):
    """Integrated autocorrelation time in samples, by one window.

    tau = 1/2 + sum of the normalised autocorrelation up to the first lag that exceeds
    ``window`` times tau (Sokal's self-consistent window), times 1 + (2 lags + 1) / n for
    the autocorrelation that subtracting the sample's own mean has cost (Wolff 2004).

    Parameters
    ----------
    series : (n,) array
    window : float

    Returns
    -------
    float
        1/2 of fewer than four samples, or if all are the same.
    """
    x = series - series.mean()
    n = len(x)
    if n < 4 or not np.any(x):
        return 0.5
    size = 1 << (2 * n - 1).bit_length()
    spectrum = np.abs(np.fft.rfft(x, size)) ** 2
    covariance = np.fft.irfft(spectrum, size)[:n]
    tau = 0.5 + np.cumsum(covariance[1:] / covariance[0])
    beyond = np.arange(1, n) >= window * tau
    last = np.argmax(beyond) if beyond.any() else n - 2
    return max(0.5, float(tau[last]) * (1 + (2 * last + 3) / n))


def joined_in_pairs(x):
    """Means of neighbours along the first axis; an odd last one is left out."""
    even = len(x) // 2 * 2
    return 0.5 * (x[0:even:2] + x[1:even:2])


def mean_and_error(series):
    """Mean of a correlated series and its standard error.

    Parameters
    ----------
    series : (n,) array

    Returns
    -------
    mean, error, tau : float
        tau from `correlation_time`; the error of a single sample is NaN.
    """
    x = np.asarray(series, dtype=float)
    tau = correlation_time(x)
    if len(x) < 2:
        return float(x.mean()), np.nan, tau
    return float(x.mean()), float(np.sqrt(2 * tau / len(x) * x.var(ddof=1))), tau


class Trend(NamedTuple):
    """Slope of a series over time, its standard error, and the spread about that line."""

    slope: float
    error: float
    spread: float


def trend(time, series):
    """Linear trend of a correlated series.

    The error takes the correlation of what is left from the line into account as
    `mean_and_error` does: it holds where that is short beside the series.

    Parameters
    ----------
    time, series : (n,) arrays

    Returns
    -------
    Trend
        In the units of the series, per unit of time; NaN for fewer than three samples, or where
        one is missing.
    """
    t, x = np.asarray(time, dtype=float), np.asarray(series, dtype=float)
    if len(x) < 3 or not np.isfinite(x).all():
        return Trend(np.nan, np.nan, np.nan)
    t = t - t.mean()
    slope = t @ x / (t @ t)
    rest = x - x.mean() - slope * t
    spread = np.sqrt(rest @ rest / (len(x) - 2))
    error = spread * np.sqrt(2 * correlation_time(rest) / (t @ t))
    return Trend(float(slope), float(error), float(spread))


def block_mean_and_error(blocks):
    """Mean over the first axis and its standard error, by blocking.

    Blocks are joined two by two as long as ten remain, and the largest error counts
    (Flyvbjerg and Petersen 1989): errors grow with block length until blocks are
    independent.

    Parameters
    ----------
    blocks : (n, ...) array

    Returns
    -------
    mean, error : (...) arrays
    """
    x = np.asarray(blocks, dtype=float)
    mean = x.mean(axis=0)
    error = np.full(mean.shape, np.nan) if len(x) < 2 else np.zeros(mean.shape)
    while len(x) >= 2:
        error = np.maximum(error, x.std(axis=0, ddof=1) / np.sqrt(len(x)))
        if len(x) < 20:
            break
        x = joined_in_pairs(x)
    return mean, error


def middle_and_range(turns):
    """Median, smallest and largest over the last axis: of timings, which have no normal errors.

    Parameters
    ----------
    turns : (..., n) array

    Returns
    -------
    middle, low, high : (...) arrays
        NaN where a turn is.
    """
    return np.median(turns, axis=-1), np.min(turns, axis=-1), np.max(turns, axis=-1)


def jackknife(blocks, function):
    """A function of the mean over blocks, and its standard error by leaving out groups.

    Parameters
    ----------
    blocks : (n, ...) array
    function : callable
        Of a (...) array.

    Returns
    -------
    value, error : float
    """
    count = min(GROUPS, len(blocks))
    groups = np.array_split(np.arange(len(blocks)), count)
    left_out = np.array(
        [function(np.delete(blocks, group, axis=0).mean(axis=0)) for group in groups]
    )
    return float(function(blocks.mean(axis=0))), float(jackknife_error(left_out))


def jackknife_error(left_out):
    """Standard error of what was found leaving out one group after the other.

    Parameters
    ----------
    left_out : (groups, ...) array

    Returns
    -------
    (...) array
    """
    n = len(left_out)
    return np.sqrt((n - 1) / n * ((left_out - left_out.mean(axis=0)) ** 2).sum(axis=0))


def over_replicas(values, errors, axis):
    """Mean over independent replicas, and its standard error from theirs."""
    count = values.shape[axis]
    return values.mean(axis=axis), np.sqrt((errors**2).sum(axis=axis)) / count


class Fit(NamedTuple):
    """A least-squares fit that is linear in its coefficients.

    ``errors`` are standard errors, widened by sqrt(reduced chi-square) where the points
    scatter more than their own errors allow.
    """

    values: np.ndarray
    errors: np.ndarray
    reduced_chi_square: float
    degrees: int

    @property
    def p_value(self):
        """Probability of a worse chi-square if the model is right."""
        # Here, as most jobs need no SciPy; and scipy.stats would take most of a second to import.
        from scipy.special import chdtrc

        return float(chdtrc(self.degrees, self.reduced_chi_square * self.degrees))


def linear_fit(basis, y, error=None):
    """Weighted least squares y = sum_k c_k basis_k.

    Parameters
    ----------
    basis : (terms, n) array
    y : (n,) array
    error : (n,) array or None
        Standard errors > 0; without them all points weigh the same and their scatter
        about the fit is the error.

    Returns
    -------
    Fit

    Raises
    ------
    ValueError
        With fewer points than terms.
    """
    basis, y = np.atleast_2d(basis), np.asarray(y)
    least = 0.0 if error is None else 1.0
    error = np.ones(len(y)) if error is None else np.asarray(error)
    terms, n = basis.shape
    if n < terms:
        raise ValueError(f"{n} points do not fix {terms} coefficients")
    design = (basis / error).T
    covariance = np.linalg.inv(design.T @ design)
    values = covariance @ (design.T @ (y / error))
    residual = y / error - design @ values
    degrees = n - terms
    chi_square = float(residual @ residual) / degrees if degrees else np.nan
    widened = np.sqrt(max(least, chi_square)) if degrees else np.nan if least == 0 else 1.0
    return Fit(values, widened * np.sqrt(np.diag(covariance)), chi_square, degrees)
