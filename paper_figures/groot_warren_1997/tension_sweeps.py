"""Surface tension at each point of a sweep of slabs."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from dpd.analysis.collect import first_scene
from dpd.analysis.statistics import over_replicas
from paper_figures.groot_warren_1997.slab_tension import slab_tension

if TYPE_CHECKING:
    from collections.abc import Iterator

    from paper_figures.groot_warren_1997.slab_tension import SlabTension

TENSION = "kT / r_c^2"
VARIABLES = {
    "tension": (TENSION, "surface tension"),
    "tension_error": (TENSION, "standard error"),
    "bulk": ("kT / r_c^3", "p_N - p_T in the bulk of both slabs"),
    "bulk_error": ("kT / r_c^3", "standard error"),
    "drift": ("1", "change of the composition between halves in standard errors"),
    "settled": ("1", "whether the composition stayed"),
    "width": ("r_c", "width of the interfaces"),
    "width_error": ("r_c", "standard error"),
    "density": ("1 / r_c^3", "number density"),
    "excess_repulsion": ("kT / r_c", "a_AB - a_AA"),
    "beads": ("1", "beads N of a chain"),
}

# What variables that are used begin with: choosing runs costs for each there is.
USED = ("scene", "density_profile", "normal_pressure", "tangential_pressure", "pressure_tensor")


def sweep_tension(sweep: xr.Dataset) -> xr.Dataset:
    """Tension of every point of a sweep of slabs, replicas taken together.

    ``sweep``: collected runs of two species in slabs, with the observables ``profile`` and
    ``stress_profile``. Where the sweep keeps the series ``pressure_tensor``, the tension is that of
    the tensor of the box, else that of the profile. Result: the names of `VARIABLES` over all axes
    but ``replica``; ``settled`` is 1 or 0, see `SlabTension`. Raises `UserError` as `slab_tension`.
    """
    axes = [str(name) for name in sweep.scene.dims if name != "replica"]
    shape = [sweep.sizes[name] for name in axes]
    sweep = one_run(sweep[[name for name in sweep.data_vars if str(name).startswith(USED)]])
    rows = [_of_point(sweep.isel(dict(zip(axes, at)))) for at in np.ndindex(*shape)]
    variables = {
        name: (axes, np.reshape([row[name] for row in rows], shape),
               {"units": unit, "long_name": long_name})
        for name, (unit, long_name) in VARIABLES.items()
    }  # fmt: skip
    return xr.Dataset(variables, {name: sweep[name] for name in axes})


def _of_point(runs):
    """What `sweep_tension` says of one point, by name."""
    scene = first_scene(runs)
    found = list(_of_replicas(runs))
    drift = max((each.composition.drift for each in found), key=abs)
    tension, error = _together([each.best for each in found])
    bulk, bulk_error = _together([part for each in found for part in each.bulks])
    width, width_error = _together([each.width for each in found])
    a, b = (scene.species.index(name) for name in "AB")
    return {
        "tension": tension,
        "tension_error": error,
        "bulk": bulk,
        "bulk_error": bulk_error,
        "drift": drift,
        "settled": float(all(each.settled for each in found)),
        "width": width,
        "width_error": width_error,
        "density": scene.beads / scene.volume,
        "excess_repulsion": scene.repulsion[a, b] - scene.repulsion[a, a],
        "beads": float(len(scene.molecules[0].beads)),
    }


def _of_replicas(runs: xr.Dataset) -> Iterator[SlabTension]:
    runs = runs.assign_attrs(scene=str(runs.scene.values[0]))
    for k in range(runs.sizes["replica"]):
        yield slab_tension(runs.isel(replica=k))


def one_run(run: xr.Dataset) -> xr.Dataset:
    """One run of a collected sweep, or several, as `slab_tension` takes it.

    Returned ``pressure_tensor`` is the series over time; it is left out where the sweep kept its
    mean alone. The scene is that of the first.
    """
    found = run.drop_vars("pressure_tensor", errors="ignore")
    if "pressure_tensor_series" in run:
        found = found.rename(pressure_tensor_series="pressure_tensor")
    return found.assign_attrs(scene=str(run.scene.values.ravel()[0]))


def _together(measured):
    """Mean of independent measurements, and its error from theirs."""
    values, errors = np.array(measured).T
    return over_replicas(values, errors, -1)
