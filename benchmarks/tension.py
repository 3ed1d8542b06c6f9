"""Surface tension and the profile of the pressure of this engine and of LAMMPS."""

from __future__ import annotations

import numpy as np

from benchmarks.systems import WORKLOADS, workload
from benchmarks.timing import labelled, simulation_of, starts_of
from dpd.lammps.engine import Lammps
from dpd.observe.common.accumulators import BLOCKS
from dpd.observe.common.measured import Measured
from dpd.observe.stress_profile import StressProfile
from dpd.scene.scene import Scene
from dpd.start.common.make import system_of

SLABS = "W4"  # the workload: slabs, 8 x 8 x 20, a_AB 37
WIDTH = 0.5  # r_c, of a slice
EVERY = 5  # steps between samples
DIRECTIONS = ("normal", "tangential")


def normal_and_tangential(profile):
    """(..., 2, slices) array of (..., 3, slices): zz, and the mean of xx and yy."""
    return np.stack([profile[..., 2, :], profile[..., :2, :].mean(axis=-2)], axis=-2)


def tension_beside_lammps(scene=None, settling=5000, samples=6000, say=print):
    """Profiles of normal and tangential pressure of both codes, going on from one state.

    ``normal`` and ``tangential`` over code, block and slice.

    Parameters
    ----------
    scene : Scene
        Slabs along z; if not given, the workload `SLABS`.
    settling : int
        Steps of this engine before both codes begin.
    samples : int
        `EVERY` steps apart, at least `BLOCKS`.
    say : callable
    """
    scene = scene or workload(SLABS)
    watch = {"steps": {"sample": samples}, "observe": [{"stress_profile": {"bin": WIDTH}}]}
    scene = Scene(scene.data | watch, scene.where)
    own = simulation_of(scene, starts_of({"slabs": scene}, say)["slabs"])
    say(f"slabs: {settling} steps")
    own.advance(settling)
    begin = own.state
    say("slabs: profiles of this engine")
    found = [own_profile(scene, begin, samples)]
    say("slabs: profiles of LAMMPS")
    found.append(lammps_profile(scene, begin, samples))
    both, slices = np.array(found), found[0].shape[-1]
    along, unit = ("code", "block", "slice"), "kT / r_c^3"
    place = (np.arange(slices) + 0.5) * (scene.box[2] / slices)
    return labelled(
        {
            "code": (("code",), ["own", "lammps"], "1", "code"),
            "slice": (("slice",), place, "r_c", "position along z"),
            "normal": (along, both[:, :, 0], unit, "pressure along z"),
            "tangential": (along, both[:, :, 1], unit, "pressure across z"),
        },
        f"{WORKLOADS[SLABS].system}; after {settling} steps both codes go on from one state, "
        f"{samples} samples each, {EVERY} steps apart, in {BLOCKS} blocks.",
    )


def own_profile(scene, begin, samples):
    """(block, 2, slices) array: normal and tangential pressure by this engine."""
    own = simulation_of(scene, begin)
    observed = Measured(StressProfile(every=1, bin=WIDTH), scene, own.system)
    for _ in range(samples):
        own.advance(EVERY)
        observed.sample(own)
    found = observed.variables()
    return np.stack([found[f"{name}_pressure_profile"][1] for name in DIRECTIONS], axis=1)


def lammps_profile(scene, begin, samples):
    """The same by LAMMPS, whose compute shares out pairs along the same straight lines."""
    other, taken = Lammps(scene, system_of(scene), begin), []
    other.go(1)
    other.ranks("command", f"compute profile all stress/cartesian z {WIDTH} NULL 0")
    other.ranks("command", "run 0 post no")
    per_freedom = scene.beads / (scene.beads - 1)  # as ours counts, see ThermalMotion
    for _ in range(samples):
        other.go(EVERY)
        columns = other.ranks("numpy.extract_compute", "profile", 0, 2).T
        kinetic, virial = columns[2:8].reshape(2, 3, -1)  # of xx, yy and zz in each slice
        taken.append(normal_and_tangential(per_freedom * kinetic + virial))
    return np.array([part.mean(axis=0) for part in np.array_split(taken, BLOCKS)])
