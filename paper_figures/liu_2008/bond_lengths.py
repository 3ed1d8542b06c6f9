"""Bond lengths of the two sets against the size of the core: may bonds cross?"""

import numpy as np
import xarray as xr

from dpd.analysis.collect import first_scene
from dpd.analysis.statistics import COVERAGE, block_mean_and_error, linear_fit
from dpd.analysis.structure import blocks_of
from dpd.analysis.verdicts import Measured, shown_by
from dpd.report.style import BLACK, BLUE, RED, mpl, panels, points, published_line
from paper_figures.liu_2008.shared import (
    SETS,
    closest_contact,
    printed_share,
    samples_of,
    share_of_long_bonds,
)

PUBLISHED = shown_by(__file__)
SHARE = printed_share(PUBLISHED["share"].value)

TITLE = "Bond lengths in melts of sets (1) and (2), N = 100, and bonds longer than 4 r_0."
PAPER_SHOWS = (
    "Not a figure of the paper. In two dimensions bonds cannot cross while 4 r_0 > l_max, with "
    "l_max the longest bond seen and 2 r_0 the closest contact of monomers: the lower edge of the "
    "first bin (0.01 r_c wide) of g(r) that is not empty in one configuration of 20 000 beads, "
    "median over 50 configurations. (a) Dashed, with its 95 % interval: 4 r_0."
    " Dotted: l_max of this run. (b) Share of set (1)'s bonds that are longer than 4 r_0, for "
    "melts whose 2 r_0, and rest length, would be a little smaller or larger. Band: our 2 r_0 with "
    f"its 95 % interval. Long dashes: the published {100 * SHARE:g} %."
)
ERRORS = (
    "(a) Errors of the curves, from blocks of the run, are smaller than the lines but in the tails."
    " (b) 95 % intervals from blocks. The share falls exponentially with 2 r_0, so that a bin "
    "more or less makes it smaller or larger by a factor. The paper prints neither its 2 r_0 nor "
    "its bins: the verdict is on the 2 r_0 that would give the printed share, interpolated between "
    "the runs."
)
COLORS = {"set_1": BLUE, "set_2": RED}
USED = ["scene", "bond_density", "bond_longest", "bond_mean"]
DIAMETER = 2 * 0.15  # 2 r_s of set (1)
TOP = 100.0  # of the lines, below the legend
BEADS = 20_000  # of the configuration of which 2 r_0 is the closest contact
FORCE = 100.0  # F_max of both sets, in kT / r_c: contacts are as rare as exp(-F_max depth)


def compute(sweeps):
    """Distributions, longest bonds, and the share of bonds beyond 4 r_0 over 2 r_0."""
    runs, share = (sweeps[name][USED] for name in ("sets", "share"))
    monomers = sweeps["monomers"][["rdf", "beads"]]
    chosen = [name for name in SETS if name in runs.set.values]
    rows, curves = [], []
    for name in chosen:
        at = runs.sel(set=name)
        curves.append(block_mean_and_error(blocks_of(at.bond_density)))
        radius = first_scene(at).data["core"]["radius"]
        known = radius in monomers.r_s.values
        core = closest_contact(monomers.sel(r_s=radius)) if known else None
        rows.append((
            *(core[:2] if core else (np.nan, np.nan)), float(at.bond_longest.max()),
            # Largest values scatter alike, Gumbel's way: of the run as of its blocks.
            float(at.bond_longest.values.std(ddof=1)),
            float(at.bond_mean.mean()), samples_of(at, "bonds"),
        ))  # fmt: skip
    beyond = np.array([
        share_of_long_bonds(share.sel(rest_length=rest)) for rest in share.rest_length.values
    ])  # fmt: skip
    data = xr.Dataset(
        {
            "density": (("set", "bond_length"), [d for d, _ in curves], {"units": "1 / r_c"}),
            "density_error": (("set", "bond_length"), [e for _, e in curves], {"units": "1 / r_c"}),
            "share": ("rest_length", beyond[:, 0], {"units": "1"}),
            "share_error": ("rest_length", beyond[:, 1], {"units": "1"}),
        },
        {"set": chosen, "bond_length": runs.bond_length, "rest_length": share.rest_length},
        {"undecided": closest_contact(monomers.isel(r_s=0)).undecided},
    )
    for name, unit, column in zip(
        ("core", "core_error", "longest", "longest_error", "mean_length", "samples"),
        ("r_c", "r_c", "r_c", "r_c", "r_c", "1"),
        np.array(rows).T,
    ):
        data[name] = ("set", column, {"units": unit})
    return data


def _share(data):
    """Logarithm of the share at our 2 r_0, and the 2 r_0 at which it is the printed one."""
    seen = (data.share > 0).values
    if "set_1" not in data.set.values or seen.sum() < 3:
        reason = "bonds longer than 4 r_0 were seen at fewer than three rest lengths"
        return dict.fromkeys(("share", "share_contact"), Measured(np.nan, np.nan, "", reason))
    core, width = (float(data[name].sel(set="set_1")) for name in ("core", "core_error"))
    rest, share = data.rest_length.values[seen], data.share.values[seen]
    logarithm = np.log10(share)
    spread = np.maximum(data.share_error.values[seen] / share, 1e-3) / np.log(10)
    x = rest - core
    fit = linear_fit([np.ones_like(x), x], logarithm, spread)
    (here, slope), (here_error, _) = fit.values, fit.errors
    low, middle, high = 10.0 ** (here + slope * np.array([width, 0, -width]))
    error = float(np.hypot(slope * width, here_error))
    note = (
        f"share {middle:.2%}, {low:.2%} to {high:.2%} for 2 r_0 = {core:.3f} +- "
        f"{width:.3f}; published {100 * SHARE:g} %"
    )
    unsaid = "it hangs on 2 r_0, which the text does not print"
    back = linear_fit([np.ones_like(x), logarithm - np.log10(SHARE)], rest, spread / abs(slope))
    there, there_error = float(back.values[0]), float(back.errors[0])
    return {
        "share": Measured(float(here), error, note, data.undecided or unsaid),
        "share_contact": Measured(
            there / DIAMETER, there_error / DIAMETER,
            f"2 r_0 = {there:.4f}; ours, from one configuration, is {core:.3f} +- {width:.3f}",
        ),
    }  # fmt: skip


def measured(data):
    """The criterion for each set."""
    found = _share(data)
    for name in SETS:
        number = name[-1]
        if name not in data.set.values:
            found[f"criterion_{number}"] = Measured(np.nan, np.nan)
            continue
        at = data.sel(set=name)
        limit = 2 * float(at.core)
        ratio = float(at.longest) / limit
        note = (
            f"l_max {float(at.longest):.3f} in {float(at.samples):.2g} bead-samples, 4 r_0 = "
            f"{limit:.3f}; mean bond {float(at.mean_length):.3f}"
        )
        error = ratio * float(np.hypot(at.core_error / at.core, at.longest_error / at.longest))
        # Sampled as often as bonds are, contacts would be closer by that much: a larger ratio.
        closer = float(np.log(at.samples / BEADS)) / FORCE
        systematic = ratio * closer / float(at.core) if ratio < 1 else 0.0
        found[f"criterion_{number}"] = Measured(
            ratio, float(np.hypot(error, systematic)), note, data.undecided, systematic=systematic
        )
    return found


def describe(data):
    """What is seen, in words."""
    longest = ", ".join(
        f"{SETS[at.item()]}: l_max {float(data.longest.sel(set=at)):.2f} r_c, 4 r_0 "
        f"{2 * float(data.core.sel(set=at)):.2f} r_c"
        for at in data.set
    )
    shares = ", ".join(
        f"{float(s):.2%} at {float(r):g}" for r, s in zip(data.rest_length, data.share)
    )
    return (
        f"(a) Distributions of bond lengths; {longest}. (b) The share falls with 2 r_0: {shares}."
    )


def draw(data):
    """Distributions on a logarithmic axis, and the share over 2 r_0."""
    figure, (left, right) = panels(2)
    for name in data.set.values:
        at, color = data.sel(set=name), COLORS[name]
        seen = at.density.values > 0
        left.plot(data.bond_length[seen], at.density[seen], color=color, label=SETS[name])
        limit, reach = 2 * float(at.core), 2 * COVERAGE * float(at.core_error)
        left.fill_betweenx(
            [1e-4, TOP], limit - reach, limit + reach, color=color, alpha=0.15, linewidth=0
        )
        left.vlines(limit, 0, TOP, color=color, linestyle="--", linewidth=0.8)
        left.vlines(float(at.longest), 0, TOP, color=color, linestyle=":", linewidth=0.9)
    left.plot([], [], color=BLACK, linestyle="--", linewidth=0.8, label="$4 r_0$")
    left.plot([], [], color=BLACK, linestyle=":", linewidth=0.9, label="$l_{max}$")
    left.set(yscale="log", xlim=(0, 1), ylim=(1e-4, 1e4), xlabel="bond length / $r_c$",
             ylabel="probability density / $r_c^{-1}$")  # fmt: skip
    left.legend(loc="upper left", ncols=2)
    seen = data.where(data.share > 0, drop=True)
    points(right, seen.rest_length, seen.share, seen.share_error, "set (1)", BLUE)
    margin = 0.005
    ends = [float(data.rest_length.min()) - margin, float(data.rest_length.max()) + margin]
    published_line(right, ends, [SHARE] * 2, "published")
    if "set_1" in data.set.values:
        core, error = (float(data[name].sel(set="set_1")) for name in ("core", "core_error"))
        right.axvspan(core - COVERAGE * error, core + COVERAGE * error, color=BLACK, alpha=0.1,
                      linewidth=0, label="our $2 r_0$")  # fmt: skip
    right.set(yscale="log", xlim=ends, ylim=(1e-4, 2e-2), xlabel="closest contact $2 r_0$ / $r_c$",
              ylabel="share of bonds longer than $4 r_0$")  # fmt: skip
    right.yaxis.set_minor_formatter(mpl.ticker.NullFormatter())
    right.legend(loc="upper right")
    return figure
