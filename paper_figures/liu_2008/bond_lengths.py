"""Bond lengths of the two sets against the size of the core: may bonds cross?"""

import numpy as np
import xarray as xr

from dpd.analysis.collect import first_scene, samples_of
from dpd.analysis.statistics import block_mean_and_error
from dpd.analysis.structure import blocks_of, contact
from dpd.analysis.verdicts import Measured
from dpd.report.style import BLACK, BLUE, RED, panels

TITLE = "Distribution of bond lengths in melts of sets (1) and (2), N = 100."
PAPER_SHOWS = (
    "Not a figure of the paper. In two dimensions bonds cannot cross while 4 r_0 > l_max, with "
    "r_0 half the closest contact of monomers and l_max the longest bond seen. Dashed: 4 r_0 with"
    " the r_0 that the bonds' rest length 2 r_0 was taken from (one configuration of 20 000 "
    "beads). Dotted: l_max of this run. Arrows: where r_0 goes with the sampling of Figure 2's "
    "g(r)."
)
ERRORS = "The curves' errors, from blocks of the run, are smaller than the lines but in the tails."
SETS = {"set_1": ("set (1)", BLUE), "set_2": ("set (2)", RED)}
TOP = 100.0  # of the lines, below the legend


def compute(sweeps):
    """Distributions, longest bonds, and the share of bonds beyond 4 r_0."""
    runs, monomers = sweeps["sets"], sweeps["monomers"]
    length = runs.bond_length.values
    width = length[1] - length[0]
    rows, curves = [], []
    chosen = [name for name in SETS if name in runs.set.values]
    for name in chosen:
        at = runs.sel(set=name)
        scene = first_scene(at).data
        limit = 2 * scene["bond"]["length"]
        blocks = blocks_of(at.bond_density)
        density, error = block_mean_and_error(blocks)
        beyond = blocks[:, length > limit].sum(axis=1) * width
        share, share_error = block_mean_and_error(beyond)
        longest = float(at.bond_longest.max())
        radius = scene["core"]["radius"]
        sampled = np.nan
        if radius in monomers.r_s.values:
            g = monomers.rdf.sel(r_s=radius).mean(("replica", "block")).values
            sampled = 2 * contact(monomers.r.values, g)
        mean = float(at.bond_mean.mean())
        taken = samples_of(at, "bonds")
        rows.append((limit, sampled, longest, share, share_error, mean, taken))
        curves.append((density, error))
    data = xr.Dataset(
        {
            "density": (("set", "bond_length"), [d for d, _ in curves], {"units": "1 / r_c"}),
            "density_error": (("set", "bond_length"), [e for _, e in curves], {"units": "1 / r_c"}),
        },
        {"set": chosen, "bond_length": runs.bond_length},
    )
    names = ("limit", "limit_sampled", "longest", "share", "share_error", "mean_length", "samples")
    units = ("r_c", "r_c", "r_c", "1", "1", "r_c", "1")
    for name, unit, column in zip(names, units, np.array(rows).T):
        data[name] = ("set", column, {"units": unit})
    return data


def measured(data):
    """The criterion for each set."""
    found = {}
    for name in SETS:
        number = name[-1]
        if name not in data.set.values:
            found[f"criterion_{number}"] = Measured(np.nan, np.nan)
            continue
        at = data.sel(set=name)
        note = (
            f"l_max {float(at.longest):.3f} in {float(at.samples):.2g} bead-samples, 4 r_0 = "
            f"{float(at.limit):.2f}, or {float(at.limit_sampled):.2f} with r_0 from all of g(r); "
            f"mean bond {float(at.mean_length):.3f}"
        )
        found[f"criterion_{number}"] = Measured(float(at.longest / at.limit), 0.0, note)
        if name == "set_1":
            found["share"] = Measured(float(at.share), float(at.share_error))
    return {"share": Measured(np.nan, np.nan)} | found


def draw(data):
    """Distributions on a logarithmic axis."""
    figure, axes = panels(1)
    for name in data.set.values:
        at, (label, color) = data.sel(set=name), SETS[str(name)]
        seen = at.density.values > 0
        axes.plot(data.bond_length[seen], at.density[seen], color=color,
                  label=f"{label}: {float(at.share):.2g} beyond $4 r_0$")  # fmt: skip
        axes.vlines(float(at.limit), 0, TOP, color=color, linestyle="--", linewidth=0.8)
        axes.vlines(float(at.longest), 0, TOP, color=color, linestyle=":", linewidth=0.9)
        if np.isfinite(float(at.limit_sampled)):
            axes.annotate(
                "", (float(at.limit_sampled), 3e-5), (float(at.limit), 3e-5),
                arrowprops={"arrowstyle": "->", "color": color, "linewidth": 0.8},
            )  # fmt: skip
    axes.plot([], [], color=BLACK, linestyle="--", linewidth=0.8, label="$4 r_0$")
    axes.plot([], [], color=BLACK, linestyle=":", linewidth=0.9, label="$l_{max}$")
    axes.set(yscale="log", xlim=(0, 1), ylim=(1e-5, 1e5), xlabel="bond length / $r_c$",
             ylabel="probability density / $r_c^{-1}$")  # fmt: skip
    axes.legend(loc="upper left", ncols=2)
    return figure
