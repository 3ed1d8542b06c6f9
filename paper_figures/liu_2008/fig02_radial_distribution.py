"""Figure 2: g(r) of monomers for four core radii, and how close they come."""

import numpy as np
import xarray as xr

from dpd.analysis.collect import samples_of
from dpd.analysis.statistics import COVERAGE, jackknife, linear_fit
from dpd.analysis.structure import (
    contact,
    contact_over_sampling,
    peak,
    radial_distribution,
    rise,
)
from dpd.analysis.verdicts import Measured
from dpd.report.style import BLACK, BLUE, GREEN, ORANGE, RED, panels, points

TITLE = "Radial distribution functions of monomers with rigid cores (rho 2, a 25, F_max 100)."
PAPER_SHOWS = (
    "The paper shows g(r) for r_s = 0, 0.15, 0.20 and 0.25 (left), and takes 2 r_0, the smallest "
    "distance met, from its first bin that is not empty. Dotted: the published first peaks. "
    "Right: that distance (lower edge of the bin) over the number of bead-samples that g(r) was "
    "made of; the core is finite, so it keeps falling. Dashed: 2 r_s. Open symbols: distance "
    "where g reaches 0.05, which does not depend on sampling."
)
ERRORS = (
    "Bands and bars: 95 % intervals from blocks of the run; peaks by a cubic through the bins "
    "within 0.15 r_c of the highest, errors by leaving out blocks."
)
COLORS = {0.0: BLACK, 0.15: BLUE, 0.2: GREEN, 0.25: RED}
PUBLISHED_PEAKS = (0.78, 0.67)


def compute(sweeps):
    """g(r), peaks, and the distance of closest contact over sampling."""
    runs = sweeps["monomers"]
    r, r_s = runs.r.values, runs.r_s.values.astype(float)
    table, rows, drift = [], [], []
    for radius in runs.r_s.values:
        at = runs.sel(r_s=radius)
        g, error, blocks = radial_distribution(at)
        table.append((g, error))
        highest = jackknife(blocks, lambda mean: peak(r, mean))
        closest = jackknife(blocks, lambda mean: rise(r, mean))
        found = contact_over_sampling(r, blocks, samples_of(at, "rdf") / len(blocks))
        drift.append(found)
        rows.append((*highest, *closest, contact(r, g), *_slope(*found)))
    data = xr.Dataset(
        {
            "g": (("r_s", "r"), [g for g, _ in table], {"units": "1", "long_name": "g(r)"}),
            "g_error": (("r_s", "r"), [e for _, e in table], {"units": "1"}),
            "samples": (("r_s", "sampling"), [d[0] for d in drift], {"units": "1"}),
            "contact_over_sampling": (("r_s", "sampling"), [d[1] for d in drift], {"units": "r_c"}),
            "contact_error": (("r_s", "sampling"), [d[2] for d in drift], {"units": "r_c"}),
        },
        {"r_s": ("r_s", r_s, {"units": "r_c"}), "r": runs.r},
        {"bin": float(r[1] - r[0])},
    )
    names = ("peak", "peak_error", "rise", "rise_error", "contact", "drift", "drift_error")
    for name, column in zip(names, np.array(rows).T):
        data[name] = ("r_s", column, {"units": "r_c"})
    return data


def _slope(samples, distance, error):
    """Change of the distance per decade of sampling, and its error."""
    known = np.isfinite(error) & (error > 0)
    if known.sum() < 3:
        return np.nan, np.nan
    x = np.log10(samples[known])
    fit = linear_fit([np.ones_like(x), x], distance[known], error[known])
    return fit.values[1], fit.errors[1]


def measured(data):
    """Peaks, the core that is met, and its drift."""
    found = {}
    for radius in (0.0, 0.15, 0.2, 0.25):
        here = np.isclose(data.r_s, radius)
        name = f"{100 * radius:.0f}"
        at = data.isel(r_s=int(np.argmax(here))) if here.any() else data.isel(r_s=0) * np.nan
        found[f"peak_{name}"] = Measured(float(at.peak), float(at.peak_error))
        if radius not in (0.15, 0.25):
            continue
        single = float(at.contact_over_sampling[0])
        found[f"contact_{name}"] = Measured(
            float(at.contact) / (2 * radius), data.attrs["bin"] / (2 * radius),
            f"error: one bin; 2 r_0 = {float(at.contact):.2f} with bins of {data.bin:.2g} and "
            f"{float(at.samples.max()):.2g} bead-samples, {single:.3f} with "
            f"{float(at.samples.min()):.2g}; g = 0.05 at {float(at.rise):.3f}",
        )  # fmt: skip
        found[f"drift_{name}"] = Measured(
            float(at.drift), float(at.drift_error),
            "straight line in the logarithm of the number of bead-samples",
        )  # fmt: skip
    return found


def draw(data):
    """g(r), the paper's axes; and the closest contact."""
    figure, (left, right) = panels(2)
    for radius in data.r_s.values:
        at, color = data.sel(r_s=radius), COLORS.get(float(radius), ORANGE)
        label = f"$r_s$ = {radius:g}"
        reach = COVERAGE * at.g_error
        left.fill_between(data.r, at.g - reach, at.g + reach, color=color, alpha=0.3, linewidth=0)
        left.plot(data.r, at.g, color=color, label=label)
        points(
            right, at.samples, at.contact_over_sampling, at.contact_error, label, color,
            linestyle="-",
        )  # fmt: skip
        points(right, at.samples[-1:], [at.rise], [at.rise_error], None, color, "s", filled=False)
        if radius > 0:
            right.axhline(2 * radius, color=color, linestyle="--", linewidth=0.7)
    for k, place in enumerate(PUBLISHED_PEAKS):
        label = "published first peaks" if k == 0 else None
        left.axvline(place, color=BLACK, linestyle=":", linewidth=0.8, label=label)
    left.set(xlim=(0, 3), ylim=(0, None), xlabel="distance r / $r_c$", ylabel="g(r)")
    left.legend(loc="lower right")
    right.set(xscale="log", ylim=(0, 0.75), xlabel="bead-samples in g(r)",
              ylabel="closest contact $2 r_0$ / $r_c$")  # fmt: skip
    right.legend(loc="upper right", ncols=2)
    return figure
