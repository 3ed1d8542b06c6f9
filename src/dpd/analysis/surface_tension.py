"""Surface tension of two slabs in a periodic box.

Across a flat interface the pressure normal to it, p_N, is the same everywhere, and the tangential
one, p_T, is smaller where the interface is. The tension is what is missing (Groot and Warren 1997,
Eq. 31; Irving and Kirkwood 1950):

    sigma  =  integral of p_N(z) - p_T(z) over one interface
           =  L (p_N - p_T) / 2,    p the pressure tensor of a box of length L with two interfaces

Forces are the conservative ones, and p holds the kinetic part. The two ways must agree, to rounding
where they look at the same samples; and p_N - p_T must vanish in both bulks.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from dpd.analysis.interfaces import CLEAR, composition, interface_width, slabs
from dpd.analysis.statistics import mean_and_error
from dpd.analysis.viscosity import Measured
from dpd.errors import UserError
from dpd.scene.scene import Scene

if TYPE_CHECKING:
    import xarray as xr

    from dpd.analysis.interfaces import Composition

INTERFACES = 2  # of two slabs in a periodic box
SHARE = 0.8  # of the way to the middle of a slab, at which its bulk begins in a short box
AXES = "xyz"


class Bulks(NamedTuple):
    """p_N - p_T in the middle of both slabs, in kT / r_c^dimension: 0 in a fluid in equilibrium."""

    first: Measured
    second: Measured


class SlabTension(NamedTuple):
    """What a run of two slabs says of their interfaces."""

    of_profile: Measured  # tension, in kT / r_c^(dimension - 1)
    of_tensor: Measured | None  # the same from the pressure tensor of ``thermo``, if measured
    bulks: Bulks
    width: Measured  # xi in r_c, see `dpd.analysis.interfaces.interface_width`
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


def tension_of_tensor(run: xr.Dataset, settled: float = 0.0, axis: str | None = None) -> Measured:
    """Tension from the pressure tensor of the box, in kT / r_c^(dimension - 1).

    ``run``: as from `dpd.run` or `dpd.load`, with the observable ``thermo`` and pressures.
    ``settled``: time in tau that is left out at the beginning. ``axis``: normal to the interfaces;
    if not given, that of the observed ``stress_profile``, or the longest one. Raises `UserError` if
    there are walls, which have a tension of their own, or no tensor was measured.
    """
    scene = _scene_of(run)
    if "pressure_tensor" not in run:
        raise UserError(
            "no pressure tensor was measured: observe 'thermo', without 'pressure: false'"
        )
    normal = _axis_of(scene, axis)
    diagonal = np.diagonal(run.pressure_tensor.values, axis1=1, axis2=2)
    tangential = np.delete(diagonal, normal, axis=1).mean(axis=1)
    series = _edge(run, scene, normal) * (diagonal[:, normal] - tangential) / INTERFACES
    return _measured(series[run.time.values > settled])


def tension_of_profile(run: xr.Dataset) -> Measured:
    """Tension as the integral of the profile of p_N - p_T, over both interfaces, halved.

    In kT / r_c^(dimension - 1), of a run with ``stress_profile``. Raises `UserError` if there are
    walls, which have a tension of their own, or no profile was measured.
    """
    _scene_of(run)
    return _measured(_missing(run).mean(axis=1) * _length(run, "slice") / INTERFACES)


def bulks(run: xr.Dataset) -> Bulks:
    """p_N - p_T in both bulks: by how much it misses 0, with its error; first in the lower half.

    A bulk is what is more than `dpd.analysis.interfaces.CLEAR` away from both interfaces, or, in a
    box that has no such place, a fifth of each slab.

    ``run``: with ``stress_profile`` and ``profile`` along the same axis, of two species in slabs.
    Raises `UserError` if one of these is missing, or there are walls or more than two species.
    """
    return _bulks(run, _slabs_of(run))


def slab_tension(run: xr.Dataset) -> SlabTension:
    """All that a run of two slabs says of their interfaces; run and errors as of `bulks`."""
    seen, scene = _slabs_of(run), _scene_of(run)
    slice_volume = scene.volume / run.sizes["z"]
    return SlabTension(
        tension_of_profile(run),
        tension_of_tensor(run) if "pressure_tensor" in run else None,
        _bulks(run, seen),
        Measured(*interface_width(seen)),
        composition(seen, slice_volume),
    )


def _slabs_of(run):
    """Densities as seen from the interfaces."""
    scene = _scene_of(run)
    if _observed_axis(scene, "profile") != _observed_axis(scene, "stress_profile"):
        raise UserError(
            "'profile' and 'stress_profile' were measured along different axes; give both the "
            "axis normal to the interfaces"
        )
    if len(scene.species) != 2:
        raise UserError(f"{len(scene.species)} species; where slabs begin and end is known for two")
    return slabs(run.density_profile.values, run.z.values, _length(run, "z"))


def _bulks(run, seen):
    length, place = _length(run, "slice"), run.slice.values
    clear = min(CLEAR, SHARE * length / 4)
    first, second = seen.position.mean(axis=0)
    from_interfaces = [
        np.abs((place - at + length / 2) % length - length / 2) for at in (first, second)
    ]
    clear_of_both = np.min(from_interfaces, axis=0) >= clear
    lower = (place - first) % length < (second - first) % length
    missing = _missing(run)
    return Bulks(*(
        _measured(missing[:, clear_of_both & side].mean(axis=1)) for side in (lower, ~lower)
    ))  # fmt: skip


def _missing(run):
    """(block, slice) array: p_N - p_T."""
    if "normal_pressure_profile" not in run:
        raise UserError("no profile of pressures was measured: observe 'stress_profile'")
    return run.normal_pressure_profile.values - run.tangential_pressure_profile.values


def _length(run, name):
    """Of the box along the slices of a profile, whose middles begin half a slice from 0."""
    middles = run[name].values
    return float(middles[0] + middles[-1])


def _scene_of(run):
    """The scene of a run, which must not have walls."""
    scene = Scene.of_result(str(run.attrs["scene"]), "run")
    if scene.ended:
        raise UserError("the tension of walls would be measured too; take a run without walls")
    return scene


def _axis_of(scene, name):
    if name is None and "stress_profile" in scene.observe:
        name = scene.observe["stress_profile"].axis
    return scene.axis_of_profile(name)


def _observed_axis(scene, name):
    if name not in scene.observe:
        raise UserError(f"the run did not observe {name!r}, which tells where the interfaces are")
    return scene.axis_of_profile(scene.observe[name].axis)


def _edge(run, scene, axis):
    """Edge of the box along an axis: of each sample, where the box is stretched."""
    edge = scene.box[axis]
    if "volume" not in run:
        return edge
    stretched, ratio = scene.data["pressure"]["axes"], run.volume.values / scene.volume
    if stretched == "all":
        return edge * ratio ** (1 / scene.dimension)
    return edge * ratio if AXES.index(stretched) == axis else edge


def _measured(series):
    mean, error, _ = mean_and_error(series)
    return Measured(mean, error)
