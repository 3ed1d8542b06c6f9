"""First configurations, and the steps that relax them."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from dpd.engine.loop import advance_looking
from dpd.engine.queries.crossings import crossing_bonds
from dpd.engine.simulation import Simulation
from dpd.engine.space import wrapped
from dpd.engine.state import State, System
from dpd.errors import UserError
from dpd.page import is_table
from dpd.particles.particles import whole_images
from dpd.particles.tilt import box_at, shear_of
from dpd.physics.angle import Angle
from dpd.physics.bond import Bond
from dpd.physics.common.own_pairs import with_own
from dpd.physics.core import Core
from dpd.physics.integrator import scheme_named
from dpd.physics.repulsion import Soft
from dpd.scene.bonding import laws_of, numbers_of, species_along
from dpd.scene.start import FLIGHT, start_description, start_forces
from dpd.start.common.from_file import state_from_file
from dpd.start.common.polymerization import LOOK, polymerize
from dpd.start.common.velocities import thermal_velocities

if TYPE_CHECKING:
    from collections.abc import Callable

    from dpd.scene.scene import Scene

NOISE_OF_ITS_OWN = 2**63  # added to the seed, so that relaxation and run draw other numbers


def system_of(scene: Scene) -> System:
    """The engine's view of a scene.

    Parameters
    ----------
    scene : Scene

    Returns
    -------
    System
    """
    data = scene.data
    thermostat, integrator = data["thermostat"], scene.terms["integrator"].named
    system = System(
        box=scene.period,
        pair=_pair(scene, data.get("core")),
        kT=float(thermostat["kT"]),
        friction=scene.friction,
        gaussian=thermostat["noise"] == "gaussian",
        dt=scene.dt,
        scheme=scheme_named(integrator.scheme, float(integrator.lambda_)),
        seed=data["seed"],
        skin=scene.skin,
        per_bead=thermostat["kind"] == "langevin",
        masses=scene.masses,
        walls=_record(scene, "walls"),
        wall_friction=float(data.get("walls", {}).get("gamma", 0)),
        body_force=_record(scene, "body_force"),
        shear=shear_of(scene),
        pressure=_record(scene, "pressure"),
        **_bonding(scene, data),
    )
    return replace(system, flow=scene.flow_layers(system.extent))


def _record(scene, key):
    """What kernels get of a term; None where the scene does not name it."""
    return scene.terms[key].record(scene) if key in scene.terms else None


def _bonding(scene, forces):
    """Bonds and angles of a scene, as `System` has them, with the laws in ``forces``."""
    found = dict.fromkeys(("bond", "members", "angle", "angle_members"))
    if "bond" in forces:
        stiffness, length = _values(forces["bond"], "stiffness", "length")
        found["members"], number = scene.bonds
        found["bond"] = Bond(stiffness, length, number)
    if "angle" in forces:
        stiffness, angle = _values(forces["angle"], "stiffness", "angle")
        found["angle_members"], number = scene.angles
        found["angle"] = Angle(stiffness, np.deg2rad(angle), number)
    return found


def _values(given, *keys):
    """Values of one law for all as numbers; of a table as arrays."""
    laws = laws_of(given)
    values = (np.array([float(law[key]) for law in laws]) for key in keys)
    return values if is_table(given) else map(float, np.concatenate(list(values)))


def _pair(scene, core):
    """The conservative force between pairs."""
    found: Any = Soft(scene.repulsion)
    if core is not None and core["radius"]:
        width = float(core.get("smooth", 0)) or None
        found = Core(scene.repulsion, 2.0 * core["radius"], float(core["force"]), width)
    return with_own(found, scene.own_forces, scene)


def _start_system(scene, dt):
    """The system in which the start is made: gw-vv with lambda 1/2, friction between pairs.

    It is at rest: neither a body force acts, nor a shear.
    """
    forces = start_forces(scene)
    return replace(
        system_of(scene),
        friction=scene.friction_of(forces["gamma"]),
        gaussian=False,
        per_bead=False,
        pair=_pair(scene, forces.get("core")),
        dt=float(dt),
        scheme=scheme_named("gw-vv"),
        seed=start_description(scene)["seed"] + NOISE_OF_ITS_OWN,
        skin=scene.skin_at(dt),
        body_force=None,
        shear=None,
        pressure=None,
        **_bonding(scene, forces),
    )


def make_start(
    scene: Scene,
    progress: Callable[[int], object] | None = None,
    say: Callable[[str], object] | None = None,
) -> State:
    """Build or read, and where the scene asks for it relax, the first configuration.

    Parameters
    ----------
    scene : Scene
    progress : callable or None
        Called with the work done so far, out of `dpd.scene.start.start_work`.
    say : callable or None
        Called with a sentence for what a file had otherwise than the scene wants it.

    Returns
    -------
    State
        In the order of identities, with no force yet and step 0, and every molecule whole.
    """
    state, _ = make_start_and_record(scene, progress, say)
    return state


def make_start_and_record(
    scene: Scene,
    progress: Callable[[int], object] | None = None,
    say: Callable[[str], object] | None = None,
) -> tuple[State, dict[str, np.ndarray]]:
    """As `make_start`, with how it came about.

    Returns
    -------
    State
    dict of str to array
        For polymerization its `RECORD`, one value per round of growth, and
        ``relax_crossings``, pairs of crossing bonds at every look while it relaxed: all 0.

    Raises
    ------
    UserError
        If chains cannot be grown, or if bonds cross while they relax, or if a file cannot be
        read or holds another system.
    """
    description = start_description(scene)
    grown = description["method"] == "polymerize"
    if grown:
        system = _start_system(scene, description["polymerize"]["dt"])
        state, record = polymerize(
            scene, description["polymerize"], system, description["seed"], description["kT"],
            progress,
        )  # fmt: skip
    elif description["method"] == "file":
        species = species_of(scene)
        mass = system_of(scene).mass_of(species)
        state, record = state_from_file(scene, species, mass, say or _be_silent), {}
    else:
        state, record = _random(scene, description), {}
    if "relax" in description:
        begun = scene.beads if grown else 0
        state, crossings = _relax(scene, state, description["relax"], grown, begun, progress)
        if grown:
            record["relax_crossings"] = crossings
    if grown:
        # Chains that grow and spare monomers that vanish leave flows across the box, which
        # only viscosity would bring to rest.
        rng = np.random.default_rng([description["seed"], 1])
        mass = system.mass_of(state.species)
        state.velocity = thermal_velocities(state.position.shape, description["kT"], rng, mass)
    box = state.box or box_at(scene, 0, state.slid)
    state.image = whole_images(scene.molecules, state.position, state.image, box)
    return state, record


def _be_silent(sentence):
    """Where nobody listens."""


def _random(scene, description):
    """Random flights with random velocities."""
    rng = np.random.default_rng(description["seed"])
    flight = description.get("flight", FLIGHT)
    position = _positions(scene, description["method"], flight, rng)
    species = species_of(scene)
    mass = system_of(scene).mass_of(species)
    velocity = thermal_velocities(position.shape, description["kT"], rng, mass)
    identity = np.arange(position.shape[1], dtype=np.uint32)
    return State(position, velocity, None, identity, species, 0)


def _positions(scene, method, flight, rng):
    """Random flights, each kind of molecule in the whole box or in a slab of its own.

    Where they go through a wall they are reflected.
    """
    box = np.array(scene.box)
    along = int(np.argmax(box))
    low, filled, parts = np.zeros_like(box), 0, []
    for kind in scene.molecules:
        beads = kind.count * len(kind.beads)
        slab = box.copy()
        if method == "slabs":
            low[along] = box[along] * filled / scene.beads
            slab[along] = box[along] * beads / scene.beads
        filled += beads
        x = _flights(kind, slab, _flight_of_bonds(kind, flight), rng)
        if method == "slabs":
            x = np.abs((x + slab) % (2 * slab) - slab)  # reflected at both faces
        parts.append((x + low).reshape(-1, len(box)).T)
    x = np.concatenate(parts, axis=1)
    for axis in scene.ended:
        x[axis] = np.abs((x[axis] + box[axis]) % (2 * box[axis]) - box[axis])
    return wrapped(x + np.array(scene.origin)[:, None], scene.period)[0]


def _flight_of_bonds(kind, flight):
    """The length of each step of a random flight along a molecule, or of all."""
    if not isinstance(flight, dict):
        return flight
    numbers = numbers_of(flight, species_along(kind, kind.bonds))
    return np.array(list(flight.values()))[numbers][:, None]


def _flights(kind, size, flight, rng):
    """(count, length, dimension) positions of random flights that begin in a box."""
    first = rng.random((kind.count, 1, len(size))) * size
    steps = rng.normal(size=(kind.count, len(kind.beads) - 1, len(size)))
    steps *= flight / np.linalg.norm(steps, axis=2, keepdims=True)
    steps = np.concatenate([first, steps], axis=1)
    return np.moveaxis(kind.summed(np.moveaxis(steps, 1, 2)), 2, 1)


def species_of(scene: Scene) -> np.ndarray | None:
    """Species of each bead by its identity.

    Parameters
    ----------
    scene : Scene

    Returns
    -------
    (n,) uint8 array or None
        Numbers in ``scene.species``; None where there is one species.
    """
    return None if len(scene.species) == 1 else scene.kinds


def _relax(scene, state, relax, grown, begun, progress):
    """Steps of relaxation; back to the order of identities and to step 0.

    Returns
    -------
    State
    (looks,) array
        Crossing bonds every `LOOK` tau; empty unless the chains were grown.
    """
    system = _start_system(scene, relax["dt"])
    simulation = Simulation(system, state)

    def look():
        if progress is not None:
            progress(begun + simulation.state.step)

    stretch = max(1, round(LOOK / relax["dt"])) if grown and system.bond else relax["steps"]
    crossings = []
    while (left := relax["steps"] - simulation.state.step) > 0:
        advance_looking(simulation, min(left, stretch), look)
        now = simulation.state
        if grown and system.bond:
            place = now.by_identity(now.position)
            try:
                crossings.append(crossing_bonds(place, system.members, system.box).shape[1])
            except UserError as problem:
                raise UserError(f"{scene.where}: start.relax: {problem}") from None
            if crossings[-1]:
                raise UserError(
                    f"{scene.where}: start.relax: {crossings[-1]} pairs of bonds crossed after "
                    f"{now.step} steps: these forces do not keep chains apart. Raise the core "
                    "force or radius or the bond stiffness, in the scene or in start.forces"
                )
        look()
    done = simulation.state
    species = None if done.species is None else done.by_identity(done.species)
    relaxed = State(
        done.by_identity(done.position), done.by_identity(done.velocity), None,
        np.arange(len(done.identity), dtype=np.uint32), species, 0, box=done.box,
        image=done.image,
    )  # fmt: skip
    return relaxed, np.array(crossings)
