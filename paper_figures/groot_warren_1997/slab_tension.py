"""The tension between two slabs, from profiles of the pressure and from the pressure tensor.

Across a flat interface the pressure normal to it, p_N, is the same everywhere, and the tangential
one, p_T, is smaller where the interface is. The tension is what is missing (Eq. 31 of the paper;
Irving and Kirkwood 1950):

    sigma  =  integral of p_N(z) - p_T(z) over one interface
           =  L (p_N - p_T) / 2,    p the pressure tensor of a box of length L with two interfaces

Forces are the conservative ones, and p holds the kinetic part.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import xarray as xr

from dpd.analysis.collect import cached_scene
from dpd.analysis.interfaces import (
    CLEAR,
    SHARE,
    Composition,
    composition,
    interface_width,
    slabs,
)
from dpd.analysis.viscosity import Measured, measured
from dpd.errors import UserError


class SlabTension(NamedTuple):
    """What a run of two slabs says of their interfaces."""

    of_profile: Measured  # tension, in kT / r_c^(dimension - 1)
    of_tensor: Measured | None  # the same from the pressure tensor of ``thermo``, if measured
    # p_N - p_T in kT / r_c^dimension in the middle of both slabs, first the lower one: 0 in a fluid
    # in equilibrium
    bulks: tuple[Measured, ...]
    width: Measured  # xi in r_c, see `interface_width`
    composition: Composition  # of the minority in the bulk

    @property
    def best(self) -> Measured:
        """The tension of the pressure tensor if there is one, else that of the profile.

        A sample of the tensor costs less than one of the profile, so it is taken more often.
        """
        return self.of_profile if self.of_tensor is None else self.of_tensor

    @property
    def settled(self) -> bool:
        """Whether both slabs and their composition stayed.

        Near the critical point slabs dissolve slowly, and their tension is that of no equilibrium.
        A run that is too short for an error of its composition has not settled either.
        """
        return self.composition.steady


def slab_tension(run: xr.Dataset) -> SlabTension:
    """All that a run of two slabs says of their interfaces.

    ``run``: as from `dpd.run` or `dpd.load`, with ``stress_profile`` and ``profile`` along the same
    axis. Raises `UserError` if one of these is missing, if there are not two species, or if there
    are walls, which have a tension of their own, or a barostat, which changes the box.
    """
    scene = cached_scene(str(run.attrs["scene"]), "run")
    if scene.ended or "pressure" in scene.data:
        raise UserError("tension: take a run without walls, which have one too, and 'pressure'")
    both = [scene.observe[name] for name in ("profile", "stress_profile") if name in scene.observe]
    if len(both) < 2 or len({scene.axis_of_profile(one.axis) for one in both}) > 1:
        raise UserError(
            "tension: observe 'profile' and 'stress_profile' along the axis across the interfaces"
        )
    if len(scene.species) != 2:
        raise UserError(f"tension: {len(scene.species)} species; where slabs end is known for two")
    began = scene.species.index(scene.molecules[0].beads[0])  # in the first half
    density = run.density_profile.values[:, [began, 1 - began]]
    seen = slabs(density, run.z.values, _length(run.z))
    missing = run.normal_pressure_profile.values - run.tangential_pressure_profile.values
    first, second = seen.position.mean(axis=0)
    place, length = run.slice.values, _length(run.slice)
    apart = [np.abs((place - at + length / 2) % length - length / 2) for at in (first, second)]
    clear = np.min(apart, axis=0) >= min(CLEAR, SHARE * length / 4)
    lower = (place - first) % length < (second - first) % length
    return SlabTension(
        measured(missing.mean(axis=1) * length / 2),
        tension_of_tensor(run) if "pressure_tensor" in run else None,
        tuple(measured(missing[:, clear & side].mean(axis=1)) for side in (lower, ~lower)),
        Measured(*interface_width(seen)),
        composition(seen),
    )


def tension_of_tensor(run: xr.Dataset) -> Measured:
    """Tension from the pressure tensor of the box, in kT / r_c^(dimension - 1).

    ``run``: as of `slab_tension`, with the observable ``thermo`` and pressures.
    """
    scene = cached_scene(str(run.attrs["scene"]), "run")
    normal = scene.axis_of_profile(scene.observe["stress_profile"].axis)
    diagonal = np.diagonal(run.pressure_tensor.values, axis1=1, axis2=2)
    tangential = np.delete(diagonal, normal, axis=1).mean(axis=1)
    return measured(scene.box[normal] * (diagonal[:, normal] - tangential) / 2)


def _length(middles):
    """Of the box along the slices of a profile, whose middles begin half a slice from 0."""
    return float(middles.values[0] + middles.values[-1])
