"""Sec. VI: width of the interfaces between monomers."""

import numpy as np
import xarray as xr

from dpd.analysis.interfaces import sweep_chi
from dpd.analysis.statistics import COVERAGE, linear_fit
from dpd.analysis.verdicts import Measured, shown_by
from dpd.report.style import BLACK, GREEN, Look, panels, points, published_line
from dpd.report.text import with_error
from paper_figures.groot_warren_1997.shared import SEGREGATION, misfit

PUBLISHED = shown_by(__file__)
AMPLITUDE, CRITICAL = PUBLISHED["width_amplitude_rho_3"], PUBLISHED["width_critical_rho_3"]

NEAR = 4.0  # chi below which a run counts as close to the critical point
NARROW = Look(r"$\rho$ = 5, smaller area", GREEN, "^")

TITLE = "Width of the interfaces between monomers."
PAPER_SHOWS = (
    "Not a figure of the paper: its Eq. 35 says that the width xi of Eq. 34 is "
    f"({AMPLITUDE}) / sqrt(rho [chi - ({CRITICAL})]) at rho 3 and 5 close to the critical point, "
    "found by plotting xi^-2 against chi (dashed), chi from Delta a by Eq. 24. How close, it does "
    f"not say: filled points, with chi below {NEAR:g}, are fitted; the table also says what all "
    "runs give. Every block of a run is taken at its own "
    "positions of the interfaces, so that they do not widen by moving. Open points are not fitted, "
    f"as chi is above {NEAR:g}, or for the reasons given at Figure 7, but chi may be below 3. The "
    "waves on an interface widen it with the area, 8 x 8 at rho 3, as there. At rho 5 the text "
    "does not name the box: squares have that of rho 3, triangles one with as many beads."
)
EXPONENTS = {"classical": 1 / 2, "ising": 1 / 1.6}
REACH = (2.2, 6.2)  # of chi in the picture
LINE = (
    "amplitude", "amplitude_error", "critical", "critical_error", "reduced_chi_square", "p_value",
)  # fmt: skip
NAMES = {"excess": "narrow_excess"} | {
    name: f"narrow_{name}" for name in ("chi", "width", "width_error", "fitted")
}


def compute(sweeps):
    """Widths over chi for both densities, and in the smaller box."""
    parts = [
        widths(sweeps[runs.sweep], runs.slope).expand_dims(density=[rho])
        for rho, runs in SEGREGATION.items()
    ]
    data = xr.concat(parts, "density", join="outer", fill_value={"fitted": False})
    return data.merge(widths(sweeps["narrow_5"], SEGREGATION[5].slope).rename(NAMES))


def widths(runs, slope):
    """Width over chi by the published slope, and which runs have settled."""
    found = sweep_chi(runs, "excess")
    data = found[["width", "width_error"]]
    data["chi"] = PUBLISHED[slope].value * found.excess.astype(float)
    data.chi.attrs = {"units": "1", "long_name": "by Eq. 24 from Delta a"}
    known = data.width_error > 0  # not where a run is too short for an error
    data["fitted"] = (found.settled == 1) & (data.chi > CRITICAL.value) & known
    return data


def boxes(data):
    """Density, runs and look of each box by the end of the names of its published numbers."""
    found = {
        f"rho_{rho}": (rho, data.sel(density=rho), runs.look) for rho, runs in SEGREGATION.items()
    }
    if "narrow_width" in data:
        names = {new: old for old, new in NAMES.items()}
        found["narrow"] = (5, data[list(names)].rename(names), NARROW)
    return found


def close(at):
    """Which runs of a box are fitted."""
    return at.isel(excess=(at.fitted & (at.chi < NEAR)).values)


def line(data, rho, nu):
    """Fit xi^(-1 / nu) = s (chi - critical), and A of xi = A / sqrt(rho (chi - critical)).

    Returns ``amplitude``, ``critical``, each with ``_error``, ``reduced_chi_square``, and
    ``p_value``, the probability of points that scatter more about a straight line; NaN with fewer
    than three points.
    """
    data = data.isel(excess=(data.width_error > 0).values)
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
    """The two numbers of Eq. 35 in each box, and the critical chi for nu = 0.63."""
    found = {
        f"width_{quantity}_narrow": Measured(np.nan, np.nan)
        for quantity in ("amplitude", "critical")
    }
    for box, (rho, at, _) in boxes(data).items():
        for name, kind, quantity in (
            ("width_amplitude", "classical", "amplitude"),
            ("width_critical", "classical", "critical"),
            ("width_critical_ising", "ising", "critical"),
        ):
            if box != "narrow" or kind == "classical":
                found[f"{name}_{box}"] = of_line(at, rho, EXPONENTS[kind], quantity)
    return found


def of_line(at, rho, nu, quantity):
    """A number of the line through the runs close to the critical point, and what all give."""
    used = close(at)
    if used.sizes["excess"] < 3:
        return Measured(
            np.nan, np.nan, "", f"fewer than three runs in equilibrium with chi below {NEAR:g}"
        )
    near, whole = line(used, rho, nu), line(at.isel(excess=at.fitted.values), rho, nu)
    chi = used.chi.values
    note = (
        f"{len(chi)} runs, chi from {chi.min():.1f} to {chi.max():.1f}, reduced chi-square "
        f"{near['reduced_chi_square']:.1f}"
    )
    if at.fitted.sum() > len(chi):
        note += (
            f"; all {int(at.fitted.sum())}, up to {float(at.chi.where(at.fitted).max()):.1f}, give "
            f"{with_error(whole[quantity], whole[f'{quantity}_error'])}, p = {whole['p_value']:.1g}"
        )
    why = misfit(near["p_value"], "a straight line", "its slope and its zero depend")
    return Measured(near[quantity], near[f"{quantity}_error"], note, why)


def describe(data):
    """What is seen."""
    each = " and ".join(
        f"{line(close(at), rho, EXPONENTS['classical'])['amplitude']:.2f} at density {rho}"
        for name, (rho, at, _) in boxes(data).items()
        if name != "narrow"
    )
    return (
        "One over rho xi^2 rises in straight lines with chi, from zero near chi 2.4. Their slope "
        f"gives an amplitude of {each}; the dashed published line has {AMPLITUDE.value:g}."
    )


def draw(data):
    """1 / (rho xi^2) over chi: one straight line for both densities by Eq. 35."""
    figure, axes = panels(1)
    for rho, at, (name, color, marker) in boxes(data).values():
        at = at.dropna("excess", subset=["width"])
        use = (at.fitted & (at.chi < NEAR)).values.astype(bool)
        for fitted in (True, False):
            part = at.isel(excess=use == fitted)
            y = 1 / (rho * part.width**2)
            points(axes, part.chi, y, 2 * y * part.width_error / part.width, None, color, marker,
                   fitted)  # fmt: skip
        found, x = line(close(at), rho, EXPONENTS["classical"]), np.linspace(*REACH, 2)
        amplitude, critical = found["amplitude"], found["critical"]
        text = name
        if np.isfinite(amplitude):
            text += f": $A$ = {amplitude:.2f} ± {COVERAGE * found['amplitude_error']:.2f}"
        axes.plot(x, (x - critical) / amplitude**2, color=color, linewidth=0.8, marker=marker,
                  markevery=[], label=text)  # fmt: skip
    eq_35 = (x - CRITICAL.value) / AMPLITUDE.value**2
    published_line(axes, x, eq_35, f"published, Eq. 35: $A$ = {AMPLITUDE.value:g}")
    axes.axhline(0, color=BLACK, linewidth=0.5)
    axes.axvline(NEAR, ymax=0.6, color=BLACK, linewidth=0.5, linestyle=":")
    axes.set(xlim=REACH, ylim=(-0.02, 0.42), xlabel=r"$\chi$ from $\Delta a$ by Eq. 24",
             ylabel=r"$1 / (\rho \xi^2)$ / $r_c$")  # fmt: skip
    axes.legend(loc="upper left")
    return figure
