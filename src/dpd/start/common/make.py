"""First configurations, and the steps that relax them."""

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from dpd.engine.loop import advance_looking
from dpd.engine.simulation import Simulation
from dpd.engine.space import wrapped
from dpd.engine.state import State, System
from dpd.errors import UserError
from dpd.page import Change, PairForce
from dpd.page.own import blaming
from dpd.particles.particles import box_at, whole_images
from dpd.physics.common.forces import bond_record, with_own
from dpd.physics.integrator import scheme_named
from dpd.physics.repulsion import Soft
from dpd.scene.molecules import joined
from dpd.scene.scene import Scene
from dpd.start import start_description, start_work

FINEST = 1.0  # r_c, thickness of layers across a flow
LEAST = 10  # beads in a cell, in the mean, for each function that is fitted to their velocities
NOISE_OF_ITS_OWN = 2**63  # added to the seed, so that relaxation and run draw other numbers


def system_of(scene: Scene) -> System:
    """The engine's view of a scene."""
    thermostat, integrator = scene.data["thermostat"], scene.terms["integrator"].named
    system = System(
        box=scene.period,
        kT=scene.kT,
        friction=scene.friction,
        gaussian=thermostat["noise"] == "gaussian",
        dt=scene.dt,
        scheme=scheme_named(integrator.scheme, float(integrator.lambda_)),
        seed=scene.data["seed"],
        skin=scene.skin,
        per_bead=thermostat["kind"] == "langevin",
        masses=scene.masses,
        **_records(scene, scene.terms),
    )
    if Change.FLOWS not in scene.made:
        return system
    # Layers in whose cells a driven flow is fitted to the velocities.
    axes = scene.across
    least = LEAST * (1 + len(axes)) * math.prod(system.extent[axis] for axis in axes) / scene.beads
    thickness = max(FINEST, least ** (1 / len(axes)))
    return replace(system, flow=tuple((axis, thickness) for axis in axes))


def _records(scene, terms):
    """What kernels get of some terms, by names of `System`."""
    found: dict[str, Any] = {"pair": Soft(scene.repulsion)}
    for term in terms.values():
        found |= term.records(scene)
        if term.joins:
            laws = term.laws(scene)
            members, number = joined(scene.molecules, laws, term.joins)
            record = bond_record(list(laws.values()), number)
            keys = ("bond", "members") if term.joins == 2 else ("angle", "angle_members")
            found |= dict(zip(keys, (record, members)))
    if own := [term for term in terms.values() if isinstance(term, PairForce)]:
        found["pair"] = with_own(found["pair"], own, scene)
    return found


def start_system(scene: Scene, dt: float) -> System:
    """The system in which a start is made, at rest: gw-vv, lambda 1/2, friction between pairs."""
    gamma, seed = scene.start.forces.gamma, start_description(scene)["seed"]
    absent: Any = dict.fromkeys(_records(scene, scene.terms))
    return replace(
        system_of(scene),
        friction=scene.friction if gamma is None else float(gamma),
        gaussian=False,
        per_bead=False,
        dt=float(dt),
        scheme=scheme_named("gw-vv"),
        seed=seed + NOISE_OF_ITS_OWN,
        skin=scene.skin_at(dt),
        **absent | _records(scene, scene.start_terms),
    )


def make_start(
    scene: Scene,
    progress: Callable[[int], object] | None = None,
    say: Callable[[str], object] | None = None,
) -> State:
    """The first configuration in the order of identities, at step 0, every molecule whole.

    ``progress`` is called with the work done so far, out of `dpd.start.start_work`, and ``say``
    with a sentence for what a file had otherwise than the scene wants it.
    """
    state = scene.start.make(scene, progress, say or (lambda sentence: None))
    state = state or relaxed(scene, _placed(scene), progress)
    box = state.box or box_at(scene, 0, state.slid)
    state.image = whole_images(scene.molecules, state.position, state.image, box)
    return state


def _placed(scene):
    """Beads where the page puts them, with its velocities or thermal ones."""
    page, description, species = scene.start, start_description(scene), species_of(scene)
    rng = np.random.default_rng(description["seed"])
    position = _asked(scene, page.positions, rng)
    for axis in scene.ended:
        behind = (position[axis] < 0) | (position[axis] > scene.box[axis])
        if behind.any():
            bead = int(np.argmax(behind))
            raise UserError(
                f"{scene.where}: start: {page.key!r}: bead {bead} is at {position[axis, bead]:.6g} "
                f"along {'xyz'[axis]}, behind a wall; allowed: 0 to {scene.box[axis]:g}"
            )
    position, _ = wrapped(position + np.array(scene.origin)[:, None], scene.period)
    velocity = _asked(scene, page.velocities, rng)
    if velocity is None:
        mass = system_of(scene).mass_of(species)
        velocity = thermal_velocities(position.shape, description["kT"], rng, mass)
    identity = np.arange(position.shape[1], dtype=np.uint32)
    return State(position, velocity, None, identity, species, 0)


def _asked(scene, method, rng):
    """(dimension, beads) array of what a page gives; None if that is None."""
    name, place = method.__name__, f"{scene.where}: start: {scene.start.key!r}"
    with blaming(scene.start, place):
        given = method(scene, rng)
        found = given if given is None else np.array(given, float)
    if found is None and method == scene.start.velocities:
        return None
    wanted = (scene.beads, scene.dimension)
    if np.shape(found) != wanted:
        raise UserError(f"{place}: its {name} have the shape {np.shape(found)} instead of {wanted}")
    if not np.isfinite(found).all():
        bead = int(np.argmin(np.isfinite(found).all(axis=1)))
        raise UserError(f"{place}: its {name} are not finite numbers: {found[bead]} of bead {bead}")
    return np.ascontiguousarray(found.T)


def species_of(scene: Scene) -> np.ndarray | None:
    """(n,) uint8 array of species in the order of identities; None where there is one species."""
    return None if len(scene.species) == 1 else scene.kinds


def relaxed(
    scene: Scene,
    state: State,
    progress: Callable[[int], object] | None,
    interval: int | None = None,
    look: Callable[[System, State], object] | None = None,
) -> State:
    """A state after the scene's relaxation, if it has any; a ``look`` follows each interval."""
    relax = scene.start.relax
    if relax is None:
        return state
    simulation = Simulation(start_system(scene, relax.dt), state)
    before = start_work(scene) - relax.steps

    def tell():
        if progress is not None:
            progress(before + simulation.state.step)

    while (left := relax.steps - simulation.state.step) > 0:
        advance_looking(simulation, min(left, interval or left), tell)
        if look is not None:
            look(simulation.system, simulation.state)
        tell()
    done = simulation.state
    species = None if done.species is None else done.by_identity(done.species)
    return State(
        done.by_identity(done.position), done.by_identity(done.velocity), None,
        np.arange(len(done.identity), dtype=np.uint32), species, 0, box=done.box,
        image=done.image,
    )  # fmt: skip


def thermal_velocities(
    shape: tuple[int, ...], kT: float, rng: np.random.Generator, mass: float | np.ndarray = 1.0
) -> np.ndarray:
    """(dimension, n) velocities in r_c / tau, Maxwellian, at rest as a whole."""
    velocity = rng.normal(scale=np.sqrt(kT / mass), size=shape)
    weights = mass if np.ndim(mass) else None
    return velocity - np.average(velocity, axis=1, weights=weights, keepdims=True)


def compile_start(scene: Scene) -> State:
    """Compile what a scene's start needs; return one of placed molecules, hardly relaxed."""
    if tiny := scene.start.tiny(scene):
        make_start(Scene(scene.data | tiny, scene.where))
    relax = scene.start.relax
    short = {"relax": {"steps": 1, "dt": relax.dt}} if relax and not scene.start.work else {}
    return make_start(Scene(scene.data | {"start": scene.start.stand_in() | short}, scene.where))
