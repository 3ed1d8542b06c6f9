"""This engine and LAMMPS side by side: how fast, and whether they find the same physics."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from dpd.benchmark.lammps import Lammps
from dpd.benchmark.speed import SCHEME, installed, race
from dpd.benchmark.timing import TURNS, labelled, simulation_of, starts_of
from dpd.benchmark.workloads import MEMORY, WORKLOADS, workload
from dpd.engine.simulation import Snapshot
from dpd.engine.space import wrapped
from dpd.engine.state import ALL_FORCES, State
from dpd.observe import observables
from dpd.observe.common.thermal import ThermalMotion
from dpd.scene.scene import Scene
from dpd.start.common.make import system_of

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    import xarray as xr

    from dpd.engine.simulation import Simulation

SNAPSHOTS = 40  # not more than the blocks of an observable, so that each is one
REACH, BIN = 3.0, 0.02  # r_c, of g(r)
CODES = ("own", "lammps")


def beside_lammps(
    scenes: Mapping[str, Scene] | None = None, turns: int = TURNS, snapshots: int = SNAPSHOTS,
    reach: float = REACH, say: Callable[[str], None] = print,
) -> xr.Dataset:  # fmt: skip
    """Rates of both codes in turns, then snapshots of both, going on from one state.

    Parameters
    ----------
    scenes : dict of str to Scene
        Some or all of the workloads.
    turns, snapshots : int
    reach : float
        Of g(r), in r_c.
    say : callable

    Returns
    -------
    xarray.Dataset
        What LAMMPS has not done, or there is no LAMMPS for, is NaN.
    """
    scenes = scenes or {name: workload(name) for name in WORKLOADS}
    starts = starts_of(scenes, say)
    races, found = [], []
    for name, scene in scenes.items():
        say(f"{name}: speed")
        table, state = race(name, scene, starts[name], turns)
        races.append(table)
        say(f"{name}: physics")
        found.append(both_codes(name, scene, state, float(table.skin[0]), snapshots, reach))
    description = (
        f"one thread of each code, {turns} turns, the same first configuration, scheme and time "
        "step, LAMMPS with the fastest of four skins; then both go on from one state, "
        f"{snapshots} snapshots each, as far apart as kT and pressure remember."
    )
    if not installed():
        description += " LAMMPS is not installed here (optional: pip install lammps mpich)."
    return labelled(_rates(races, scenes) | _physics(found), description)


def _rates(races, scenes):
    """Variables of the races."""
    table = pd.concat(races)
    variables = {
        "workload": (("workload",), list(scenes), "1", "workload"),
        "system": (("workload",), [WORKLOADS[name].system for name in scenes], "1", "system"),
    }
    for code, label in zip(CODES, ("this engine", "LAMMPS")):
        rates = table[code].to_numpy().reshape(len(scenes), -1)
        text = f"bead-steps per second of {label}"
        variables[f"{code}_rate"] = (("workload", "turn"), rates, "1 / s", text)
    skins = [float(race.skin[0]) for race in races]
    return variables | {"skin": (("workload",), skins, "r_c", "skin of LAMMPS's list")}


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


def both_codes(
    name: str, scene: Scene, state: State, skin: float, snapshots: int, reach: float
) -> dict[str, np.ndarray]:
    """What snapshots of both codes show, going on from one state.

    They are `MEMORY` apart, so that their scatter tells the error of their mean.

    Returns
    -------
    dict of str to array
        ``r``; ``kT``, ``pressure``, ``bond`` (code, snapshot); ``rdf`` (code, snapshot, r).
    """
    every = max(1, round(MEMORY[name] / scene.dt))
    own = simulation_of(scene, state)
    found = [seen(scene, lambda: own_look(own, every), snapshots, reach)]
    if installed() and scene.data["integrator"]["scheme"] == SCHEME:
        other = Lammps(scene, state, skin)
        found.append(seen(scene, lambda: lammps_look(other, every), snapshots, reach))
        other.close()
    else:
        found.append({name: np.full_like(values, np.nan) for name, values in found[0].items()})
    both = {name: np.array([code[name] for code in found]) for name in found[0]}
    return both | {"r": found[0]["r"]}


def own_look(simulation: Simulation, every: int) -> tuple[np.ndarray, np.ndarray, float]:
    """Positions and velocities by identity, and the pressure, some steps later."""
    sums = simulation.advance_measured(every)
    state, system = simulation.state, simulation.system
    twice_kinetic = (state.velocity**2).sum()
    pressure = (twice_kinetic + np.trace(sums.virial[ALL_FORCES])) / (
        system.dimension * system.volume
    )
    return state.by_identity(state.position), state.by_identity(state.velocity), pressure


def lammps_look(code: Lammps, every: int) -> tuple[np.ndarray, np.ndarray, float]:
    """The same of LAMMPS."""
    code.advance(every)
    return (*code.configuration(), code.pressure())


def seen(
    scene: Scene, look: Callable[[], tuple[np.ndarray, np.ndarray, float]],
    snapshots: int, reach: float,
) -> dict[str, np.ndarray]:  # fmt: skip
    """Snapshots through the same eyes, whichever code they are of.

    Parameters
    ----------
    scene : Scene
    look : callable
        Without arguments: calls `own_look` or `lammps_look`.
    snapshots : int
    reach : float
        Of g(r), in r_c.

    Returns
    -------
    dict of str to array
        ``r``, ``rdf`` (snapshot, r), ``kT``, ``pressure``, ``bond`` (snapshot).
    """
    watch = ["bonds"] if scene.has_bonds else []
    changes = {
        "steps": {"sample": snapshots},
        "observe": [
            {"rdf": {"every": 1, "range": reach, "bin": BIN}},
            *({name: {"every": 1}} for name in watch),
        ],
    }
    scene = Scene(scene.data | changes, scene.where)
    system = system_of(scene)
    observers: Any = observables(scene, system)
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
    values: dict[str, np.ndarray] = {}
    for observer in observers:
        values |= {name: array for name, (_, array, _, _) in observer.variables().items()}
    none = np.full(snapshots, np.nan)
    return {
        "r": values["r"], "rdf": values["rdf"], "kT": kT, "pressure": pressure,
        "bond": values.get("bond_mean", none),
    }  # fmt: skip
