"""Run time against error, one panel per quantity and friction: shared by two figures."""

import numpy as np
import pandas as pd
from matplotlib.ticker import NullFormatter

from dpd.analysis.accuracy import (
    LABELS,
    TOLERANCES,
    bound,
    cheapest,
    deviations,
    front,
)
from dpd.analysis.collect import load
from dpd.analysis.statistics import COVERAGE
from dpd.errors import UserError
from dpd.report.style import BLACK, BLUE, GREEN, ORANGE, PURPLE, RED, SKY, panels
from dpd.report.text import with_error

STYLES = {
    "euler": ("Euler", RED, "D"),
    "gw-vv-0.5": (r"gw-vv, $\lambda$ 0.5", BLUE, "o"),
    "gw-vv-0.65": (r"gw-vv, $\lambda$ 0.65", SKY, "s"),
    "dpd-vv": ("dpd-vv", BLACK, "v"),
    "shardlow": ("Shardlow", ORANGE, "^"),
    "lowe-andersen": ("Lowe-Andersen", PURPLE, "P"),
    "aboba": ("ABOBA", GREEN, "X"),
}
HEAD = """\
# What `integrator: {scheme: auto}` tries first: the cheapest scheme and step, on one core, whose
# errors in pressure and in kT are within the tolerance, each with 97.5 % confidence. (Pressure may
# be right by two errors that cancel. Lowe-Andersen, whose friction is another, is left out.)
# Measured by the benchmark:
# snakemake --cores 2 benchmark; python -m dpd schemes quick -o config/schemes.yaml
# stiffness: a rho and C of the systems that it was measured in."""
STIFFNESS = {"fluid": "{repulsion: 75}", "melt": "{repulsion: 100, bond: 200}"}
JUDGED = ("pressure", "kT")
LEAST = 1e-4  # relative error at which the panels end


def shows(beads):
    """What such a figure shows, for its caption.

    Parameters
    ----------
    beads : str
        How many beads the run time is for.
    """
    return (
        "Each scheme over its time step, at each friction. Down: less error; left: less run "
        f"time, per tau of {beads} beads on one core. Temperatures are held against kT = 1, other "
        "quantities against their limit for dt to 0 (written in), taken from Shardlow's scheme and "
        "ABOBA. Lowe-Andersen has another dynamics by design, so its diffusion has another limit. "
        "Hollow: an error that noise hides, drawn where it is below with 97.5 % confidence. Grey: "
        "the front, on which no scheme is both faster and surely more accurate. Crosses: runs too "
        "short for an error, found as drawn. Runs that blew up, "
        "or with kT above 2, are left out."
    )


def against_time(runs, costs, workload):
    """Relative errors of a sweep's runs, with the run time per tau of the workload.

    Parameters
    ----------
    runs : xarray.Dataset
        Collected; see `dpd.analysis.accuracy.deviations`.
    costs : xarray.Dataset
        The measurement ``schemes``: ``cost`` in s per bead and step.
    workload : str
        One of its workloads.

    Returns
    -------
    xarray.Dataset
        `deviations`, and ``seconds`` per tau over ``scheme`` and ``dt``.
    """
    data = deviations(runs)
    each = costs.cost.sel(workload=workload).median("turn").sel(scheme=data.scheme)
    beads = float(costs.beads.sel(workload=workload))
    data["seconds"] = (each * beads / data.dt).transpose("scheme", "dt")
    text = f"run time per tau of {beads:.0f} beads, one core"
    data.seconds.attrs = {"units": "s / tau", "long_name": text}
    return data.drop_vars("workload", errors="ignore")


def describe(data):
    """What such a figure shows, for those who cannot see it."""
    return (
        "Panels for each quantity and friction: the error falls as runs take more time, for every "
        "scheme; a grey line marks those that no other beats in both."
    )


def draw(data):
    """Panels: quantities downwards, frictions across."""
    names = [name for name in LABELS if name in data]
    figure, axes = panels(data.sizes["gamma"], len(names), height=2.2, squeeze=False)
    for row, name in zip(axes, names):
        for axis, gamma in zip(row, data.gamma.values):
            _panel(axis, data.sel(gamma=gamma), name)
            axis.set_title(rf"{LABELS[name]}, $\gamma$ = {gamma:g}")
    for axis in axes[-1]:
        axis.set_xlabel(r"run time per $\tau$ / s")
    for row in axes:
        row[0].set_ylabel("relative error")
    handles, labels = axes[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=4)
    return figure


def _panel(axis, data, name):
    """|error| where it is clear of noise; else the bound on it, as a hollow mark."""
    error, sigma = np.abs(data[name]), data[f"{name}_error"]
    limit = bound(data, name)
    for scheme in data.scheme.values:
        label, color, marker = STYLES[str(scheme)]
        at = dict(scheme=scheme)
        x, y, s = (part.sel(at).values for part in (data.seconds, error, sigma))
        clear = y > COVERAGE * s
        axis.plot(x, np.where(clear, y, limit.sel(at)), color=color, linewidth=0.5)
        axis.errorbar(x[clear], y[clear], COVERAGE * s[clear], color=color, marker=marker,
                      linestyle="none", elinewidth=0.6, label=label)  # fmt: skip
        hidden = ~clear & np.isfinite(y)
        axis.plot(x[hidden], limit.sel(at).values[hidden], color=color, marker=marker,
                  markerfacecolor="white", linestyle="none")  # fmt: skip
        unknown = np.isfinite(y) & ~np.isfinite(s)
        axis.plot(x[unknown], y[unknown], "x", color=color)
    x, y = data.seconds.values.ravel(), limit.transpose("scheme", "dt").values.ravel()
    best = front(x, y)
    axis.step(x[best], y[best], where="post", color="0.75", linewidth=3, zorder=0)
    axis.set(xscale="log", yscale="log", ylim=(LEAST, 2))
    axis.xaxis.set_minor_formatter(NullFormatter())
    if not name.startswith("kT") and f"{name}_limit" in data:
        value, sigma = float(data[f"{name}_limit"]), float(data[f"{name}_limit_error"])
        text = f"limit {with_error(value, sigma)}"
        axis.text(0.03, 0.04, text, transform=axis.transAxes, fontsize=7)


def choices(data, names=JUDGED):
    """For each friction and tolerance the cheapest scheme, as rows (dict).

    Parameters
    ----------
    data : xarray.Dataset
        From `against_time`.
    names : sequence of str
        Quantities whose errors must all be within the tolerance.
    """
    rows = []
    for gamma in data.gamma.values:
        at = data.sel(gamma=gamma)
        for tolerance in TOLERANCES:
            row = {"gamma": float(gamma), "tolerance": tolerance, "scheme": None}
            found = cheapest(at, data.seconds, names, tolerance)
            if found is not None:
                row["scheme"], row["dt"], row["seconds"] = found
                chosen = at.sel(scheme=row["scheme"], dt=row["dt"])
                for name in JUDGED:
                    error, sigma = float(chosen[name]), float(chosen[f"{name}_error"])
                    row[name] = with_error(100 * error, 100 * sigma)
            rows.append(row)
    return rows


def table(data):
    """The cheapest scheme and step for each tolerance: in pressure, and in pressure and kT."""
    rows = []
    for names, text in ((("pressure",), "pressure"), (JUDGED, "pressure and kT")):
        for row in choices(data, names):
            start = (f"{100 * row['tolerance']:g} % in {text}", f"{row['gamma']:g}")
            if row["scheme"] is None:
                rows.append((*start, "none", "–", "–", "–", "–"))
                continue
            scheme = STYLES[row["scheme"]][0].replace("$", "").replace("\\", "")
            cost = f"{1000 * row['seconds']:.3g}"
            rows.append((*start, scheme, f"{row['dt']:g}", cost, row["pressure"], row["kT"]))
    head = ["within", "gamma", "scheme", "dt / tau", "ms per tau", "pressure / %", "kT / %"]
    return pd.DataFrame(rows, columns=head)


def recommendations(figures):
    """config/schemes.yaml: of each system, friction and tolerance the cheapest scheme.

    Parameters
    ----------
    figures : path
        Folder of the figures ``fluid_accuracy`` and ``melt_accuracy``.

    Returns
    -------
    str
        YAML; see `dpd.scene.automatic`.

    Raises
    ------
    UserError
        If they were not made.
    """
    parts = [HEAD]
    for system, stiffness in STIFFNESS.items():
        path = figures / f"{system}_accuracy.nc"
        if not path.is_file():
            raise UserError(f"{path}: there is no such file; run snakemake --cores 2 benchmark")
        parts.append(f"{system}:\n  stiffness: {stiffness}\n  choices:")
        data = load(path)
        for row in choices(data.drop_sel(scheme="lowe-andersen", errors="ignore")):
            if row["scheme"] is None:
                continue
            scheme, _, prediction = row["scheme"].partition("-0.")
            chosen = f"scheme: {scheme}, lambda: 0.{prediction or 5}, dt: {row['dt']:g}"
            parts.append(
                f"    - {{gamma: {row['gamma']:g}, tolerance: {row['tolerance']:g}, {chosen}}}"
                f"  # p {row['pressure']} %, kT {row['kT']} %, "
                f"{1000 * row['seconds']:.3g} ms per tau"
            )
    return "\n".join(parts) + "\n"
