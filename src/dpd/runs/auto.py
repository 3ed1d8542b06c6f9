"""``integrator: {scheme: auto}``: try a step on the scene itself before anything is promised.

`dpd.physics.integrator.choose` proposes it; the scene runs with it and with half of it, and it is
made shorter until kT and pressure are surely within the tolerance: the same for the same sources.
"""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from dpd.analysis.statistics import mean_and_error
from dpd.digests import run_sources, value_digest
from dpd.engine.loop import advance_looking
from dpd.engine.measure import near_beads
from dpd.engine.simulation import Simulation
from dpd.engine.state import CONSERVATIVE, State
from dpd.errors import LostRun, UserError
from dpd.observe.common.bins import ThermalMotion
from dpd.scene.scene import Scene
from dpd.start.common.make import system_of, thermal_velocities

Look = Callable[[], object]
SURE = 3.0  # standard errors: all looks together are right with 95 % confidence or more
SHRINK = 0.4, 0.8  # of the step, the least and the most from one try to the next
SHORTEST = 0.02  # of the proposed step, below which no try is made
LEAST_WORK, SHARE = 1e8, 0.1  # bead-steps that the tries may take, or of the run, if that is more
SAMPLE = 0.1  # tau between samples
SETTLING = 3.0  # thermostat times that are left out of what is measured
LENGTH = 20.0  # correlation times, and thermostat times, below which errors are not known
ROUNDS, PAUSE = 20, 0.5  # of new velocities for the start, and tau between them


class Probe:
    """A scene in motion with a step of its own, and the kT and excess pressure of its samples."""

    def __init__(self, scene: Scene, state: State, dt: float, look: Look = bool) -> None:
        self._simulation, self._look = _simulation(scene, state, dt), look
        self._thermal = ThermalMotion(scene, self._simulation.system)
        self._every = max(1, round(SAMPLE / dt))
        self.between = dt * self._every  # tau between samples
        self.kT: list[float] = []
        self.excess: list[float] = []

    def run(self, time: float) -> None:
        """Go on for a time in tau."""
        simulation = self._simulation
        d = simulation.system.dimension
        for _ in range(max(1, round(time / self.between))):
            self._look()
            advance_looking(simulation, self._every - 1, self._look)
            sums = simulation.sample(1, [simulation.state.step + 1], measure=True)
            kinetic, virial = self._thermal.kinetic(sums)[0], sums.virial[0, CONSERVATIVE]
            self.kT.append(float(np.trace(kinetic) / (d * sums.beads.sum())))
            self.excess.append(float(np.trace(virial) / (d * simulation.volume)))

    def means(self, settling: float) -> list[tuple[float, float]]:
        """(mean, error) of kT and excess pressure after a time to settle; inf if not known."""
        found = []
        for series in (self.kT, self.excess):
            settled = np.array(series[round(settling / self.between) :])
            mean, error, memory = mean_and_error(settled)
            found.append((mean, error if len(settled) >= LENGTH * memory else np.inf))
        return found


def _simulation(scene, state, dt):
    """A copy of a state in motion, with a step of its own and at constant volume."""
    system = replace(system_of(scene), dt=dt, skin=scene.skin_at(dt), pressure=None)
    species = None if state.species is None else state.species.copy()
    beads = state.position.copy(), state.velocity.copy(), None, state.identity.copy(), species
    return Simulation(system, State(*beads, 0, box=state.box))


def thermostat_time(scene: Scene, pushes: float) -> float:
    """Time in tau in which the thermostat corrects kT: d / (4 gamma ``pushes``).

    Friction takes gamma w^2 kT / mu from each pair of reduced mass mu (Groot and Warren 1997,
    Eq. 4), of a kinetic energy of d kT / 2 for each bead; if species differ, gamma / (2 mu) is the
    mean over pairs of beads. ``pushes`` is the sum of w^2 over all pairs, per bead.
    """
    share = np.bincount(scene.kinds, minlength=len(scene.species)) / scene.beads
    inverse = 1 / (np.ones(len(share)) if scene.masses is None else scene.masses)
    rate = scene.friction * (inverse[:, None] + inverse) / 2
    return scene.dimension / (4 * float(share @ rate @ share) * max(pushes, 1e-9))


def settle(scene: Scene, state: State, look: Look = bool, before: Any = None) -> Scene:
    """The scene with a scheme and a step that were tried on it; itself if it names its scheme.

    What an earlier call found, ``before``, is taken if scene and sources are the same. ``look`` is
    called several times a second, and may raise. `UserError` if no step is shown to be good.
    """
    if not scene.is_auto:
        return scene
    asked = value_digest([scene.digest, run_sources(scene)])
    found = before if before and before.get("asked") == asked else _searched(scene, state, look)
    settled = Scene(scene.data | {"integrator": found["integrator"]}, scene.where)
    settled.chosen = found | {"asked": asked}
    return settled


def _searched(scene, state, look):
    """The ``integrator`` that was found to be good, and what is ``said`` of it."""
    guess, tolerance = scene.terms["integrator"].named, scene.terms["integrator"].tolerance
    budget, spent, proposed = max(LEAST_WORK, SHARE * scene.work), 0.0, scene.dt
    state, pushes = at_rest(scene, state, proposed / 4, look)
    memory, dt = thermostat_time(scene, pushes), proposed
    while dt >= SHORTEST * proposed and spent < budget:
        off, unsure, work = _tried(scene, state, dt, memory, budget - spent, look)
        spent += work
        if max(off + unsure) <= tolerance:
            kT, pressure = 100 * (off + unsure)
            said = (
                f"integrator: auto is {guess.scheme}, dt {dt:g}: tried on this scene with this "
                f"step and half of it, kT is within {kT:.2g} % and the pressure within "
                f"{pressure:.2g} % (95 % confidence; asked for: {100 * tolerance:g} %)"
            )
            integrator = {"scheme": guess.scheme, "lambda": guess.lambda_, "dt": dt}
            return {"integrator": integrator, "said": said}
        shorter = np.sqrt(tolerance / 2 / max(*off, 1e-9))
        dt = float(f"{dt * np.clip(shorter, *SHRINK):.2g}")
    raise UserError(
        f"{scene.where}: integrator.tolerance: 'auto' tried steps from {proposed:g} tau down for "
        f"{spent:.2g} bead-steps (it may take {budget:.2g}; the thermostat needs {memory:.2g} tau "
        f"to correct kT) and could not show that kT and pressure are within {tolerance:g}; take a "
        "larger tolerance, let the run be longer, or name scheme and dt"
    )


def at_rest(scene: Scene, state: State, dt: float, look: Look = bool) -> tuple[State, float]:
    """The start after velocities drawn anew, again and again; sum of w^2 over pairs, per bead."""
    kT, rng = scene.data["thermostat"]["kT"], np.random.default_rng(scene.data["seed"])
    simulation, pushes = _simulation(scene, state, dt), []
    try:
        for _ in range(ROUNDS):
            look()
            now = simulation.state
            mass = simulation.system.mass_of(now.species)
            now.velocity[...] = thermal_velocities(now.velocity.shape, kT, rng, mass)
            advance_looking(simulation, max(1, round(PAUSE / dt)), look)
            distance = near_beads(simulation.state.position, simulation.box, 1.0)[2]
            pushes.append(float(((1 - distance) ** 2).sum()) / scene.beads)
    except LostRun:  # overlaps: more gently
        return at_rest(scene, state, dt / 4, look)
    return simulation.state, float(np.mean(pushes[ROUNDS // 2 :]))


def _tried(scene, state, dt, memory, budget, look):
    """Relative errors of kT and pressure, how unsure they are, and bead-steps, within a budget."""
    tolerance, settling = scene.terms["integrator"].tolerance, SETTLING * memory
    whole, half = (Probe(scene, state, step, look) for step in (dt, dt / 2))
    off, unsure, spent = np.zeros(2), np.full(2, np.inf), 0.0
    time = settling + max(100 * SAMPLE, LENGTH * memory)
    # Until that is within the tolerance, or surely so far off that a shorter step is found sooner.
    while max(off + unsure) > tolerance and all(off <= np.maximum(tolerance / 2, unsure)):
        work = 3 * time / dt * scene.beads
        if spent + work > budget:
            return off, unsure, budget
        spent += work
        try:
            whole.run(time)
            half.run(time)
        except LostRun:
            return np.full(2, np.inf), unsure, spent
        off, unsure = _errors(scene, whole.means(settling), half.means(settling))
        time = len(whole.kT) * SAMPLE  # twice as long in all
    return off, unsure, spent


def _errors(scene, whole, half):
    """What both say of the longer step; a scheme of first order errs half as much with half."""
    asked = scene.data["thermostat"]["kT"]
    (kT, kT_error), (excess, error) = whole
    _, (excess_half, error_half) = half
    found, unsure = abs(kT / asked - 1), SURE * kT_error / asked
    ideal = scene.density * asked
    pressure = max(abs(ideal + excess), ideal)
    off = 2 * abs(excess - excess_half) / pressure + ideal / pressure * found
    off_unsure = 2 * SURE * np.hypot(error, error_half) / pressure + ideal / pressure * unsure
    return np.array([found, off]), np.array([unsure, off_unsure])
