"""Figure 2: superposed configurations of one chain, a cloud or a tube."""

import numpy as np
import xarray as xr

from dpd.report.style import BLACK, panels

TITLE = "Ten configurations of one chain at times 100 tau apart, projected."
PAPER_SHOWS = (
    "The paper shows a chain of N = 256: (a) a 25, k 50, a cloud; (b) a 100, k 200, a tube. Gray:"
    " the first 500 tau, black: the second. Here: the first chain of the box, or of the longest "
    "chains that this study has; seen along the axis in which it is least extended."
)
ERRORS = "Without error bars: one chain each."
NAMES = {"a25": "(a) a 25, k 50", "a100": "(b) a 100, k 200"}


def compute(sweeps):
    """Configurations, projected on the plane in which the chain is most extended."""
    runs = sweeps["tube"].isel(replica=0).transpose("set", "moment", "axis", "monomer", ...)
    places = []
    for name in runs.set.values:
        trace = runs.trace.sel(set=name).values
        centred = trace - trace.mean(axis=(0, 2))[None, :, None]
        flat = np.moveaxis(centred, 1, 0).reshape(3, -1)
        _, vectors = np.linalg.eigh(flat @ flat.T)
        places.append(np.einsum("ca,mab->mcb", vectors[:, ::-1][:, :2].T, centred))
    time = runs.trace_time.isel(set=0)
    return xr.Dataset(
        {
            "place": (("set", "moment", "side", "monomer"), places, {"units": "r_c"}),
            "time": ("moment", time.values, {"units": "tau"}),
        },
        {"set": runs.set},
    )


def measured(data):
    """None: a picture."""
    return {}


def draw(data):
    """Two panels on one scale."""
    figure, axes = panels(2, height=3.4)
    middle = float(data.time.max()) / 2
    reach = 1.05 * float(np.abs(data.place).max())
    for panel, name in zip(axes, data.set.values):
        for moment, time in enumerate(data.time.values):
            x, y = data.place.sel(set=name).isel(moment=moment).values
            late = time > middle
            panel.plot(
                x, y, color=BLACK if late else "0.65", linewidth=0.7, zorder=2 if late else 1
            )
        title = f"{NAMES.get(name, name)}, N = {data.sizes['monomer']}"
        panel.set(xlim=(-reach, reach), ylim=(-reach, reach), aspect="equal", title=title,
                  xlabel="$x$ / $r_c$", ylabel="$y$ / $r_c$")  # fmt: skip
    return figure
