"""A million steps: momentum, trends of temperature and energy; energy without a thermostat."""

import numpy as np
import pandas as pd
import xarray as xr
from scipy.special import stdtrit

from dpd.analysis.collect import first_scene
from dpd.analysis.statistics import COVERAGE
from dpd.report.style import BLACK, BLUE, GREEN, ORANGE, RED, panels, points
from dpd.report.text import with_error
from paper_figures.benchmark.drift import SURE, power_law

SHOWS_TEMPERATURE = True

TITLE = "Long runs: momentum (a), trends (b), and energy without a thermostat (c)."
PAPER_SHOWS = (
    "(a) Largest component of the total momentum met at any sample, per bead; bars: what one "
    "rounding error a bead and step adds up to at random, eps (steps / beads)^(1/2); dashed: eps, "
    "2.2e-16. (b) Linear trend of series over the whole run, over its standard error; shaded: "
    "two standard errors. kT is <v^2> over the degrees of freedom that are left when the centre of "
    "mass rests. (c) No friction and no noise, which makes gw-vv velocity Verlet: the "
    "drift of the total energy per bead and tau without its sign, and its standard deviation about "
    "that drift, with power laws fitted (dashed); the error of the drift is the larger of that of "
    "each run and that from the scatter of replicas; open: a drift of less than two standard "
    "errors, which is not fitted."
)
ERRORS = (
    "Bars: 95 % intervals. Errors of trends take the autocorrelation of what is left from the "
    "line into account; fits are widened where points scatter more than their errors allow."
)
SERIES = {
    "kT": ("kT", BLUE, "o"),
    "total_energy": ("energy per bead", ORANGE, "s"),
    "pressure": ("pressure", GREEN, "^"),
}
LAWS = {"drift": (r"drift per $\tau$", RED, "o"), "spread": ("fluctuation", BLUE, "s")}


def compute(sweeps):
    """Trends over errors and momentum of each long run; drift and spread of energy over dt."""
    data = _long(sweeps["long_runs"])
    return data.merge(_without_thermostat(sweeps["no_thermostat"].sortby("dt")))


def _long(runs):
    """The long runs, the first replica of each."""
    runs = runs.isel(replica=0)
    data = xr.Dataset(coords={"run": runs.run.values})
    scenes = [first_scene(runs.isel(run=place)) for place in range(runs.sizes["run"])]
    steps = [scene.dt for scene in scenes]
    data["step"] = ("run", steps, {"units": "tau"})
    data["scheme"] = ("run", [scene.data["integrator"]["scheme"] for scene in scenes])
    length = [scene.steps.sample * dt for scene, dt in zip(scenes, steps)]
    data["length"] = ("run", length, {"units": "tau"})
    for name in ("steps", "beads", "momentum_per_bead", "lost_step"):
        data[name] = runs[name]
    data["steps"].attrs["units"] = "1"
    for name in SERIES:
        for part in ("", "_error", "_trend", "_trend_error", "_spread"):
            values = runs[name + part]
            if name == "total_energy":
                values = values / runs.beads
            data[name + part] = values.assign_attrs(runs[name + part].attrs)
        ratio = runs[f"{name}_trend"] / runs[f"{name}_trend_error"]
        data[f"{name}_ratio"] = ratio.assign_attrs(units="1", long_name="trend over its error")
    return data.drop_vars("replica", errors="ignore")


def _without_thermostat(runs):
    """Drift and spread of the total energy per bead, means over replicas, and their laws."""
    scene, beads = first_scene(runs), runs.beads
    count = runs.sizes["replica"]
    drift = (runs.total_energy_trend / beads).mean("replica")
    within = np.sqrt(((runs.total_energy_trend_error / beads) ** 2).sum("replica")) / count
    drift_error = np.fmax(within, _between(runs.total_energy_trend / beads))
    spread = (runs.total_energy_spread / beads).mean("replica")
    # A standard deviation over T is known to at least sqrt(correlation time / T).
    length = scene.steps.sample * scene.dt
    share = np.sqrt(runs.total_energy_correlation_time.mean("replica") / (length * count))
    data = xr.Dataset({
        "drift": drift.assign_attrs(units="kT / tau"),
        "drift_error": drift_error.assign_attrs(units="kT / tau"),
        "spread": spread.assign_attrs(units="kT"),
        "spread_error": (spread * share).assign_attrs(units="kT"),
        "nve_lost": (runs.lost_step >= 0).any("replica").astype(float).assign_attrs(units="1"),
        "nve_momentum": runs.momentum_per_bead.max("replica", keep_attrs=True),
        "nve_length": ((), length, {"units": "tau"}),
    })  # fmt: skip
    dt = data.dt.values
    for name in LAWS:
        value, error = np.abs(data[name].values), data[f"{name}_error"].values
        seen = _significant(data, name)
        law = power_law(dt[seen], value[seen], (error / value)[seen])
        for part, number in law._asdict().items():
            data[f"{name}_law_{part}"] = ((), float(number), {"units": "1"})
    return data


def _between(values):
    """Error of a mean over replicas from their scatter; NaN for one replica.

    Energy without a thermostat wanders, so that replicas differ by more than each of them can
    tell. A scatter of few is uncertain itself: Student's interval stands for the normal one.
    """
    count = values.sizes["replica"]
    if count < 2:
        return xr.full_like(values.isel(replica=0, drop=True), np.nan)
    student = stdtrit(count - 1, 0.975) / COVERAGE
    return student * values.std("replica", ddof=1) / np.sqrt(count)


def measured(data):
    """None: no paper gives such numbers."""
    return {}


def _labels(data):
    """Scheme and step of each run."""
    return [f"{scheme}, {dt:g}" for scheme, dt in zip(data.scheme.values, data.step.values)]


def table(data):
    """One row a run: momentum, kT, changes over its length, fluctuation of energy."""
    rows = []
    for place, label in enumerate(_labels(data)):
        at = data.isel(run=place)
        rows.append((
            label, f"{float(at.length):g}", f"{float(at.momentum_per_bead):.1e}",
            with_error(100 * (float(at.kT) - 1), 100 * float(at.kT_error)),
            *(_trend_text(at, name) for name in SERIES), f"{float(at.total_energy_spread):.2g}",
        ))  # fmt: skip
    for dt in data.dt.values:
        at, length = data.sel(dt=dt), float(data.nve_length)
        change = with_error(length * float(at.drift), length * float(at.drift_error))
        spread = with_error(float(at.spread), float(at.spread_error))
        momentum = f"{float(at.nve_momentum):.1e}"
        rows.append((f"no thermostat, {dt:g}", f"{length:g}", momentum, "", "", change, "", spread))
    changes = [f"change of {label}" for label, _, _ in SERIES.values()]
    return pd.DataFrame(rows, columns=[
        "scheme, dt / tau", "length / tau", "momentum per bead", "kT - 1 / %", *changes,
        "fluctuation of energy per bead",
    ])  # fmt: skip


def _trend_text(at, name):
    length = float(at.length)
    return with_error(*(length * float(at[f"{name}_trend{part}"]) for part in ("", "_error")))


def warnings(data):
    """What was seen, from the numbers themselves."""
    ratio = np.array([data[f"{name}_ratio"].values for name in SERIES])
    seen = np.isfinite(ratio)
    beyond = int((np.abs(ratio[seen]) > SURE).sum())
    found = [
        f"Of {seen.sum()} trends {beyond} exceed two standard errors; chance alone gives "
        f"{0.0455 * seen.sum():.1f}. The largest is {np.abs(ratio[seen]).max():.1f} standard "
        "errors."
    ]
    if (data.lost_step >= 0).any():
        lost = [label for label, at in zip(_labels(data), data.lost_step.values) if at >= 0]
        found.append(f"Blew up: {'; '.join(lost)}.")
    known = np.isfinite(data.drift_error.values)
    quiet = data.dt.values[known & ~_significant(data, "drift")]
    if len(quiet):
        text = ", ".join(f"{dt:g}" for dt in quiet)
        found.append(
            f"Without a thermostat no drift is seen in {float(data.nve_length):g} tau at dt {text}."
        )
    for name in LAWS:
        if not data[f"{name}_law_points"] >= 3:
            found.append(f"Too few steps show a {name} to fit its order.")
        elif float(data[f"{name}_law_chance"]) < 0.05:
            chance = float(data[f"{name}_law_chance"])
            found.append(f"The {name} is no single power of dt (p = {chance:.1g}).")
    return found


def _significant(data, name):
    return np.abs(data[name].values) > SURE * data[f"{name}_error"].values


def describe(data):
    """What is seen, in words."""
    return (
        "(a) The total momentum per bead stays at rounding errors. (b) Trends of pressure and kT "
        "over their standard errors. (c) Drift of the energy without a thermostat over the step."
    )


def draw(data):
    """Momentum and trends by scheme; energy over dt."""
    figure, axes = panels(3)
    _draw_momentum(axes[0], data)
    _draw_trends(axes[1], data)
    _draw_energy(axes[2], data)
    return figure


def _name_rows(panel, data):
    labels = _labels(data)
    panel.set_yticks(range(len(labels)), labels)
    panel.set_ylim(len(labels) + 0.1, -0.5)  # room for the legend
    panel.tick_params(axis="y", which="both", length=0)


def _draw_momentum(panel, data):
    """Momentum per bead against the unit roundoff."""
    values = data.momentum_per_bead.values
    eps, rows = np.finfo(float).eps, np.arange(len(values))
    walk = eps * np.sqrt(data.steps.values / data.beads.values)
    panel.plot(walk, rows, "|", color=BLACK, markersize=12, label="rounding at random")
    panel.plot(values, rows, "o", color=BLUE, label="found")
    panel.axvline(eps, color=BLACK, linestyle="--", linewidth=0.8)
    largest, least = np.nanmax(values), np.nanmin(values[values > 0])
    panel.legend(loc="lower center", ncols=2)
    panel.set(xscale="log", xlim=(0.3 * min(eps, least), 30 * max(largest, walk.max())),
              xlabel=r"momentum per bead / ($m$ $r_c$ $\tau^{-1}$)")  # fmt: skip
    _name_rows(panel, data)


def _draw_trends(panel, data):
    """Trends over their errors."""
    rows = np.arange(data.sizes["run"])
    for shift, (name, (label, color, marker)) in zip((-0.2, 0, 0.2), SERIES.items()):
        panel.plot(data[f"{name}_ratio"], rows + shift, marker, color=color, label=label)
    panel.axvspan(-SURE, SURE, color=BLACK, alpha=0.1, linewidth=0)
    panel.axvline(0, color="0.6", linewidth=0.6, zorder=0)
    reach = max(4.0, 1.2 * float(np.nanmax([np.abs(data[f"{n}_ratio"]).max() for n in SERIES])))
    panel.set(xlim=(-reach, reach), xlabel="trend / its standard error")
    panel.legend(loc="lower center", bbox_to_anchor=(0.5, -0.02), ncols=3, handletextpad=0.1)
    _name_rows(panel, data)


def _draw_energy(panel, data):
    """Drift and fluctuation over dt with their laws."""
    dt = data.dt.values
    for name, (label, color, marker) in LAWS.items():
        value, error = np.abs(data[name].values), data[f"{name}_error"].values
        seen = _significant(data, name)
        text = label
        exponent, spread = (float(data[f"{name}_law_{part}"]) for part in ("exponent", "error"))
        if np.isfinite(exponent):
            text += rf", $\propto dt^{{{exponent:.2f} \pm {spread:.2f}}}$"
            ends = np.array([float(data[f"{name}_law_{end}"]) for end in ("low", "high")])
            line = float(data[f"{name}_law_factor"]) * ends**exponent
            panel.plot(ends, line, "--", color=color, linewidth=0.8, zorder=0)
        points(panel, dt[seen], value[seen], error[seen], text, color, marker)
        if (~seen).any():
            panel.errorbar(
                dt[~seen], value[~seen], COVERAGE * error[~seen], color=color, marker=marker,
                linestyle="none", markerfacecolor="white", elinewidth=0.7, capsize=1.5,
            )  # fmt: skip
    panel.set(xscale="log", yscale="log", xlabel=r"time step dt / $\tau$",
              ylabel=r"energy per bead / $k_BT$")  # fmt: skip
    panel.legend(loc="upper left")
