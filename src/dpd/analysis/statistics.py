"""Means, errors that know about correlation, their degrees of freedom, and fits."""

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from functools import wraps
from typing import Any, NamedTuple, ParamSpec, TypeVar

import numpy as np
import numpy.typing as npt

P = ParamSpec("P")
R = TypeVar("R")
Errors = Mapping[str, float]
Values = float | np.ndarray  # numbers of data that have one dimension, else arrays

COVERAGE = 1.96  # standard errors on either side of a 95 % interval
LEVEL = 0.975  # below the upper end of that interval
MANY = 1e6  # degrees of freedom that stand for a variance that is known
GROUPS = 50  # of blocks, left out in turn
BLOCKS, LEAST = 64, 4  # averages that show a slow part; at least so many samples make one
# Correlation times that an autocorrelation is summed up to: of many samples, of averages in which a
# slow part may hide, and of few blocks. Each more costs degrees of freedom, n / (2 W + 1) of n.
WINDOW, OF_AVERAGES, OF_BLOCKS = 5.0, 3.0, 1.5
SURE = 0.5  # standard errors by which averages have to say something else than the samples do
FEW = 25  # values below which their own correlation cannot be told
PARTS = 4  # that so few are joined to
# Correlation times, as measured, below which a run is too short for an error. Meant is 20: there
# the measured time scatters by its own size, and twice the true one is met in 1 of 15 runs.
TOO_SHORT = 10.0
UNLIKELY = 0.01  # probability of a scatter about a fit that errors of points do not explain
NONE_SEEN = 3.0  # mean count that is excluded at 95 % where none is seen: exp(-3) = 0.05
ROUNDING = 1e-12  # of the largest value: what scatters less is constant
DRAWS = 24  # of scattered errors, by which `degrees_of` finds degrees of freedom
STEADY = 1e-10  # variance of the logarithm of an error that does not scatter


class _Tape:
    """What taped functions gave, in their order, with the degrees of freedom of their errors."""

    def __init__(self) -> None:
        self.made: list[tuple[Callable, Any, Any]] = []
        self.inside = False  # of a taped function: what it calls is not kept apart
        self.degrees: Any = np.inf
        self.rng = np.random.default_rng(1)
        self.at: int | None = None  # None while it records

    def scattered(self, degrees: Any) -> Any:
        """A factor on an error that has so many degrees of freedom."""
        many = np.fmin(np.maximum(degrees, 0.1), 1e9)
        return np.sqrt(self.rng.chisquare(many) / many)


_tape: _Tape | None = None


def taped(function: Callable[P, R]) -> Callable[P, R]:
    """Let `degrees_of` know a function that gives a value and its error, or takes long."""

    @wraps(function)
    def played(*args: P.args, **kwargs: P.kwargs) -> Any:
        if (tape := _tape) is None or tape.inside:
            return function(*args, **kwargs)
        if tape.at is None:
            tape.inside, tape.degrees = True, np.inf
            try:
                found: Any = function(*args, **kwargs)
            finally:
                tape.inside = False
            tape.made.append((function, found, tape.degrees))
            return found
        known, found, degrees = tape.made[tape.at]
        if known != function:
            raise LookupError("errors decided what was calculated")
        tape.at += 1
        if not (isinstance(found, tuple) and len(found) == 2):
            return found
        value, error = found
        return value, error * tape.scattered(np.broadcast_to(degrees, np.shape(error)))

    return played


def widened_by(degrees: Any, factor: Any) -> Any:
    """Student's factor on an error; scattered while `degrees_of` makes errors again."""
    if _tape is not None and _tape.at is None:
        _tape.degrees = degrees
    if _tape is not None and _tape.at is not None:
        factor = factor * _tape.scattered(degrees)
    return factor


def degrees_of(make: Callable[[Callable[[Any], Any]], tuple[R, Errors]]) -> tuple[R, Errors]:
    """What a function makes, and the degrees of freedom of the errors that it gives, by name.

    What `taped` functions give is made once; then all is made again with each error multiplied by
    the root of chi-square over its degrees of freedom. How far the error at the end scatters says
    how many it has: of sums of variances what Welch and Satterthwaite have, and it holds for fits
    as well. Infinite of errors that do not scatter; none where errors decide what is calculated.

    ``make`` gets a function that gives such factors, for errors that were made before; it returns
    what is asked for, and errors by name.
    """
    global _tape
    _tape = tape = _Tape()
    found: list[Errors] = []
    try:
        made, first = make(np.ones_like)
        for _ in range(DRAWS):
            tape.at = 0
            with suppress(Exception):  # where errors decide what is calculated
                found.append(make(tape.scattered)[1])
    finally:
        _tape = None
    degrees = {}
    for name in first:
        drawn = np.array([draw.get(name, np.nan) for draw in found], dtype=float)
        logarithms = np.log(drawn[drawn > 0])
        if len(logarithms) > DRAWS / 2:
            spread = logarithms.var(ddof=1)
            degrees[name] = float(0.5 / spread) if spread > STEADY else np.inf
    return made, degrees


def student(degrees: Values) -> Values:
    """Student's t over 1.96, of so many degrees of freedom."""
    from scipy.special import stdtrit  # most jobs need no SciPy; scipy.stats takes a second

    return stdtrit(np.minimum(degrees, MANY), LEVEL) / COVERAGE


def widening(degrees: Values) -> Values:
    """Student's t over 1.96, by which every error here is widened to make 1.96 of it 95 %."""
    return widened_by(degrees, student(degrees))


class Spread(NamedTuple):
    """What a correlated series says of the error of its mean; (...) arrays."""

    variance: Values  # of the mean
    degrees: Values  # of freedom that fix the variance: 2 over its squared relative error
    # Length of the series in integrated autocorrelation times: of the samples, or, where a slow
    # part below noise decides, of their averages, which show that part's own time.
    times: Values


def by_window(x: np.ndarray, reach: float = WINDOW, alike: bool = False) -> Spread:
    """Variance of the mean of a series, (n, ...), n > 1, by its autocorrelation up to one window.

    It is 2 tau / n times that of the samples. tau = 1/2 + sum of the normalised autocorrelation up
    to the first lag W that is ``reach`` times tau (Sokal), with what a single exponential has
    beyond it, times 1 + (2 W + 1) / n for subtracting the sample's own mean (Wolff 2004, Eq. 49),
    and at least 1/4: a floor of 1/2 made errors of white noise a tenth too large. By his Eq. 42 the
    variance has n / (2 W + 1) degrees of freedom; half a one less as W is found with it (by
    calibration).

    ``alike``: whether the last axis counts replicas, of one variance and correlation.
    """
    n, replicas = len(x), x.shape[-1] if alike else 1
    x = x - x.mean(axis=0)
    size = 1 << (2 * n - 1).bit_length()
    power = np.abs(np.fft.rfft(x, size, axis=0)) ** 2
    if alike:
        power = power.mean(axis=-1, keepdims=True)
    covariance = np.fft.irfft(power, size, axis=0)[:n]
    variance = covariance[0] / n
    scale = np.where(variance == 0, 1, variance) * n
    tau = 0.5 + np.cumsum(covariance[1:] / scale, axis=0)
    lag = np.arange(1, n).reshape(-1, *[1] * (tau.ndim - 1))
    beyond = lag >= reach * np.maximum(tau, 0.5)
    beyond[-1] = True
    window = beyond.argmax(axis=0) + 1
    tau = np.take_along_axis(tau, window[None] - 1, axis=0)[0]
    tau = 0.5 + (tau - 0.5) / (1 - np.exp(-window / np.maximum(tau, 0.5)))
    tau = np.maximum(tau * (1 + (2 * window + 1) / n), 0.25)
    degrees = np.clip(replicas * n / (2 * window + 1) - 0.5, 1, replicas * (n - 1))
    found = 2 * tau * variance / (n - 1), degrees, n / tau
    return Spread(*(np.broadcast_to(each, x.shape[1:]) for each in found))


def spread_of_mean(x: np.ndarray, alike: bool = False) -> Spread:
    """Variance of the mean of a correlated series, (n, ...), n > 1.

    By `by_window`, of the samples, and of about 25 to 64 averages over consecutive ones, which
    count where they say something else by `SURE` standard errors: a slow part below the noise comes
    out in them, and a long tail of negative correlation, as of the force on a wall, whose error by
    the samples is four times too large. Fewer than 25 cannot tell their correlation: four parts of
    them count as independent, and ``times`` is infinite.

    ``alike``: as of `by_window`. Result: of the mean of one replica; degrees are of all together.
    """
    n = len(x)
    if n < FEW:
        parts = np.array([part.mean(axis=0) for part in np.array_split(x, min(PARTS, n))])
        variance = parts.var(axis=0, ddof=1) / len(parts)
        degrees = np.full(variance.shape, len(parts) - 1.0)
        if alike:
            degrees *= variance.shape[-1]
            variance = np.broadcast_to(variance.mean(axis=-1, keepdims=True), variance.shape)
        return Spread(variance, degrees, np.full(variance.shape, np.inf))
    count = min(BLOCKS, n // LEAST)
    if count < FEW:
        return by_window(x, OF_BLOCKS, alike)
    fine = by_window(x, WINDOW, alike)
    coarse = by_window(averaged(x, n // count), OF_AVERAGES, alike)
    apart = 1 + SURE * np.sqrt(2 / coarse.degrees)
    low, high = np.sort([fine.variance, coarse.variance], axis=0)
    return Spread(*(np.where(high > low * apart, *pair) for pair in zip(coarse, fine)))


def averaged(x: np.ndarray, size: int) -> np.ndarray:
    """Means of so many consecutive values along the first axis; the first few are left out."""
    count = len(x) // size
    return x[len(x) - count * size :].reshape(count, size, *x.shape[1:]).mean(axis=1)


@taped
def block_mean_and_error(blocks: npt.ArrayLike, alike: bool = False) -> tuple[Values, Values]:
    """Mean over the first axis, in which time runs, of (n, ...) values, and its standard error.

    ``alike``: as of `by_window`. NaN for a single block, and where a run is `TOO_SHORT`.
    """
    x = np.asarray(blocks, dtype=float)
    mean = x.mean(axis=0)
    if len(x) < 2:
        return mean, np.full(mean.shape, np.nan)
    found = spread_of_mean(x, alike)
    error = np.sqrt(found.variance) * widening(found.degrees)
    error = np.where(found.times < TOO_SHORT, np.nan, error)
    return mean, np.where(x.std(axis=0) <= ROUNDING * np.abs(x).max(axis=0), 0.0, error)


@taped
def correlation_time(series: npt.ArrayLike) -> float:
    """Integrated autocorrelation time in samples of an (n,) series, or of (n, replicas) alike.

    At least 1/2, and that for fewer than 25 samples, or if all are the same.
    """
    x = np.asarray(series, dtype=float)
    x = x.reshape(len(x), -1)
    if len(x) < FEW or not x.var() > 0:
        return 0.5
    variance = float(np.mean(spread_of_mean(x, alike=True).variance))
    return max(0.5, variance * len(x) / (2 * x.var(axis=0, ddof=1).mean()))


def mean_and_error(series: npt.ArrayLike) -> tuple[float, float, float]:
    """Mean of a correlated (n,) series, its standard error and its correlation time in samples."""
    mean, error = block_mean_and_error(series)
    return float(mean), float(error), correlation_time(series)


@taped
def independent_mean_and_error(samples: npt.ArrayLike) -> tuple[Values, Values]:
    """Mean of independent values along the last axis, as of replicas, and its error; NaN of one."""
    x = np.asarray(samples, dtype=float)
    n, mean = x.shape[-1], x.mean(axis=-1)
    if n < 2:
        return mean, np.full(mean.shape, np.nan)
    return mean, x.std(axis=-1, ddof=1) / np.sqrt(n) * widening(n - 1)


def trend(time: npt.ArrayLike, series: npt.ArrayLike) -> tuple[float, float, float]:
    """Slope of a correlated (n,) series per unit of time, its error, and the spread about the line.

    The error is by the correlation of what is left from the line, 0 if that is rounding. NaN for
    fewer than three samples, or where one is missing.
    """
    t, x = np.asarray(time, dtype=float), np.asarray(series, dtype=float)
    if len(x) < 3 or not np.isfinite(x).all():
        return np.nan, np.nan, np.nan
    t = t - t.mean()
    slope = t @ x / (t @ t)
    rest = x - x.mean() - slope * t
    spread = np.sqrt(rest @ rest / (len(x) - 2))
    if spread <= ROUNDING * np.abs(x).max():
        return float(slope), 0.0, float(spread)
    error = spread / np.sqrt(t @ t)
    if len(x) < FEW:
        return float(slope), float(error * widening(len(x) - 2)), float(spread)
    found = spread_of_mean(rest)
    error *= np.sqrt(found.variance * len(x) / rest.var(ddof=1)) * widening(found.degrees)
    return float(slope), float(error) if found.times >= TOO_SHORT else np.nan, float(spread)


@taped
def jackknife(blocks: np.ndarray, function: Callable[[np.ndarray], float]) -> tuple[float, float]:
    """A function of the mean over (n, ...) blocks in time, and its error by leaving out groups."""
    groups = np.array_split(np.arange(len(blocks)), min(GROUPS, len(blocks)))
    value = float(function(blocks.mean(axis=0)))
    if len(groups) < 2:
        return value, np.nan
    left_out = [function(np.delete(blocks, group, axis=0).mean(axis=0)) for group in groups]
    return value, float(jackknife_error(left_out, serial=True))


def jackknife_error(left_out: Sequence[Values] | np.ndarray, serial: bool = False) -> Values:
    """Standard error of what was found leaving out one of several groups, (groups, ...).

    It is that of the mean of Tukey's pseudo-values, but for a constant. ``serial``: the groups are
    parts of a run in time, and so correlated; others are independent.
    """
    values = -(len(left_out) - 1) * np.asarray(left_out)
    if serial:
        return block_mean_and_error(values)[1]
    return independent_mean_and_error(np.moveaxis(values, 0, -1))[1]


def over_replicas(values: np.ndarray, errors: np.ndarray, axis: int) -> tuple[Values, Values]:
    """Mean over independent replicas, and its error from theirs; NaN where one has none."""
    count = values.shape[axis]
    return values.mean(axis=axis), np.sqrt((errors**2).sum(axis=axis)) / count


class Fit(NamedTuple):
    """A least-squares fit that is linear in its coefficients."""

    values: np.ndarray
    errors: np.ndarray  # those of the points, carried over, and widened by their `scatter`
    reduced_chi_square: float
    degrees: int

    @property
    def p_value(self) -> float:
        """Probability of a worse chi-square if the model is right."""
        return likelihood(self.reduced_chi_square * self.degrees, self.degrees)

    @property
    def systematic(self) -> np.ndarray:
        """The part of ``errors``, of a fit to points with errors, that `scatter` has added."""
        return self.errors * misfit_share(self.reduced_chi_square, self.p_value)


def likelihood(chi_square: float, degrees: int) -> float:
    """Probability of a worse chi-square, of points with some degrees of freedom."""
    from scipy.special import chdtrc

    return float(chdtrc(degrees, chi_square))


def scatter(chi_square: float, degrees: int) -> float:
    """Factor on errors of a fit: 1, or the root of a reduced chi-square that is `UNLIKELY` large.

    One that follows each larger chi-square, and never is below 1, is too large on average: by a
    quarter with one degree of freedom.
    """
    if degrees and likelihood(chi_square, degrees) < UNLIKELY:
        return float(np.sqrt(chi_square / degrees))
    return 1.0


def misfit_share(reduced_chi_square: float, p_value: float) -> float:
    """The share of an error that `scatter` has added: more sampling does not lower it."""
    return float(np.sqrt(1 - 1 / reduced_chi_square)) if p_value < UNLIKELY else 0.0


def linear_fit(basis: npt.ArrayLike, y: npt.ArrayLike, error: npt.ArrayLike | None = None) -> Fit:
    """Weighted least squares y = sum_k c_k basis_k, of a (terms, n) basis and (n,) points.

    ``error``: standard errors > 0; without them all points weigh the same, and scatter is the
    error. Raises `ValueError` with fewer points than terms, or with a point that has no error > 0.
    """
    basis, y, alone = np.atleast_2d(basis), np.asarray(y), error is None
    error = np.ones(len(y)) if error is None else np.asarray(error)
    if unknown := np.sum(~(np.isfinite(error) & (error > 0))):
        text = "points have no error > 0, and so no weight: leave them out before the fit"
        raise ValueError(f"{unknown} of {len(y)} {text}")
    terms, n = basis.shape
    if n < terms:
        raise ValueError(f"{n} points do not fix {terms} coefficients")
    design = (basis / error).T
    q, r = np.linalg.qr(design)
    values = np.linalg.solve(r, q.T @ (y / error))
    spread = np.linalg.norm(np.linalg.inv(r), axis=1)  # root of the diagonal of the covariance
    residual = y / error - design @ values
    degrees = n - terms
    chi_square = float(residual @ residual)
    quality = chi_square / degrees if degrees else np.nan
    factor = np.sqrt(quality) * widening(degrees) if alone else scatter(chi_square, degrees)
    return Fit(values, factor * spread, quality, degrees)


def interval(count: npt.ArrayLike) -> tuple[np.ndarray, np.ndarray]:
    """Ends of the 95 % interval of the mean of a Poisson distribution, of which one count is known.

    F. Garwood, Biometrika 28, 437 (1936). Where none is seen there is no lower end, and the upper
    one has all 5 %; so means between 3.0 and 3.7 are covered a little less often, by 94 %.
    """
    from scipy.special import gammaincinv  # most jobs need no SciPy

    count = np.asarray(count, dtype=float)
    low = np.where(count > 0, gammaincinv(np.maximum(count, 1), 0.025), 0)
    return low, np.where(count > 0, gammaincinv(count + 1, 0.975), NONE_SEEN)
