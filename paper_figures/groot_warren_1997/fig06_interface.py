"""Figure 6: density profile across an interface."""

import numpy as np
import xarray as xr

from dpd.analysis.collect import first_scene
from dpd.analysis.interfaces import in_bulk, slabs
from dpd.analysis.statistics import COVERAGE, block_mean_and_error
from dpd.analysis.verdicts import Measured
from dpd.report.style import BLACK, BLUE, RED, panels
from paper_figures.groot_warren_1997.shared import EVEN, mean_and_even_error

TITLE = "Density profiles across the interfaces (rho = 3, a = 25, a_AB = 37)."
PAPER_SHOWS = (
    "The paper shows rho_A, rho_B and their sum in a box of 8 x 8 x 20 and notes a small dip of "
    "the sum at the interface; a periodic box has two. Both drift while a run goes on. So each "
    "block of the run is drawn as seen from its own interfaces, which are put at z = 0 and 10."
)
ERRORS = f"Bands: 95 % intervals from blocks of the run. {EVEN}"


def compute(sweeps):
    """Profiles with errors, and the depth of the dip."""
    sweep = sweeps["interface"]
    density = sweep.density_profile.stack(part=("replica", "block"))
    density = density.transpose("part", "species", "z")
    z, length = sweep.z.values, first_scene(sweep).box[2]
    seen = slabs(density.values, z, length)
    moved = recentred(density.values, z, length, seen.position)
    mean, error = mean_and_even_error(moved)
    total, total_error = mean_and_even_error(moved.sum(axis=1))
    # The dip: within half a cutoff of either interface on both sides, against the bulk.
    every = seen.density.sum(axis=1)  # beads of both species
    at_interface = every[:, seen.distance < 0.5].mean(axis=1)
    in_the_bulk = every[:, in_bulk(seen.distance)].mean(axis=1)
    dip, dip_error = block_mean_and_error(at_interface / in_the_bulk - 1)
    units = {"units": "1 / r_c^3"}
    return xr.Dataset(
        {
            "profile": (("species", "z"), mean, units | {"long_name": "number density"}),
            "profile_error": (("species", "z"), error, units | {"long_name": "standard error"}),
            "total": ("z", total, units | {"long_name": "total number density"}),
            "total_error": ("z", total_error, units | {"long_name": "standard error"}),
            "dip": ((), float(dip), {"units": "1", "long_name": "relative change at interfaces"}),
            "dip_error": ((), float(dip_error), {"units": "1", "long_name": "standard error"}),
        },
        {"species": sweep.species, "z": sweep.z},
    )


def measured(data):
    """The dip of the total density."""
    note = (
        "mean total density within 0.5 r_c of an interface over that of the bulk, minus 1; "
        "positions of the interfaces found block by block"
    )
    return {"density_dip": Measured(float(data.dip), float(data.dip_error), note)}


def describe(data):
    """What is seen."""
    return (
        "Density of A is high in the left half of the box and low in the right one, that of B the "
        "other way round; they cross at z = 0 and 10. Their sum is flat near 3 but for "
        f"{'dips' if data.dip < 0 else 'rises'} of {100 * abs(float(data.dip)):.0f} % at both."
    )


def draw(data):
    """Profiles, the paper's axes."""
    figure, axes = panels(1)

    def band(y, error, color, label):
        reach = COVERAGE * error
        axes.fill_between(data.z, y - reach, y + reach, color=color, alpha=0.3, lw=0)
        axes.plot(data.z, y, color=color, label=label)

    for name, color in zip(data.species.values, (BLUE, RED)):
        at = data.sel(species=name)
        band(at.profile, at.profile_error, color, rf"$\rho_{name}$")
    band(data.total, data.total_error, BLACK, r"$\rho_A + \rho_B$")
    axes.set(xlim=(0, 20), ylim=(0, 3.4), xlabel="$z$ / $r_c$", ylabel=r"density $\rho$ $r_c^3$")
    figure.legend(*axes.get_legend_handles_labels(), loc="outside upper center", ncols=3)
    return figure


def recentred(
    density: np.ndarray, z: np.ndarray, length: float, position: np.ndarray
) -> np.ndarray:
    """Densities over the whole box, with both interfaces put back to where they began.

    In a window that stays in place, an interface that drifts makes the densities beside it drift,
    too slowly for an error. Seen from the interface they do not.

    ``density``, ``z``, ``length``: as for `slabs`. ``position``: (block, 2) array; of the
    interfaces, as from `interfaces`. Result: (block, 2, n) array; the quarter of the box on either
    side of 0 moved with the interface there, the other half with the one near half the box. Between
    slices densities are interpolated.
    """
    near_first = np.abs((z + length / 4) % length - length / 4) < length / 4
    moved = []
    for block, (first, second) in zip(density, position):
        place = np.where(near_first, z + first, z + second - length / 2)
        moved.append([np.interp(place, z, profile, period=length) for profile in block])
    return np.array(moved)
