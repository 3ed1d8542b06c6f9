"""What the core force F_max and the spring constant C do."""

import numpy as np
import xarray as xr

from dpd.analysis.collect import first_scene
from dpd.analysis.statistics import block_mean_and_error, over_replicas
from dpd.analysis.structure import blocks_of, contact, radial_distribution, rise
from dpd.analysis.verdicts import AGREE, Measured
from dpd.report.style import BLACK, BLUE, GREEN, ORANGE, PURPLE, RED, panels, points

TITLE = "Core force and bond stiffness (melts of N = 20, r_s 0.15, rest length 0.25)."
PAPER_SHOWS = (
    "Not a figure of the paper, which says that it chose F_max two to four times a and C large, "
    "and that mean-square bond deviation, l_max and closest contact all rise with F_max. All runs"
    " begin from one melt of set (1). The largest stable dt is the largest of the sweep up to "
    "which no run blew up and kT stayed within 3 % of 1."
)
ERRORS = (
    "On the longest bond of a block of the run, mean over blocks (filled), and on kT: 95 % "
    "intervals. Closest contacts and the longest bond of a whole run (hollow), extremes, have "
    "none; shares and rates below the ticks are zero in this run."
)
COLORS = (BLUE, GREEN, RED, ORANGE, PURPLE, BLACK)
WARM = 0.03  # of kT, the limit of Groot and Warren 1997, Sec. III
SET = (100, 300)  # F_max and C of set (1)


def compute(sweeps):
    """Contacts, bonds, crossings and stable steps over F_max and C."""
    runs, steps = sweeps["rigidity"], sweeps["stability"]
    r, length = runs.r.values, runs.bond_length.values
    width = length[1] - length[0]
    shape = (runs.sizes["force"], runs.sizes["stiffness"])
    names = (
        "contact", "rise", "longest", "longest_of_block", "longest_of_block_error", "spread",
        "spread_error", "share", "rate", "stable_dt",
    )  # fmt: skip
    table = {name: np.full(shape, np.nan) for name in names}
    for place in np.ndindex(shape):
        at = runs.isel(force=place[0], stiffness=place[1])
        scene = first_scene(at)
        g = radial_distribution(at)[0]
        density = at.bond_density.mean(("replica", "block")).values
        longest = block_mean_and_error(blocks_of(at.bond_longest))
        spread = block_mean_and_error((at.bond_mean_square - at.bond_mean**2).values.ravel())
        bonds = float(at.beads.sum()) * (1 - 1 / len(scene.molecules[0].beads))
        time = float(at.crossing_time.isel(replica=0).max())
        found = {
            "contact": contact(r, g),
            "rise": rise(r, g),
            "longest": float(at.bond_longest.max()),
            "longest_of_block": float(longest[0]),
            "longest_of_block_error": float(longest[1]),
            "spread": float(spread[0]),
            "spread_error": float(spread[1]),
            "share": density[length > 2 * scene.data["bond"]["length"]].sum() * width,
            "rate": float(at.crossings_begun.sum()) / (bonds * time),
            "stable_dt": _stable(steps.isel(force=place[0], stiffness=place[1])),
        }
        for name, value in found.items():
            table[name][place] = value
    units = ("r_c",) * 5 + ("r_c^2", "r_c^2", "1", "1 / tau", "tau")
    data = xr.Dataset(coords={"force": runs.force, "stiffness": runs.stiffness, "dt": steps.dt})
    for name, unit in zip(names, units):
        data[name] = (("force", "stiffness"), table[name], {"units": unit})
    kT, error = over_replicas(steps.kT.values, steps.kT_error.values, -1)
    data["kT"] = (steps.kT.dims[:-1], kT, {"units": "kT"})
    data["kT_error"] = (steps.kT.dims[:-1], error, {"units": "kT"})
    data.attrs["bin"] = float(r[1] - r[0])
    data.attrs["blocks"] = len(blocks_of(at.bond_longest))
    data.attrs["limit"] = 2 * scene.data["bond"]["length"]
    return data


def _stable(at):
    """Largest dt up to which every run stays whole and warm within `WARM`."""
    warm = (np.abs(at.kT - 1) < WARM).all("replica") & (at.lost_step < 0).all("replica")
    good = at.dt.values[np.cumprod(warm.sortby("dt").values).astype(bool)]
    return float(good.max()) if len(good) else 0.0


def _rise(data, name, error, note):
    """Change from the lowest to the highest F_max, at C of set (1)."""
    low, high = (data.sel(stiffness=SET[1]).isel(force=k) for k in (0, -1))
    if isinstance(error, str):
        error = float(np.hypot(low[error], high[error]))
    change = float(high[name] - low[name])
    unseen = abs(change) <= AGREE * error
    return Measured(
        change, error, note, "the change is within two standard errors" if unseen else ""
    )


def measured(data):
    """What the text says of F_max, and of dt 0.002."""
    span = f"from F_max {data.force.values[0]:g} to {data.force.values[-1]:g} at C {SET[1]}"
    missing = SET[1] not in data.stiffness.values or SET[0] not in data.force.values
    if missing or data.sizes["force"] < 2:
        return dict.fromkeys(
            ("contact_rises", "longest_rises", "spread_rises", "time_step"),
            Measured(np.nan, np.nan),
        )
    stable = float(data.stable_dt.sel(force=SET[0], stiffness=SET[1]))
    tried = ", ".join(
        f"{dt:g}: {float(data.kT.sel(force=SET[0], stiffness=SET[1], dt=dt)):.3f}"
        for dt in data.dt.values
    )
    return {
        "contact_rises": _rise(data, "contact", data.attrs["bin"], f"{span}; error: one bin"),
        "longest_rises": _rise(
            data,
            "longest_of_block",
            "longest_of_block_error",
            f"{span}; the longest of each of {data.attrs['blocks']} blocks of the run, mean",
        ),
        "spread_rises": _rise(data, "spread", "spread_error", span),
        "time_step": Measured(stable, 0.0, f"kT at dt {tried}"),
    }


def draw(data):
    """Five panels over F_max, a line for each C."""
    shown = (
        ("contact", r"closest contact $2 r_0$ / $r_c$", "linear"),
        ("longest_of_block", r"longest bond $l_{max}$ / $r_c$", "linear"),
        ("share", rf"share of bonds > {data.limit:g} $r_c$", "log"),
        ("rate", r"crossings per bond and $\tau$", "log"),
        ("stable_dt", r"largest stable dt / $\tau$", "log"),
        ("kT", r"$k_BT$ at $F_{max}$ = " + f"{SET[0]}", "linear"),
    )
    figure, axes = panels(3, 2, height=2.3)
    for panel, (name, label, scale) in zip(axes.ravel(), shown):
        for stiffness, color in zip(data.stiffness.values, COLORS):
            at = data.sel(stiffness=stiffness)
            if name == "kT":
                at = at.sel(force=SET[0], method="nearest")
            x, y = at[at[name].dims[0]], at[name]
            y = y.where(y > 0) if scale == "log" else y
            label = f"C = {stiffness:g}"
            if f"{name}_error" in at:
                points(panel, x, y, at[f"{name}_error"], label, color, linestyle="-")
            else:
                panel.plot(x, y, "o-", color=color, label=label)
            if name == "longest_of_block":
                panel.plot(x, at.longest, "o", color=color, markerfacecolor="white")
        panel.set(ylabel=label, yscale=scale, xlabel=r"core force $F_{max}$ / ($k_BT$ $r_c^{-1}$)")
        if name == "longest_of_block":
            panel.axhline(data.limit, color=BLACK, linestyle="--", linewidth=0.8)
        if not (data[name] > 0).any():
            panel.text(0.5, 0.5, "none in any run", transform=panel.transAxes, ha="center")
    rates = data.rate.values[data.rate.values > 0]
    if len(rates):
        axes[1, 0].set_ylim(0.3 * rates.min(), 3 * rates.max())
    steps, warm = axes[1, 1], axes[1, 2]
    steps.set_yticks(data.dt.values, [f"{dt:g}" for dt in data.dt.values])
    steps.set_ylim(0.7 * float(data.dt.min()), 1.5 * float(data.dt.max()))
    steps.minorticks_off()
    warm.axhspan(1 - WARM, 1 + WARM, color=BLACK, alpha=0.1, linewidth=0)
    warm.set(xscale="log", xlabel=r"time step dt / $\tau$", ylim=(0.95, 1.3))
    warm.set_xticks(data.dt.values, [f"{dt:g}" for dt in data.dt.values])
    warm.minorticks_off()
    axes[0, 0].legend()
    return figure
