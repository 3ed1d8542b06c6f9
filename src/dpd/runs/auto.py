"""``integrator: {scheme: auto}``: try a step on the scene itself before anything is promised.

`dpd.physics.common.automatic` proposes a scheme and a step from what was measured for a fluid and
a melt. Here the scene runs for a while with that step and with half of it. The step is taken if kT,
and the pressure, are then within the tolerance with confidence; otherwise it is made shorter. The
same scene and sources lead to the same choice.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from dpd.analysis.statistics import correlation_time, mean_and_error
from dpd.digest import value_digest
from dpd.engine.loop import advance_looking
from dpd.engine.queries.pairs import pair_histogram
from dpd.engine.simulation import Simulation, Unstable
from dpd.engine.state import CONSERVATIVE, State
from dpd.errors import UserError
from dpd.observe.common.thermal import ThermalMotion
from dpd.scene.scene import Scene
from dpd.stages import run_sources
from dpd.start.common.make import system_of, thermal_velocities

if TYPE_CHECKING:
    from collections.abc import Callable

SURE = 3.0  # standard errors: all looks together are right with 95 % confidence or more
SHRINK = 0.4, 0.8  # of the step, the least and the most from one try to the next
SHORTEST = 0.02  # of the proposed step, below which no try is made
LEAST_WORK = 1e8  # bead-steps that the tries may take, some seconds; or SHARE of the run, if more
SHARE = 0.1
SAMPLE = 0.1  # tau between samples
SETTLING = 3.0  # thermostat times that are left out of what is measured
LENGTH = 20.0  # correlation times, and thermostat times, below which errors are not known
ROUNDS, PAUSE = 20, 0.5  # of new velocities for the start, and tau between them
BINS = 200  # of a histogram of distances


class Bounds(NamedTuple):
    """Relative errors of kT and pressure, as found, and how far that may be off."""

    kT: float
    kT_unsure: float
    pressure: float
    pressure_unsure: float

    def most(self) -> float:
        """The largest error that is not ruled out."""
        return max(self.kT + self.kT_unsure, self.pressure + self.pressure_unsure)

    def beyond(self, tolerance: float) -> bool:
        """Whether one is beyond it for sure, or so near that a shorter step is found sooner."""
        return any(
            found - unsure > tolerance or (found > tolerance / 2 and unsure < tolerance / 2)
            for found, unsure in (self[:2], self[2:])
        )


UNKNOWN = Bounds(0.0, np.inf, 0.0, np.inf)


class Probe:
    """A scene in motion with a step of its own, and the kT and excess pressure of its samples."""

    def __init__(
        self, scene: Scene, state: State, dt: float, look: Callable[[], object] = bool
    ) -> None:
        self._simulation, self._look, self.dt = _simulation(scene, state, dt), look, dt
        self._thermal = ThermalMotion(scene, self._simulation.system)
        self._every = max(1, round(SAMPLE / dt))
        self.kT: list[float] = []
        self.excess: list[float] = []

    def run(self, time: float) -> None:
        """Go on for a time in tau."""
        simulation = self._simulation
        d = simulation.system.dimension
        for _ in range(max(1, round(time / (self.dt * self._every)))):
            self._look()
            if self._every > 1:
                advance_looking(simulation, self._every - 1, self._look)
            sums = simulation.sample(1, [simulation.state.step + 1], measure=True)
            kinetic, virial = self._thermal.kinetic(sums)[0], sums.virial[0, CONSERVATIVE]
            self.kT.append(float(np.trace(kinetic) / (d * sums.beads.sum())))
            self.excess.append(float(np.trace(virial) / (d * simulation.volume)))

    def means(self, settling: float) -> list[tuple[float, float]]:
        """(mean, error) of kT and excess pressure after a time to settle; inf if not known."""
        first, found = round(settling / (self.dt * self._every)), []
        for series in (np.array(self.kT)[first:], np.array(self.excess)[first:]):
            mean, error, _ = mean_and_error(series)
            known = len(series) >= LENGTH * correlation_time(series)
            found.append((mean, error if known else np.inf))
        return found


def _simulation(scene, state, dt):
    """A copy of a state in motion, with a step of its own and at constant volume."""
    system = replace(system_of(scene), dt=dt, skin=scene.skin_at(dt), pressure=None)
    species = None if state.species is None else state.species.copy()
    beads = state.position.copy(), state.velocity.copy(), None, state.identity.copy(), species
    return Simulation(system, State(*beads, 0, box=state.box))


def thermostat_time(scene: Scene, pushes: float) -> float:
    """Time in tau in which the thermostat corrects kT: d / (4 gamma <sum of w^2> per bead).

    Friction takes 2 gamma w^2 kT from each pair (Groot and Warren 1997, Eq. 4), of a kinetic
    energy of d kT / 2 for each bead; the rest of the energy follows that of motion. With masses it
    takes gamma w^2 kT / mu, with the reduced mass mu. If species differ, gamma / (2 mu) is the mean
    over pairs of beads. ``pushes`` is the sum of w^2 over all pairs, per bead.
    """
    share = np.bincount(scene.kinds, minlength=len(scene.species)) / scene.beads
    inverse = 1 / (np.ones(len(share)) if scene.masses is None else scene.masses)
    rate = scene.friction * (inverse[:, None] + inverse) / 2
    return scene.dimension / (4 * float(share @ rate @ share) * max(pushes, 1e-9))


def settle(scene: Scene, state: State, look: Callable[[], object] = bool) -> Scene:
    """The scene with a scheme and a step that were tried on it; itself if it names its scheme.

    Its ``chosen`` holds the ``integrator``, what was ``said`` of it, and the digest of what was
    ``asked``. The ``state`` at its start is left as it is. ``look`` is called several times a
    second and may raise something to end the search. Raises `UserError` if no step could be shown
    to be good within the work that the search may take.
    """
    if not scene.is_auto:
        return scene
    budget, tolerance = max(LEAST_WORK, SHARE * scene.work), scene.terms["integrator"].tolerance
    proposed = dt = scene.dt
    state, pushes, spent = _at_rest(scene, state, proposed / 4, budget, look)
    memory = thermostat_time(scene, pushes)
    while dt >= SHORTEST * proposed and spent < budget:
        bounds, cost = _tried(scene, state, dt, memory, budget - spent, look)
        spent += cost
        if bounds.most() <= tolerance:
            return _chosen(scene, dt, bounds)
        shorter = np.sqrt(tolerance / 2 / max(bounds.kT, bounds.pressure, 1e-9))
        dt = float(f"{dt * np.clip(shorter, *SHRINK):.2g}")
    raise UserError(
        f"{scene.where}: integrator.tolerance: 'auto' tried steps from {proposed:g} tau down for "
        f"{spent:.2g} bead-steps (it may take {budget:.2g}; the thermostat needs {memory:.2g} tau "
        f"to correct kT) and could not show that kT and pressure are within {tolerance:g}; take a "
        "larger tolerance, let the run be longer, or name scheme and dt"
    )


def _at_rest(scene, state, dt, budget=np.inf, look=bool):
    """The start at its temperature, the sum of w^2 per bead, and the bead-steps that it took.

    Its velocities are drawn anew again and again, which brings any system to its temperature,
    however rarely its beads meet.
    """
    steps = max(1, round(PAUSE / dt))
    cost = ROUNDS * steps * scene.beads
    if cost > budget:
        raise UserError(
            f"{scene.where}: integrator.scheme: 'auto' cannot choose here: to bring the start to "
            f"its temperature in steps of {dt:.2g} tau would take {cost:.2g} bead-steps, and the "
            f"search may take {budget:.2g}; name scheme and dt, or let the run be longer"
        )
    kT, rng = scene.data["thermostat"]["kT"], np.random.default_rng(scene.data["seed"])
    simulation, pushes = _simulation(scene, state, dt), []
    w = 1 - (np.arange(BINS) + 0.5) / BINS
    try:
        for _ in range(ROUNDS):
            look()
            now = simulation.state
            mass = simulation.system.mass_of(now.species)
            now.velocity[...] = thermal_velocities(now.velocity.shape, kT, rng, mass)
            advance_looking(simulation, steps, look)
            pairs = pair_histogram(simulation.state.position, simulation.box, 1.0, BINS)
            pushes.append(float(pairs @ w**2) / scene.beads)
    except Unstable:  # overlaps: more gently
        return _at_rest(scene, state, dt / 4, budget, look)
    return simulation.state, np.mean(pushes[ROUNDS // 2 :]), cost


def _tried(scene, state, dt, memory, budget, look):
    """`Bounds` of a step, as good as a budget in bead-steps allows, and the bead-steps taken."""
    tolerance, settling = scene.terms["integrator"].tolerance, SETTLING * memory
    whole, half = (Probe(scene, state, step, look) for step in (dt, dt / 2))
    bounds, spent, half_too = UNKNOWN, 0.0, True
    time = settling + max(100 * SAMPLE, LENGTH * memory)
    while bounds.most() > tolerance and not bounds.beyond(tolerance):
        cost = time / dt * scene.beads * (3 if half_too else 1)
        if spent + cost > budget:
            return bounds, budget  # a shorter step would tell even less
        spent += cost
        try:
            whole.run(time)
            if half_too:
                half.run(time)
        except Unstable:
            return UNKNOWN._replace(kT=np.inf), spent
        bounds = _bounds(scene, whole.means(settling), half.means(settling))
        known = bounds.pressure_unsure < bounds.kT_unsure + tolerance / 4
        half_too = not known or np.isinf(bounds.pressure_unsure)
        time = len(whole.kT) * SAMPLE  # twice as long in all
    return bounds, spent


def _bounds(scene, whole, half):
    """What both say of the longer step.

    A scheme of first order is twice as far from the limit as from half the step; one of second
    order is nearer.
    """
    asked = scene.data["thermostat"]["kT"]
    (kT, kT_error), (excess, error) = whole
    _, (excess_half, error_half) = half
    found, unsure = abs(kT / asked - 1), SURE * kT_error / asked
    ideal = scene.density * asked
    pressure = max(abs(ideal + excess), ideal)
    share = ideal / pressure
    off = 2 * abs(excess - excess_half) / pressure
    off_unsure = 2 * SURE * np.hypot(error, error_half) / pressure
    return Bounds(found, unsure, off + share * found, off_unsure + share * unsure)


def _chosen(scene, dt, bounds):
    """The scene with a step that was found to be good."""
    guess, tolerance = scene.terms["integrator"].named, scene.terms["integrator"].tolerance
    kT, pressure = (100 * sum(each) for each in (bounds[:2], bounds[2:]))
    said = (
        f"integrator: auto is {guess.scheme}, dt {dt:g}: tried on this scene with this "
        f"step and half of it, kT is within {kT:.2g} % and the pressure within {pressure:.2g} % "
        f"(95 % confidence; asked for: {100 * tolerance:g} %)"
    )
    integrator = {"scheme": guess.scheme, "lambda": guess.lambda_, "dt": dt}
    return _with_choice(scene, {"asked": _asked(scene), "integrator": integrator, "said": said})


def _asked(scene):
    return value_digest([scene.digest, run_sources(scene)])


def settled_before(scene: Scene, choice: object) -> Scene | None:
    """The scene with the ``chosen`` of an earlier `settle` of the same scene and sources."""
    if not isinstance(choice, dict) or choice.get("asked") != _asked(scene):
        return None
    return _with_choice(scene, choice)


def _with_choice(scene, choice):
    settled = Scene(scene.data | {"integrator": choice["integrator"]}, scene.where)
    settled.chosen = choice
    return settled
