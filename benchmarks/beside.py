"""This engine and LAMMPS side by side: how fast, and whether they find the same physics."""

from __future__ import annotations

from functools import partial

import numpy as np

from benchmarks.systems import MEMORY, WORKLOADS, workload
from benchmarks.timing import (
    in_turns,
    labelled,
    on_one_core,
    seconds_of,
    simulation_of,
    starts_of,
)  # fmt: skip
from dpd.engine.simulation import Snapshot
from dpd.engine.space import wrapped
from dpd.engine.state import ALL_FORCES, State
from dpd.lammps.engine import Lammps
from dpd.observe.common.bins import ThermalMotion
from dpd.observe.common.measured import observables
from dpd.scene.scene import Scene
from dpd.start.common.make import system_of

SKINS = {3: (0.2, 0.3, 0.4, 0.5), 2: (0.1, 0.15, 0.2, 0.3)}  # r_c, sensible for LAMMPS
SCHEME = "gw-vv"  # the one that LAMMPS has
# A turn of ours is this many times as many steps, to take about as long: what disturbs the machine
# for some tenths of a second then weighs little in either.
TURNS, LONGER = 11, 4
SNAPSHOTS = 40  # not more than the blocks of an observable, so that each is one
REACH, BIN = 3.0, 0.02  # r_c, of g(r)
CODES = ("own", "lammps")


def beside_lammps(scenes=None, turns=TURNS, snapshots=SNAPSHOTS, reach=REACH, say=print):
    """Rates of both codes in turns, then snapshots of both, going on from one state.

    Parameters
    ----------
    scenes : dict of str to Scene
        Some or all of the workloads.
    turns, snapshots : int
        Without snapshots, rates alone.
    reach : float
        Of g(r), in r_c.
    say : callable

    Returns
    -------
    xarray.Dataset
        What LAMMPS has not done is NaN.
    """
    scenes = scenes or {name: workload(name) for name in WORKLOADS}
    starts = starts_of(scenes, say)
    rates, skins, found = [], [], []
    for name, scene in scenes.items():
        say(f"{name}: speed")
        with on_one_core():
            rate, skin, state = race(scene, starts[name], turns)
        rates.append(rate)
        skins.append(skin)
        if snapshots:
            say(f"{name}: physics")
            found.append(both_codes(name, scene, state, skin, snapshots, reach))
    own, lammps = np.swapaxes(rates, 0, 1)
    rate = ("workload", "turn")
    variables = {
        "workload": (("workload",), list(scenes), "1", "workload"),
        "system": (("workload",), [WORKLOADS[name].system for name in scenes], "1", "system"),
        "own_rate": (rate, own, "1 / s", "bead-steps per second of this engine"),
        "lammps_rate": (rate, lammps, "1 / s", "bead-steps per second of LAMMPS"),
        "skin": (("workload",), skins, "r_c", "skin of LAMMPS's list"),
    }
    description = (
        f"one thread of each code, {turns} turns, the same first configuration, scheme and time "
        "step, LAMMPS with the fastest of four skins; then both go on from one state, "
        f"{snapshots} snapshots each, as far apart as kT and pressure remember."
    )
    return labelled(variables | (_physics(found) if found else {}), description)


def race(scene, start, turns):
    """(2, turns) bead-steps per second of both codes, the skin of LAMMPS, our state at the end."""
    steps = scene.steps.sample
    own = simulation_of(scene, start)
    own.advance(steps)
    skin, seconds = np.nan, np.full((2, turns), np.nan)
    if compared(scene):
        skin = best_skin(scene, own.state, steps)
        other = Lammps(scene, own.system, own.state, skin=skin)
        other.go(steps)
        seconds[:] = in_turns([own.advance, other.go], [LONGER * steps, steps], turns)
    else:
        seconds[:1] = in_turns([own.advance], LONGER * steps, turns)
    return scene.beads * steps * np.array([[LONGER], [1]]) / seconds, skin, own.state


def compared(scene):
    """Whether LAMMPS has the scheme."""
    return scene.data["integrator"]["scheme"] == SCHEME


def best_skin(scene, state, steps):
    """The skin of `SKINS` with which LAMMPS is fastest."""
    found = {}
    for skin in SKINS[scene.dimension]:
        code = Lammps(scene, system_of(scene), state, skin=skin)
        code.go(steps // 2)
        found[skin] = seconds_of(code.go, steps)
    return min(found, key=found.__getitem__)


def _physics(found):
    """Variables of the snapshots."""
    along = ("workload", "code", "snapshot")
    units = {
        "kT": ("kT", "kinetic temperature"),
        "pressure": ("kT / r_c^dimension", "pressure, virial of all forces"),
        "bond": ("r_c", "mean bond length"),
        "rdf": ("1", "radial distribution function g(r)"),
    }
    variables = {
        "code": (("code",), list(CODES), "1", "code"),
        "r": (("r",), found[0]["r"], "r_c", "distance"),
    }
    for name, (unit, long_name) in units.items():
        values = np.array([codes[name] for codes in found])
        variables[name] = ((*along, "r")[: values.ndim], values, unit, long_name)
    return variables


def both_codes(name, scene, state, skin, snapshots, reach):
    """What snapshots of both codes show, `MEMORY` apart: ``rdf``, ``kT``... (code, snapshot)."""
    every = max(1, round(MEMORY[name] / scene.dt))
    codes = [simulation_of(scene, state)]
    codes += [Lammps(scene, system_of(scene), state, skin=skin)] if compared(scene) else []
    found = [seen(scene, partial(look, each, every), snapshots, reach) for each in codes]
    if len(codes) == 1:
        found.append({name: np.full_like(values, np.nan) for name, values in found[0].items()})
    both = {name: np.array([code[name] for code in found]) for name in found[0]}
    return both | {"r": found[0]["r"]}


def look(simulation, every):
    """Positions and velocities by identity, and the pressure, some steps later."""
    sums = simulation.advance_measured(every)
    state, system = simulation.state, simulation.system
    twice_kinetic = (state.velocity**2).sum()
    pressure = (twice_kinetic + np.trace(sums.virial[0, ALL_FORCES])) / (
        system.dimension * system.volume
    )
    return state.by_identity(state.position), state.by_identity(state.velocity), pressure


def seen(scene, look, snapshots, reach):
    """Snapshots through the same eyes, whichever code they are of.

    Parameters
    ----------
    scene : Scene
    look : callable
        Returns positions, velocities and the pressure, some steps later.
    snapshots : int
    reach : float
        Of g(r), in r_c.

    Returns
    -------
    dict of str to array
        ``r``, ``rdf`` (snapshot, r), ``kT``, ``pressure``, ``bond`` (snapshot).
    """
    watch = [{"rdf": {"every": 1, "range": reach, "bin": BIN}}]
    watch += [{"bonds": {"every": 1}}] * scene.has_bonds
    scene = Scene(scene.data | {"steps": {"sample": snapshots}, "observe": watch}, scene.where)
    system = system_of(scene)
    observers = observables(scene, system)
    thermal = ThermalMotion(scene, system)
    kT, pressure = np.empty((2, snapshots))
    identity = np.arange(scene.beads, dtype=np.uint32)
    for k in range(snapshots):
        position, velocity, pressure[k] = look()
        position = np.ascontiguousarray(wrapped(position, scene.box)[0])
        # Observables of positions and velocities need neither forces nor a simulation.
        now = Snapshot(system, State(position, velocity, None, identity, None, k))
        kT[k] = np.mean(system.mass_of(None) * thermal.velocities(now) ** 2)
        for observer in observers:
            observer.sample(now)
    values = {}
    for observer in observers:
        values |= {name: array for name, (_, array, _, _) in observer.variables().items()}
    return {
        "r": values["r"], "rdf": values["rdf"], "kT": kT, "pressure": pressure,
        "bond": values.get("bond_mean", np.full(snapshots, np.nan)),
    }  # fmt: skip
