"""What Figures 9 to 13 of Groot and Warren 1997 share: tensions as their laws take them."""

import numpy as np
import xarray as xr
from matplotlib.container import ErrorbarContainer

from dpd.analysis.statistics import misfit_share
from dpd.analysis.verdicts import Measured
from dpd.report.style import BLACK, BLUE, GREEN, MARKERS, ORANGE, PURPLE, RED, SKY
from dpd.report.text import with_error
from paper_figures.groot_warren_1997.shared import misfit
from paper_figures.groot_warren_1997.tension_laws import tension_law
from paper_figures.groot_warren_1997.tension_sweeps import sweep_tension

VAN_DER_WAALS = {"critical": 2.0, "mu": 1.5}  # mean field: Flory-Huggins, and its exponent
CURVE = ("prefactor", "alpha", "critical", "mu")  # numbers of a law
SCALED = r"$\sigma / (\rho k_BT r_c)$"
FEW = "fewer than four settled runs"
NOT_SETTLED = (
    "Open points are not fitted: the slabs have mixed, the composition drifted by more than 2 "
    "standard errors between the halves of the run, or the run is too short for an error"
)
# chi N from which the laws of chains are fitted: a little above the critical point.
LEAST_SEGREGATED = 2.2
OUTSIDE = f"or chi N is below {LEAST_SEGREGATED:g}"
TRIMERS = 3  # beads of the chains that laws are fitted to as well without any shorter ones
KEPT = ("chi", "beads", "segregation", "scaled", "scaled_error", "fitted", "drift", "bulk",
        "bulk_error")  # fmt: skip
COLORS = (BLUE, ORANGE, GREEN, RED, PURPLE, SKY, BLACK)
GROUPS = tuple(zip(COLORS, MARKERS))


def scaled_tensions(sweep, slope):
    """Tensions of a sweep over rho kT r_c, with the chi that a published slope gives.

    ``sweep``: collected slabs. ``slope``: chi kT / Delta a. Result: what
    `tension_sweeps.sweep_tension` gives, and ``chi``, ``segregation`` (chi N), ``scaled``,
    ``scaled_error``, and ``fitted``, which runs have settled.
    """
    data, one = with_slope(sweep_tension(sweep), slope), {"units": "1"}
    put = {}  # of arrays and at once: to align variables takes longer than all the rest
    for name, each in {"scaled": data.tension, "scaled_error": data.tension_error}.items():
        about = one | {"long_name": f"{each.long_name}, over rho kT r_c"}
        put[name] = each.dims, each.values / data.density.values, about
    fitted = (data.settled.values == 1) & (put["scaled_error"][1] > 0)
    about = one | {"long_name": "whether laws are fitted to this run"}
    return data.assign(put | {"fitted": (data.settled.dims, fitted, about)})


def with_slope(data, slope):
    """Tensions with ``chi`` and ``segregation`` by a slope chi kT / Delta a."""
    chi, along = slope * data.excess_repulsion.values, data.excess_repulsion.dims
    return data.assign(
        chi=(along, chi, {"units": "1", "long_name": "chi of Delta a"}),
        segregation=(along, chi * data.beads.values, {"units": "1", "long_name": "chi N"}),
    )


def tensions_of_chains(sweep, slope):
    """The same of chains, of which those far enough above the critical point are fitted.

    ``sweep``, ``slope``: as for `scaled_tensions`.
    """
    data = scaled_tensions(sweep, slope)
    above = data.segregation >= LEAST_SEGREGATED
    data["fitted"] = (data.fitted & above).assign_attrs(data.fitted.attrs)
    return data


def runs_of_chains(sweeps, slope):
    """The same of several sweeps, one run after another, with the sweep that each is of.

    ``slope``: as for `scaled_tensions`. Result: the names of `KEPT` over ``run``.
    """
    parts = []
    for name, sweep in sweeps.items():
        of_sweep = tensions_of_chains(sweep, slope)[list(KEPT)]
        flat = of_sweep.stack(run=list(of_sweep.scaled.dims)).reset_index("run", drop=True)
        parts.append(flat.assign(sweep=("run", [name] * flat.sizes["run"])))
    return xr.concat(parts, "run", combine_attrs="drop_conflicts")


def without_dimers(data):
    """The same runs, of which those of chains of two beads are not fitted."""
    return data.assign(fitted=data.fitted & (data.beads >= TRIMERS))


def law_of(parts, **held):
    """Fit the law of tensions to all settled runs of some datasets.

    ``parts``: from `scaled_tensions`. ``**held``: numbers of the law that are not fitted.
    """
    columns = [
        np.concatenate([part[name].values[part.fitted.values] for part in parts])
        for name in ("chi", "beads", "scaled", "scaled_error")
    ]
    return tension_law(*columns, **held)


def put_law(data, name, law):
    """Put the numbers of a law or a collapse into a dataset, as NAME_mu, NAME_mu_error, ..."""
    numbers = {part: getattr(law, part) for part in ("reduced_chi_square", "p_value", "points")}
    for part in [part for part in CURVE if part in law._fields]:
        numbers[part], numbers[f"{part}_error"] = getattr(law, part)
    put = {f"{name}_{part}": ((), value, {"units": "1"}) for part, value in numbers.items()}
    data.update(put)  # at once: each alone would be aligned with all others


def curve(data, name, chi, length=1.0):
    """The law that `put_law` has put into a dataset, as scaled tensions at some chi."""
    k, alpha, critical, mu = (float(data[f"{name}_{part}"]) for part in CURVE)
    return k * chi**alpha * np.maximum(1 - critical / (chi * length), 0) ** mu


def measured_part(data, name, part, beside=""):
    """One number of a law for the table of verdicts.

    ``beside``: what the note says besides how well the points lie on the law. Result: not to be
    judged where the points do not follow the law.
    """
    few = int(data[f"{name}_points"]) <= 3
    note, error = fit_in_words(data, name), float(data[f"{name}_{part}_error"])
    quality, p = (float(data[f"{name}_{each}"]) for each in ("reduced_chi_square", "p_value"))
    return Measured(
        float(data[f"{name}_{part}"]), error, f"{note}; {beside}" if beside else note,
        FEW if few else off_the_law(data, name), systematic=error * misfit_share(quality, p),
    )  # fmt: skip


def off_the_law(data, name):
    """Why the numbers of a law in a dataset are not judged; empty if the points follow it."""
    return misfit(float(data[f"{name}_p_value"]), "one curve of this law", "its numbers depend")


def fit_in_words(data, name):
    """How many runs a law in a dataset was fitted to, and how well they lie on it."""
    points, quality = int(data[f"{name}_points"]), float(data[f"{name}_reduced_chi_square"])
    return f"{points} settled runs, reduced chi-square {quality:.2f}"


def longer_in_words(data, name, part):
    """The same number of a law in a dataset from chains of three beads and more, if any."""
    value, error = (float(data[f"longer_{name}_{part}{end}"]) for end in ("", "_error"))
    if not np.isfinite(value):
        return "too few runs without N = 2"
    quality = float(data[f"longer_{name}_reduced_chi_square"])
    return f"without N = 2: {with_error(value, error)}, reduced chi-square {quality:.2f}"


def draw_dimers(axes, x, y):
    """Dots upon the points of chains of two beads, if there are any."""
    if not len(x):
        return
    axes.plot(x, y, ".", color=BLACK, markersize=2, label="$N$ = 2", zorder=4)


def two_legends(axes, lines_at, points_at):
    """One legend of lines, and another of points, each at its own place."""
    entries = list(zip(*axes.get_legend_handles_labels()))
    bars = [entry for entry in entries if isinstance(entry[0], ErrorbarContainer)]
    rest = [entry for entry in entries if entry not in bars]
    axes.add_artist(axes.legend(*zip(*rest), loc=lines_at))
    if bars:
        axes.legend(*zip(*bars), loc=points_at)
