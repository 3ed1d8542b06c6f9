"""Sec. VI: width of the interfaces between monomers."""

import numpy as np
import xarray as xr

from dpd.analysis.composition import sweep_chi
from dpd.analysis.published import shown_by
from dpd.analysis.statistics import COVERAGE, linear_fit
from dpd.analysis.verdicts import Measured
from dpd.report.style import BLACK, panels, points, published_line
from paper_figures.groot_warren_1997.shared import SEGREGATION, misfit

PUBLISHED = shown_by(__file__)
AMPLITUDE, CRITICAL = PUBLISHED["width_amplitude_rho_3"], PUBLISHED["width_critical_rho_3"]

NEAR = 4.0  # chi; the note of each row says what the runs below give alone

TITLE = "Width of the interfaces between monomers."
PAPER_SHOWS = (
    "Not a figure of the paper: its Eq. 35 says that the width xi of Eq. 34 is "
    f"({AMPLITUDE}) / sqrt(rho [chi - ({CRITICAL})]) at rho 3 and 5 close to the critical point "
    "(how close, it does not say), found by plotting xi^-2 against chi (dashed), chi from Delta a "
    "by Eq. 24. Here all filled points are fitted; the table also says what those with chi below "
    f"{NEAR:g} give alone. Every block of a run is taken at its own "
    "positions of the interfaces, so that they do not widen by moving. Open points are not fitted, "
    "for the reasons given at Figure 7, but chi may be below 3. The waves on an interface "
    "widen it with the area, 8 x 8 here as there."
)
EXPONENTS = {"classical": 1 / 2, "ising": 1 / 1.6}
REACH = (2.2, 6.2)  # of chi in the picture
LINE = (
    "amplitude", "amplitude_error", "critical", "critical_error", "reduced_chi_square", "p_value",
)  # fmt: skip


def compute(sweeps):
    """Widths over chi for both densities, and straight lines through xi^(-1 / nu)."""
    parts = []
    for rho, runs in SEGREGATION.items():
        found = sweep_chi(sweeps[runs.sweep], "excess")
        data = found[["width", "width_error"]]
        data["chi"] = PUBLISHED[runs.slope].value * found.excess.astype(float)
        data.chi.attrs = {"units": "1", "long_name": "by Eq. 24 from Delta a"}
        known = data.width_error > 0  # not where a run is too short for an error
        fitted = ((found.settled == 1) & (data.chi > CRITICAL.value) & known).values
        data["fitted"] = ("excess", fitted)
        near = fitted & (data.chi < NEAR).values
        for kind, nu in EXPONENTS.items():
            for name, runs_of in ((kind, fitted), (f"{kind}_near", near)):
                for key, value in line(data.isel(excess=runs_of), rho, nu).items():
                    data[f"{name}_{key}"] = ((), value, {"units": "1"})
        parts.append(data.expand_dims(density=[rho]))
    return xr.concat(parts, "density", join="outer", fill_value={"fitted": False})


def line(data, rho, nu):
    """Fit xi^(-1 / nu) = s (chi - critical), and A of xi = A / sqrt(rho (chi - critical)).

    Returns
    -------
    dict
        ``amplitude``, ``critical``, each with ``_error``, ``reduced_chi_square``, and
        ``p_value``, the probability of points that scatter more about a straight line; NaN with
        fewer than three points.
    """
    if data.sizes["excess"] < 3:
        return dict.fromkeys(LINE, np.nan)
    chi, power = data.chi.values, -1 / nu
    y = data.width.values**power
    error = abs(power) * y * data.width_error.values / data.width.values
    middle = np.average(chi, weights=error**-2.0)  # about it, slope and constant do not correlate
    fit = linear_fit([chi - middle, np.ones_like(chi)], y, error)
    (slope, constant), (slope_error, constant_error) = fit.values, fit.errors
    shift = constant / slope
    shift_error = abs(shift) * np.hypot(constant_error / constant, slope_error / slope)
    amplitude = (slope / rho) ** -0.5
    return {
        "amplitude": amplitude,
        "amplitude_error": 0.5 * amplitude * slope_error / slope,
        "critical": middle - shift,
        "critical_error": shift_error,
        "reduced_chi_square": fit.reduced_chi_square,
        "p_value": fit.p_value,
    }


def measured(data):
    """The two numbers of Eq. 35 at both densities, and the critical chi for nu = 0.63."""
    found = {}
    for rho in SEGREGATION:
        at = data.sel(density=rho)
        for name, kind, quantity in (
            ("width_amplitude", "classical", "amplitude"),
            ("width_critical", "classical", "critical"),
            ("width_critical_ising", "ising", "critical"),
        ):
            key = f"{kind}_{quantity}"
            found[f"{name}_rho_{rho}"] = Measured(
                float(at[key]), float(at[f"{key}_error"]), fitted_runs(at, kind, quantity),
                no_line(at, kind),
            )  # fmt: skip
    return found


def no_line(at, kind):
    """Why no straight line was found at one density; empty if one was."""
    if at.fitted.sum() < 3:
        return "fewer than three runs in equilibrium"
    return misfit(float(at[f"{kind}_p_value"]), "a straight line", "its slope and its zero depend")


def fitted_runs(at, kind, quantity):
    """How many runs were fitted at one density, where, how well, and what those near chi_c give."""
    chi, quality = at.chi.where(at.fitted), float(at[f"{kind}_reduced_chi_square"])
    reach = f"chi from {float(chi.min()):.1f} to {float(chi.max()):.1f}"
    note = f"{int(at.fitted.sum())} runs, {reach}, reduced chi-square {quality:.1f}"
    near, error = (float(at[f"{kind}_near_{quantity}{part}"]) for part in ("", "_error"))
    if np.isnan(error):
        return note
    p = float(at[f"{kind}_near_p_value"])
    return f"{note}; with chi below {NEAR:g} alone {near:.2f} +- {error:.2f}, p = {p:.1g}"


def describe(data):
    """What is seen."""
    each = " and ".join(
        f"{float(data.classical_amplitude.sel(density=rho)):.2f} at density {rho}"
        for rho in SEGREGATION
    )
    return (
        "One over rho xi^2 rises in straight lines with chi, from zero near chi 2.4. Their slope "
        f"gives an amplitude of {each}; the dashed published line has {AMPLITUDE.value:g}."
    )


def draw(data):
    """1 / (rho xi^2) over chi: one straight line for both densities by Eq. 35."""
    figure, axes = panels(1)
    for rho, runs in SEGREGATION.items():
        name, color, marker = runs.look
        at = data.sel(density=rho).dropna("excess", subset=["width"])
        for fitted in (True, False):
            part = at.where(at.fitted == fitted, drop=True)
            y = 1 / (rho * part.width**2)
            label = name if fitted else None
            points(axes, part.chi, y, 2 * y * part.width_error / part.width, label, color, marker,
                   fitted)  # fmt: skip
        x = np.linspace(*REACH, 2)
        amplitude, critical = float(at.classical_amplitude), float(at.classical_critical)
        spread = COVERAGE * float(at.classical_amplitude_error)
        text = rf"fit at {name}: $A$ = {amplitude:.2f} ± {spread:.2f}"
        axes.plot(x, (x - critical) / amplitude**2, color=color, linewidth=0.8, label=text)
    eq_35 = (x - CRITICAL.value) / AMPLITUDE.value**2
    published_line(axes, x, eq_35, f"published, Eq. 35: $A$ = {AMPLITUDE.value:g}")
    axes.axhline(0, color=BLACK, linewidth=0.5)
    axes.set(xlim=REACH, ylim=(-0.02, 0.35), xlabel=r"$\chi$ from $\Delta a$ by Eq. 24",
             ylabel=r"$1 / (\rho \xi^2)$ / $r_c$")  # fmt: skip
    axes.legend(loc="upper left")
    return figure
