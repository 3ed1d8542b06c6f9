"""The worked example: slices through the density of A, and its isodensity surfaces."""

import numpy as np
import xarray as xr
from matplotlib import pyplot as plt

from dpd.analysis.collect import first_scene
from dpd.analysis.statistics import jackknife_error, taped
from dpd.analysis.verdicts import Measured
from dpd.report.draw_fields import middles, slice_of, smoothed
from dpd.report.style import DOUBLE, ORANGE
from paper_figures.cerius2_1998.shared import SMOOTH, draw_isodensity

LEVEL = 0.4  # 1 / r_c^3, the density of A at which the manual draws its surface

TITLE = "Density of A in A 3 B 9 A 3 and W, from mixed to ordered."
PAPER_SHOWS = (
    "The manual has its reader simulate this system in a box of 10 x 10 x 10 and draw a slice "
    f"through the density of a bead and the surfaces where that of A is {LEVEL:g}. It says that "
    "the surfaces close around regions where A preferably resides. Its concentrations are not "
    f"printed, nor is the unit of {LEVEL:g}: here it is beads per r_c^3. Of the repulsions it says "
    "only that those of unlike beads are larger than 25. Ours are in the line below. Top: density "
    f"of A in the plane half way up the box. Bottom: the surfaces of A at {LEVEL:g}, periodic. "
    "Each column is a mean over the time around the one that stands above it."
)
ERRORS = (
    "Densities are means over 20 configurations in 100 steps, in cubes with edges of 0.625 r_c, "
    f"smoothed over {SMOOTH:g} r_c, in the pictures and in the table. The box cuts bodies off."
)
COLUMNS = 4
SETTLED = 0.5  # share of the run that counts as ordered


def compute(sweeps):
    """Fields of A at some times, and how much of A is inside the surface over time."""
    runs = sweeps["triblock"].isel(replica=0)
    names = [str(name) for name in runs.species.values.ravel()][: runs.sizes["species"]]
    field = runs.density_field.isel(species=names.index("A"))
    values, total = field.values, float(runs.density_field.sum("species").mean())
    time = runs.field_time.values
    shown = columns_of(time)
    edge = np.array(first_scene(runs).box)
    smooth = _softened(values, edge)
    within = _by_eighth(np.where(smooth > LEVEL, smooth, 0)) / smooth.sum(axis=(1, 2, 3))
    volume = _by_eighth(smooth > LEVEL) / smooth[0].size
    axes = ("x", "y", "z")
    return xr.Dataset(
        {
            "density": (("shown", *axes), values[shown], {"units": "1 / r_c^3"}),
            "shown_time": ("shown", time[shown], {"units": "tau"}),
            "inside": (("eighth", "frame"), within, {"units": "1", "long_name": "of A, inside"}),
            "volume": (
                ("eighth", "frame"),
                volume,
                {"units": "1", "long_name": "of the box, inside"},
            ),
            "time": ("frame", time, {"units": "tau"}),
            "fraction": ((), float(values.mean() / total), {"units": "1"}),
            "edge": ("axis", edge, {"units": "r_c"}),
        }
    )


def _by_eighth(fields):
    """Sums over the eighths of the box, (8, frames), of fields, (frames, x, y, z)."""
    parts = [fields]
    for axis in (1, 2, 3):
        parts = [half for part in parts for half in np.array_split(part, 2, axis)]
    return np.stack([part.sum(axis=(1, 2, 3)) for part in parts])


@taped
def _softened(values, edge):
    """Fields of several times, smoothed; once, as it takes 0.3 s."""
    cells = [middles(count, along) for count, along in zip(values.shape[1:], edge)]
    return np.stack([smoothed(each, edge, cells, SMOOTH) for each in values])


def columns_of(time):
    """Numbers of the frames that are drawn: the first, the last, and in between by log(t)."""
    wanted = np.geomspace(time[0], time[-1], COLUMNS)
    return sorted({int(np.abs(np.log(time / t)).argmin()) for t in wanted})


def measured(data):
    """How dense A is inside of the surface once it has ordered, and while it was mixed.

    Domains merge so slowly that a run sees few of them: the error is by leaving out one eighth of
    the box at a time, which is about as large as both numbers scatter between seeds.
    """
    ordered = data.isel(frame=slice(int(SETTLED * data.sizes["frame"]), None)).mean("frame")
    (dense, dense_error), (first, first_error) = map(_denser, (ordered, data.isel(frame=0)))
    ratio = dense / first
    error = ratio * np.hypot(dense_error / dense, first_error / first)
    inside, volume = float(ordered.inside.sum()), float(ordered.volume.sum())
    return {
        "resides": Measured(
            float(ratio), float(error),
            f"{inside:.0%} of A is inside of {volume:.0%} of the box, {dense:.2f} ± "
            f"{dense_error:.2f} times as dense as the mean; alone, A would fill "
            f"{float(data.fraction):.0%}; in the first frame {first:.2f} ± {first_error:.2f} times",
        ),
    }  # fmt: skip


def _denser(parts):
    """How many times as dense as its mean A is inside, and the error, of the eighths of a box."""
    each = [parts.drop_isel(eighth=k).sum("eighth") for k in range(parts.sizes["eighth"])]
    whole = parts.sum("eighth")
    error = jackknife_error([float(rest.inside / rest.volume) for rest in each])
    return float(whole.inside / whole.volume), error


def describe(data):
    """What is seen."""
    return (
        "Four slices and four surfaces, from left to right over time: at first the density of A "
        "is speckled; then A gathers in domains that a smooth closed surface goes around."
    )


def draw(data):
    """Slices above, surfaces below."""
    count = data.sizes["shown"]
    figure = plt.figure(figsize=(DOUBLE, 3.6))
    grid = figure.add_gridspec(2, count, height_ratios=(1, 1.15))
    edge = data.edge.values
    slices = [slice_of(field, edge, 2, edge[2] / 2, SMOOTH) for field in data.density.values]
    top = np.max(slices)
    for k in range(count):
        flat = figure.add_subplot(grid[0, k])
        image = flat.imshow(
            slices[k], origin="lower", extent=(0, edge[0], 0, edge[1]),
            vmin=0, vmax=top, cmap="viridis",
        )  # fmt: skip
        flat.set(title=rf"$t$ = {float(data.shown_time[k]):.0f} $\tau$", xlabel="$x$ / $r_c$")
        flat.locator_params(nbins=3)
        if k == 0:
            flat.set(ylabel="$y$ / $r_c$")
        else:
            flat.set(yticklabels=[])
        solid = figure.add_subplot(grid[1, k], projection="3d")
        draw_isodensity(solid, data.density.values[k], LEVEL, edge, ORANGE)
    bar = figure.colorbar(image, ax=figure.axes[: 2 * count : 2], pad=0.01, shrink=0.9)
    bar.set_label(r"density of A / $r_c^{-3}$")
    return figure
