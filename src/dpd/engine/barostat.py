"""How a system at constant pressure changes its box, between calls of the compiled loop.

`dpd.physics.pressure` says what volume is tried and whether it counts. Trials belong to steps,
every so many of them, not to calls: however a run is cut into calls, it has the same bits.
"""

import math
from dataclasses import replace
from typing import Any

import numpy as np

from dpd.engine.neighbours import CUTOFF
from dpd.engine.space import wrapped
from dpd.engine.state import CONSERVATIVE, State, Sums, System
from dpd.errors import UserError
from dpd.physics.pressure import Look, Pressure, draw

Box = tuple[float, ...]
MOST_TIMES = 10.0  # larger or smaller than the box of the system a box may become


def sample_rescaling(
    simulation: Any, law: Pressure, steps: int, at: np.ndarray, measure: bool
) -> Sums:
    """Advance a `Simulation` as its `sample` does; samples after a trial are of the new box."""
    parts, last = [], simulation.state.step + steps
    while simulation.state.step < last:
        step = simulation.state.step
        trial = step + law.every - step % law.every
        end, inside = min(last, trial), at[(step < at) & (at <= trial)]
        if trial > last:
            parts.append(simulation.sample_in_box(end - step, inside, measure))
            break
        before = inside[inside < trial]
        found = simulation.sample_in_box(end - step, np.append(before, trial), True)
        parts.append(found.of(slice(len(before))))
        after = rescale(simulation, law, found.of(slice(-1, None)))
        if trial in inside:
            parts.append(after)
    return Sums.joined(parts)


def rescale(simulation: Any, law: Pressure, sums: Sums) -> Sums:
    """Try another volume from one sample of where the beads are; return that of where they end."""
    system, before, box = simulation.system, simulation.state, simulation.box
    law = law.at(before.step, box)
    kT, h = system.kT, law.every * system.dt
    normal, chance = draw(system.seed, before.step)
    here = look_at(system, law, before, box, sums.of(-1))
    volume = law.trial(here, kT, h, normal)
    scaled = scaled_box(box, law.axes, volume / here.volume)
    refuse_box(law, system, scaled, before.step)
    simulation.state = scaled_state(system, before, box, scaled)
    moved = simulation.call(0, [before.step], measure=True)
    there = look_at(system, law, simulation.state, scaled, moved.of(-1))
    if math.log(chance) < -law.change(here, there, kT, h):
        return moved
    simulation.state = before
    return sums


def look_at(system: System, law: Pressure, state: State, box: Box, sums: Sums) -> Look:
    """What the law of constant pressure asks of a state.

    Where momentum is conserved, velocities are those about the centre of mass, and N places come
    with N - 1 momenta along each axis, which would leave a factor 1 / V in the density of volumes;
    -kT ln V in the energy, and kT / V in the pressure, take it out.
    """
    axes, volume = list(law.axes), math.prod(box)
    # How an array lies in memory decides last bits.
    velocity = np.ascontiguousarray(state.velocity - drift(system, state))
    momenta = np.ascontiguousarray(system.momenta(replace(state, velocity=velocity)))
    kinetic = (velocity * momenta).sum(axis=1)
    virial = np.diagonal(sums.virial[CONSERVATIVE])
    pressure = float((kinetic + virial)[axes].mean()) / volume
    energy = 0.5 * float(kinetic.sum()) + float(sums.energy.sum())
    if not _in_bath(system):
        pressure += system.kT / volume
        energy -= system.kT * math.log(volume)
    return Look(volume, pressure, energy)


def _in_bath(system):
    return system.per_bead and np.any(system.friction)


def drift(system: System, state: State) -> np.ndarray:
    """(dimension, 1) array: the velocity of the centre of mass; 0 where a bath brakes it."""
    if _in_bath(system):
        return np.zeros((len(state.velocity), 1))
    momenta = np.ascontiguousarray(system.momenta(state))
    mass = np.broadcast_to(system.mass_of(state.species), momenta.shape[1:])
    return momenta.sum(axis=1, keepdims=True) / mass.sum()


def scaled_box(box: Box, axes: tuple[int, ...], times: float) -> Box:
    factor = times ** (1 / len(axes))
    return tuple(edge * factor if axis in axes else edge for axis, edge in enumerate(box))


def scaled_state(system: System, state: State, box: Box, scaled: Box) -> State:
    """Beads moved with the box, momenta the other way; forces are yet to be evaluated."""
    factor = (np.array(scaled) / np.array(box))[:, None]
    together = drift(system, state)
    position, further = wrapped(state.position * factor, scaled)
    return replace(
        state,
        position=position,
        image=state.image + state.by_identity(further),
        velocity=together + (state.velocity - together) / factor,
        force=None,
        reference=None,
        box=scaled,
    )


def refuse_box(law: Pressure, system: System, box: Box, step: int) -> None:
    """Refuse a box that no longer fits the forces, or is far from that of the system."""
    times, least = math.prod(box) / system.volume, 2 * (CUTOFF + system.skin)
    if min(box) < least or not 1 / MOST_TIMES <= times <= MOST_TIMES:
        edges = " x ".join(f"{edge:.4g}" for edge in box)
        wrong, other = ("low", "higher") if times > 1 else ("high", "lower")
        tension = f", or pressure.tension {law.tension:g} too large" if law.tension else ""
        raise UserError(
            f"at step {step} the box is {edges} r_c (limits: edges of {least:g}, and a tenth to "
            f"ten times the volume of the scene's): pressure.target {law.target:g} is too {wrong} "
            f"for it{tension}; take a {other} one, or another number of beads to begin with"
        )
