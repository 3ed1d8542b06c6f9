"""What the core force F_max and the spring constant C do."""

from itertools import cycle

import numpy as np
import xarray as xr

from dpd.analysis.collect import first_scene
from dpd.analysis.statistics import COVERAGE, NONE_SEEN, interval, over_replicas
from dpd.analysis.verdicts import AGREE, Measured, shown_by
from dpd.report.style import BLACK, BLUE, GREEN, ORANGE, PURPLE, RED, panels
from paper_figures.liu_2008.shared import PAPER_STEP, SETS, bonds_and_crossings, closest_contact

WARM = shown_by(__file__)["heat_1"].high  # of kT: how far off a proper time step may be

TITLE = "Core force F_max and spring constant C (r_s 0.15, melts of N = 20)."
PAPER_SHOWS = (
    "Not a figure of the paper, which says that it chose F_max two to four times a and C large, "
    "that bonds rest at 2 r_0, and that mean-square bond deviation, l_max and closest contact "
    "all rise with F_max. (a) Closest contact 2 r_0 of monomers: the lower edge of the first "
    "bin (0.01 r_c wide) of g(r) that is not empty in one configuration of 20 000 beads, median "
    "over 50 configurations. (b) to (e): melts whose bonds rest at that 2 r_0, "
    "all from one melt of set (1). (b) Variance of bond lengths times C. (c) Longest bond of a "
    "block of the run, mean over blocks; dashed: 4 r_0. (d) Share of bonds longer than 4 r_0. "
    "(e) Crossings. (f) The largest dt of the sweep up to which no run blew up and kT stayed "
    f"within {100 * WARM:g} % of 1 (bonds at rest at 0.25); no point where there is none. "
    "Times in DPD units tau_0."
)
ERRORS = (
    "(a): 95 % intervals of the median, interpolated within a bin; (b), (c): 95 % intervals "
    "from blocks of the run; (d): the same; (e): 95 % intervals of the "
    "mean of a Poisson distribution, given the count. Hollow in (d) and (e): none seen, and the "
    "upper bound at 95 %. Points of different C stand a little side by side."
)
COLORS = (BLUE, GREEN, RED, ORANGE, PURPLE, BLACK)
CHOSEN = 50  # F_max from which the text's rises are judged: it took two to four times a = 25
EVEN = 0.01  # of kT, that runs to be compared must keep
SET_FORCE, SET_STIFFNESS = 100, 300  # F_max and C of set (1)
BESIDE = 1.06  # factor between points of different C at one F_max, so that all are seen
USED = ("scene", "bond_", "beads", "kT", "crossing")  # what names begin with; all cost at a point
UNITS = {
    "longest": "r_c", "longest_error": "r_c", "variance": "r_c^2", "variance_error": "r_c^2",
    "share": "1", "share_error": "1", "share_bound": "1", "begun": "1", "exposure": "tau",
    "melt_kT": "kT", "melt_kT_error": "kT", "rest": "r_c",
}  # fmt: skip


def compute(sweeps):
    """Contacts, bonds, crossings and stable steps over F_max and C."""
    names = ("contacts", "rigidity", "stability", "sets", "share")
    contacts, runs, steps, sets, share = (sweeps[name] for name in names)
    runs = runs[[name for name in runs.data_vars if name.startswith(USED)]]
    places = list(np.ndindex(runs.sizes["force"], runs.sizes["stiffness"]))
    rows = [bonds_and_crossings(runs.isel(force=i, stiffness=j)) for i, j in places]
    data = xr.Dataset(coords={name: runs[name] for name in ("force", "stiffness")})
    for name, unit in UNITS.items():
        table = np.array([row[name] for row in rows]).reshape(runs.sizes["force"], -1)
        data[name] = (("force", "stiffness"), table, {"units": unit})
    places = [contacts[["rdf", "beads"]].sel(force=force) for force in contacts.force.values]
    cores = [closest_contact(at) for at in places]
    data = data.assign_coords(core_force=contacts.force.values)
    data["contact"] = ("core_force", [core.value for core in cores], {"units": "r_c"})
    data["contact_error"] = ("core_force", [core.error for core in cores], {"units": "r_c"})
    tried = _stable(steps).rename(force="stable_force", stiffness="stable_stiffness")
    data["stable_dt"] = tried.assign_attrs(units="tau")
    kT, error = over_replicas(steps.kT.values, steps.kT_error.values, -1)
    names = tuple({"force": "stable_force", "stiffness": "stable_stiffness"}.get(d, d)
                  for d in steps.kT.dims[:-1])  # fmt: skip
    data = data.assign_coords(dt=steps.dt.values)
    data["kT"], data["kT_error"] = (names, kT, {"units": "kT"}), (names, error, {"units": "kT"})
    data = data.merge(_heats(sets))
    return data.assign_attrs(undecided=cores[0].undecided, **_by_rest(share))


def _by_rest(share):
    """Slopes of variance and longest bond over the rest length, of melts of set (1); NaN of one."""
    found = {
        "variance_by_rest": share.bond_mean_square - share.bond_mean**2,
        "longest_by_rest": share.bond_longest,
    }
    rest, others = share.rest_length.values.astype(float), ("replica", share.bond_longest.dims[-1])
    if len(rest) < 2:
        return dict.fromkeys(found, np.nan)
    return {name: np.polyfit(rest, values.mean(others), 1)[0] for name, values in found.items()}


def _heats(sweep):
    """kT of the paper's sets, and their time steps."""
    chosen = sweep.sel(set=[name for name in SETS if name in sweep.set.values])
    kT, error = over_replicas(chosen.kT.values, chosen.kT_error.values, -1)
    steps = [first_scene(chosen.sel(set=n)).dt for n in chosen.set.values]
    return xr.Dataset(
        {
            "set_kT": ("set", kT, {"units": "kT"}),
            "set_kT_error": ("set", error, {"units": "kT"}),
            "set_dt": ("set", steps, {"units": "tau"}),
        },
        {"set": chosen.set.values},
    )


def _stable(runs):
    """Largest dt up to which every run stays whole and warm within `WARM`; 0 of none."""
    good = ((np.abs(runs.kT - 1) < WARM) & (runs.lost_step < 0)).all("replica").sortby("dt")
    return (good.cumprod("dt") * good.dt).max("dt").transpose("force", "stiffness")


def _rise(data, name):
    """Change from the lowest F_max that the text means to the highest, at C of set (1).

    Bonds rest at the 2 r_0 that was measured, so its error is part of that of the change.
    """
    meant = data.force.values >= CHOSEN
    if SET_STIFFNESS not in data.stiffness.values or meant.sum() < 2:
        return Measured(np.nan, np.nan)
    along = data.sel(stiffness=SET_STIFFNESS).isel(force=meant)
    low, high = along.isel(force=0), along.isel(force=-1)
    cores = data.contact_error.sel(core_force=[low.force, high.force])
    error = np.hypot(low[f"{name}_error"], high[f"{name}_error"])
    error = float(np.hypot(error, data.attrs[f"{name}_by_rest"] * np.hypot(*cores.values)))
    listed = ", ".join(f"{float(v):.4g}" for v in along[name])
    forces = ", ".join(f"{f:g}" for f in along.force.values)
    return Measured(
        float(high[name] - low[name]), error, f"{listed} at F_max {forces}, C {SET_STIFFNESS}"
    )


def measured(data):
    """What the text says of F_max and of the time step."""
    contact, error = data.contact.values, data.contact_error.values
    forces = ", ".join(f"{f:g}" for f in data.core_force.values)
    listed = ", ".join(f"{value:.3f}" for value in contact)
    found = {
        "contact_rises": Measured(
            contact[-1] - contact[0], np.hypot(error[0], error[-1]),
            f"2 r_0 = {listed} at F_max {forces}", data.undecided,
        ),
        "longest_rises": _rise(data, "longest"),
        "spread_rises": _rise(data, "variance"),
    }  # fmt: skip
    return found | {f"heat_{name[-1]}": _heat(data, name) for name in SETS}


def _heat(data, name):
    """kT of a parameter set at the paper's time step, less 1."""
    if name not in data.set.values:
        return Measured(np.nan, np.nan)
    at = data.sel(set=name)
    dt = float(at.set_dt)
    other = "" if np.isclose(dt, PAPER_STEP) else f"these runs have dt {dt:g}"
    tried = _tried(data) if name == "set_1" else ""
    return Measured(float(at.set_kT) - 1, float(at.set_kT_error), tried, other)


def _tried(data):
    """What shorter runs of set (1) say of other time steps."""
    place = {"stable_force": SET_FORCE, "stable_stiffness": SET_STIFFNESS}
    if not all(value in data[axis].values for axis, value in place.items()):
        return ""
    at = data.sel(place)
    tried = ", ".join(
        f"{float(kT):.3f} {f'+- {float(error):.3f}' if error > 0 else '(no error)'} at {dt:g}"
        for dt, kT, error in zip(data.dt.values, at.kT, at.kT_error)
    )
    return f"shorter runs with chains of 20: kT {tried}"


def warnings(data):
    """Runs that are not as warm as the others, which the comparison asks for."""
    off = abs(data.melt_kT - 1)
    for place in np.argwhere((off > EVEN + AGREE * data.melt_kT_error).values):
        at = data.isel(force=place[0], stiffness=place[1])
        yield (
            f"kT is {float(at.melt_kT):.3f} at F_max {at.force.item():g}, C "
            f"{at.stiffness.item():g}, more than {EVEN:.0%} from 1."
        )


def _course(data):
    """What the variance at C of set (1) does over F_max, in words."""
    if SET_STIFFNESS not in data.stiffness.values:
        return "is not known"
    variance = data.variance.sel(stiffness=SET_STIFFNESS).values
    lowest = int(np.argmin(variance))
    turn = f"{data.force.values[lowest]:g}"
    fallen = f"falls up to F_max {turn} and rises from there" if lowest else "rises with it"
    return fallen if lowest < len(variance) - 1 else "falls with it"


def describe(data):
    """What is seen, in words."""
    first, last = data.contact.values[[0, -1]]
    return (
        f"Over F_max: the closest contact of monomers rises from {first:.2f} to {last:.2f} r_c, "
        f"and so does the longest bond. At C = {SET_STIFFNESS} the variance of bonds "
        f"{_course(data)}. The share of long bonds and the rate of crossings fall steeply with C."
    )


def draw(data):
    """Six panels over F_max, a line for each C."""
    figure, axes = panels(3, 2, height=2.3)
    core, variance, longest, share, rate, steps = axes.ravel()
    core.errorbar(data.core_force, data.contact, COVERAGE * data.contact_error, fmt="o-",
                  color=BLACK, capsize=2)  # fmt: skip
    core.axhline(2 * 0.15, color=BLACK, linestyle=":", linewidth=0.8, label="$2 r_s$")
    core.legend(loc="lower right")
    longest.plot(data.force, 2 * data.rest.isel(stiffness=0), "--", color=BLACK, label="$4 r_0$")
    longest.legend(loc="upper left")
    for k, (stiffness, color) in enumerate(zip(data.stiffness.values, cycle(COLORS))):
        at = data.sel(stiffness=stiffness)
        aside = BESIDE ** (k - 0.5 * (data.sizes["stiffness"] - 1))
        force, label = aside * data.force.values, f"C = {stiffness:g}"
        for panel, name, factor in ((variance, "variance", stiffness), (longest, "longest", 1)):
            reach = factor * COVERAGE * at[f"{name}_error"]
            panel.errorbar(force, factor * at[name], reach, fmt="o-", color=color,
                           label=label if panel is variance else None)  # fmt: skip
        reach = COVERAGE * at.share_error
        low = np.maximum(at.share - reach, 0.1 * at.share)  # an axis of logarithms has no zero
        _seen(share, force, at.share, (low, at.share + reach), at.share_bound, color)
        rates = at.begun / at.exposure
        ends = [end / at.exposure for end in interval(at.begun)]
        _seen(rate, force, rates, ends, NONE_SEEN / at.exposure, color)
        if stiffness in data.stable_stiffness.values:
            stable = data.stable_dt.sel(stable_stiffness=stiffness)
            steps.plot(aside * data.stable_force, stable.where(stable > 0), "o-", color=color)
    figure.legend(*variance.get_legend_handles_labels(), loc="outside upper center",
                  ncols=data.sizes["stiffness"])  # fmt: skip
    steps.set(yscale="log", ylim=(0.7 * float(data.dt.min()), 1.5 * float(data.dt.max())))
    steps.set_yticks(data.dt.values, [f"{dt:g}" for dt in data.dt.values])
    labels = (
        "closest contact $2 r_0$ / $r_c$", "C times bond variance / $k_BT$", "longest bond / $r_c$",
        "share of bonds > $4 r_0$", r"crossing rate per bond / $\tau_0^{-1}$",
        r"largest stable dt / $\tau_0$",
    )  # fmt: skip
    for panel, label in zip(axes.ravel(), labels):
        panel.set(xscale="log", ylabel=label)
        panel.set_xticks(data.core_force.values, [f"{f:g}" for f in data.core_force.values])
        panel.minorticks_off()
    for panel in axes[-1]:
        panel.set_xlabel(r"core force $F_{max}$ / ($k_BT$ $r_c^{-1}$)")
    return figure


def _seen(panel, x, value, ends, bound, color):
    """Values with the ends of their intervals; hollow upper bounds where nothing was seen."""
    seen = (value > 0).values
    low, high = ends
    panel.errorbar(x[seen], value[seen], [(value - low)[seen], (high - value)[seen]], fmt="o",
                   color=color)  # fmt: skip
    panel.plot(x[~seen], bound[~seen], "v", color=color, markerfacecolor="white")
    panel.plot(x, np.where(seen, value, bound), color=color, linewidth=0.7)
    panel.set_yscale("log")
