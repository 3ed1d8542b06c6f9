"""Figure 2: superposed configurations of one chain, a cloud or a tube."""

import numpy as np
import xarray as xr

from dpd.analysis.verdicts import shown_by
from dpd.report.style import BLACK, panels
from paper_figures.nikunen_2007.shared import repulsion

CROSSOVER = shown_by(__file__)["crossover_diffusion"]  # chain lengths

TITLE = "Ten configurations of one chain at times 100 apart (in DPD time units), projected."
PAPER_SHOWS = (
    "The paper shows a chain of N = 256: (a) a 25, k 50, a cloud; (b) a 100, k 200, a tube. Gray:"
    " times up to 500, black: from 500 to 1000. Here: the first chain of the box, seen along the "
    "axis in which it is least extended. A tube shows only where chains are much longer than an "
    f"entanglement, for which the published crossover between N = {CROSSOVER.low:g} and "
    f"{CROSSOVER.high:g} stands, and only within less than their relaxation time."
)
ERRORS = "Without error bars: one chain each."
MUCH_LONGER = 3  # of the longest of these lengths


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
            "time": ("moment", time.values, {"units": "tau_0"}),
        },
        {"set": runs.set},
    )


def measured(data):
    """None: a picture."""
    return {}


def warnings(data):
    """Chains too short for a tube."""
    n = data.sizes["monomer"]
    if n >= MUCH_LONGER * CROSSOVER.high:
        return []
    return [
        f"Chains of N = {n} are not much longer than the {CROSSOVER.low:g} to {CROSSOVER.high:g} "
        "beads of the published crossover, so that a tube shows in part at best; the study `paper` "
        "has N = 256."
    ]


def describe(data):
    """What is seen: how far the second half of each set strays from the first."""
    n = data.sizes["monomer"]
    seen = [
        f"{_parameters(name)}: rms displacement of a bead between neighbouring times "
        f"{_step(data.place.sel(set=name).values):.1f} r_c"
        for name in data.set.values
    ]
    return f"Ten superposed configurations of a chain of {n} for each set; {'; '.join(seen)}."


def _parameters(name):
    """Repulsion and spring constant of a set."""
    return f"a = {repulsion(name)}, k = {2 * repulsion(name)}"


def _step(places):
    """Root mean square displacement of beads from one configuration to the next."""
    return float(np.sqrt((np.diff(places, axis=0) ** 2).sum(axis=1).mean()))


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
        title = f"{_parameters(name)}, N = {data.sizes['monomer']}"
        panel.set(xlim=(-reach, reach), ylim=(-reach, reach), aspect="equal", title=title,
                  xlabel="$x$ / $r_c$", ylabel="$y$ / $r_c$")  # fmt: skip
    return figure
