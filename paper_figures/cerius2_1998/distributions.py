"""End points and bond lengths of the triblock."""

import numpy as np
import xarray as xr

from dpd.analysis.statistics import COVERAGE, block_mean_and_error, jackknife
from dpd.analysis.structure import blocks_of, peak
from dpd.analysis.verdicts import Measured
from dpd.report.style import BLACK, BLUE, GREEN, ORANGE, panels
from paper_figures.cerius2_1998.shared import profile_and_errors

SETTLED = 0.5  # share of the run that is left out at its beginning

TITLE = "Distributions of the end-to-end distance and of bond lengths of A 3 B 9 A 3 in W."
PAPER_SHOWS = (
    "The manual's panel for plots shows the end-point distribution and the bond-length "
    "distribution of every polymer, without numbers. Its text wants the spring constant such that "
    "the mean bond has a reasonable length, as that of the first peak of g(r), and takes 4. (a) "
    "Distance between the two ends of a molecule; dashed: a Gaussian chain with the same mean "
    "square. (b) Bonds by the species at their ends; dotted: g(r) of all beads, scaled."
)
ERRORS = (
    "Bands: 95 % intervals from blocks of the second half of the run, with one correlation time "
    "for all bins; none where it is too short for an error."
)
LOOKS = {"A A": ORANGE, "A B": GREEN, "B B": BLUE}


def compute(sweeps):
    """Both distributions with errors, g(r) and where its first peak is."""
    runs = sweeps["triblock"]
    ends, ends_error = profile_and_errors(blocks_of(runs.end_density.isel(kind=0), SETTLED))
    bonds, bonds_error = profile_and_errors(blocks_of(runs.pair_bond_density, SETTLED))
    lengths, lengths_error = block_mean_and_error(blocks_of(runs.pair_bond_mean, SETTLED))
    g = blocks_of(runs.rdf, SETTLED)
    highest, highest_error = jackknife(g, lambda mean: peak(runs.rdf.r.values, mean))
    per_length, length = {"units": "1 / r_c"}, {"units": "r_c"}
    names = [str(name) for name in np.ravel(runs.bond_pair.values)][: runs.sizes["bond_pair"]]
    return xr.Dataset(
        {
            "ends": ("distance", ends, per_length),
            "ends_error": ("distance", ends_error, per_length),
            "bonds": (("pair", "length"), bonds, per_length),
            "bonds_error": (("pair", "length"), bonds_error, per_length),
            "mean": ("pair", lengths, length),
            "mean_error": ("pair", lengths_error, length),
            "g": ("r", g.mean(axis=0), {"units": "1"}),
            "peak": ((), highest, length),
            "peak_error": ((), highest_error, length),
        },
        {
            "distance": ("distance", runs.end_distance.values, length),
            "length": ("length", runs.pair_bond_length.values, length),
            "r": ("r", runs.r.values, length),
            "pair": names,
        },
    )


def mean_bond(data):
    """Over all bonds of A 3 B 9 A 3: 4 of A A, 2 of A B, 8 of B B."""
    weight = xr.DataArray(
        [4 / 14, 2 / 14, 8 / 14], coords={"pair": ["A A", "A B", "B B"]}, dims="pair"
    )
    value = float((weight * data["mean"]).sum())
    return value, float(np.sqrt((weight**2 * data.mean_error**2).sum()))


def measured(data):
    """The mean bond over the first peak of g(r)."""
    bond, error = mean_bond(data)
    ratio = bond / float(data.peak)
    return {
        "spring": Measured(
            ratio, ratio * float(np.hypot(error / bond, data.peak_error / data.peak)),
            f"mean bond {bond:.4f} r_c, first peak of g(r) at {float(data.peak):.3f} r_c",
        ),
    }  # fmt: skip


def describe(data):
    """What is seen."""
    width = data.distance[1] - data.distance[0]
    mean = float((data.ends * data.distance).sum() * width)
    return (
        f"The distance between the ends, {mean:.2f} r_c on average, has a peak at a smaller "
        "distance and a shoulder at larger ones, unlike a Gaussian chain. Bonds have one peak: "
        "those of A B, which cross from one domain to the other, are the longest."
    )


def draw(data):
    """Ends on the left, bonds on the right."""
    figure, (left, right) = panels(2)
    x = data.distance.values
    _band(left, x, data.ends, data.ends_error, BLACK, "this work")
    square = float((data.ends * x**2).sum() / data.ends.sum())
    gauss = 4 * np.pi * x**2 * (1.5 / (np.pi * square)) ** 1.5 * np.exp(-1.5 * x**2 / square)
    left.plot(x, gauss, color=BLACK, linestyle="--", linewidth=0.8, label="Gaussian chain")
    left.set(
        xlim=(0, x[-1]), ylim=(0, 1.4 * float(data.ends.max().fillna(1))),
        xlabel="end-to-end distance $R$ / $r_c$", ylabel=r"$P(R)$ / $r_c^{-1}$",
    )  # fmt: skip
    left.legend(loc="upper right")
    for name in data.pair.values:
        at = data.sel(pair=name)
        label = f"{name}, mean {float(at['mean']):.3f}"
        _band(right, data.length.values, at.bonds, at.bonds_error, LOOKS[str(name)], label)
    scale = float(data.bonds.max() / data.g.max())
    right.plot(data.r, scale * data.g, color=BLACK, linestyle=":", label="$g(r)$, scaled")
    right.set(
        xlim=(0, 2), ylim=(0, 1.5 * float(data.bonds.max().fillna(1))),
        xlabel="bond length $b$ / $r_c$", ylabel=r"$P(b)$ / $r_c^{-1}$",
    )  # fmt: skip
    right.legend(loc="upper right")
    return figure


def _band(axes, x, y, error, color, label):
    """A line with its 95 % interval."""
    axes.plot(x, y, color=color, label=label)
    half = COVERAGE * np.asarray(error)  # NaN leaves a gap
    axes.fill_between(x, y - half, y + half, color=color, alpha=0.3, linewidth=0)
