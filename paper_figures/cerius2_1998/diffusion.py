"""Diffusion coefficients of beads and of the triblock as they settle."""

import numpy as np
import xarray as xr

from dpd.report.style import BLACK, BLUE, GREEN, ORANGE, panels

TITLE = "Diffusion coefficients over time in A 3 B 9 A 3 and W."
PAPER_SHOWS = (
    "The manual's panel for plots shows the diffusion coefficients of all beads over time, without "
    "numbers. Here: the mean squared displacement since the start of the run over 6 t, of the "
    "beads of each species, and of the centres of mass of the triblock molecules."
)
ERRORS = (
    "One start in one run: no errors are drawn. Curves are the noisier the fewer beads or "
    "molecules they average over; a coefficient has settled where its curve is level."
)
LOOKS = {"A": ORANGE, "B": BLUE, "W": GREEN}


def compute(sweeps):
    """D(t) of each species and of the triblock."""
    runs = sweeps["triblock"].isel(replica=0)
    species = [str(name) for name in runs.species.values.ravel()][: runs.sizes["species"]]
    constant = {"units": "r_c^2 / tau"}
    return xr.Dataset(
        {
            "beads": (("time", "species"), runs.diffusion_bead.values, constant),
            "chains": ("time", runs.diffusion_molecule.values[:, 0], constant),
        },
        {
            "time": ("time", runs.diffusion_time.values.ravel(), {"units": "tau"}),
            "species": species,
        },
    )


def last(data):
    """Each coefficient over the last tenth of the run."""
    part = data.isel(time=slice(int(0.9 * data.sizes["time"]), None)).mean("time")
    found = {str(name): float(part.beads.sel(species=name)) for name in data.species.values}
    return found | {"triblock": float(part.chains)}


def describe(data):
    """What is seen."""
    each = ", ".join(f"{name} {value:.3f}" for name, value in last(data).items())
    return (
        "Diffusion coefficients over time on logarithmic axes: that of W rises for about 1 tau, "
        "while beads still fly at thermal speed, and then stays; those of A and B fall to that of "
        f"the chains, whose own first rises and then falls. Last: {each}."
    )


def draw(data):
    """D(t) on logarithmic axes."""
    figure, axes = panels(1)
    for name in data.species.values:
        axes.plot(data.time, data.beads.sel(species=name), color=LOOKS[str(name)], label=str(name))
    axes.plot(data.time, data.chains, color=BLACK, linestyle="--", label="triblock, centre")
    low = float(np.nanmin(data.chains))
    axes.set(xscale="log", yscale="log", xlabel=r"time $t$ / $\tau$", ylim=(0.25 * low, None),
             ylabel=r"$D(t)$ / ($r_c^2$ $\tau^{-1}$)")  # fmt: skip
    axes.legend(loc="lower left", ncols=2)
    return figure
