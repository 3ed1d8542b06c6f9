"""First configurations, and the steps that relax them."""

from dataclasses import replace

import numpy as np

from dpd.engine.integrators import coefficients
from dpd.engine.simulation import Simulation, State, System

FLIGHT = 0.8  # r_c, a step of a random flight: about the distance of neighbours at density 3

NOISE_OF_ITS_OWN = 2**63  # added to the seed, so that relaxation and run draw other numbers


def system_of(scene):
    """The engine's view of a scene.

    Parameters
    ----------
    scene : Scene

    Returns
    -------
    System
    """
    data = scene.data
    thermostat, integrator = data["thermostat"], data["integrator"]
    bonds = None
    if "bond" in data:
        bond = data["bond"]
        bonds = (scene.bonded, float(bond["stiffness"]), float(bond["length"]))
    core = None
    if "core" in data:
        core = (2.0 * data["core"]["radius"], float(data["core"]["force"]))
    return System(
        box=scene.box,
        repulsion=scene.repulsion,
        kT=float(thermostat["kT"]),
        friction=float(thermostat["gamma"]),
        gaussian=thermostat["noise"] == "gaussian",
        bonds=bonds,
        dt=float(integrator["dt"]),
        scheme=coefficients(integrator["scheme"], float(integrator["lambda"])),
        seed=data["seed"],
        core=core,
        skin=scene.skin,
    )


def start_description(scene):
    """The part of a scene that decides its first configuration, as plain data.

    Runs whose descriptions agree share one start.
    """
    data, start = scene.data, scene.data["start"]
    kept = {
        "dimension": data["dimension"],
        "box": list(scene.box),
        "molecules": data["molecules"],
        "method": start["method"],
        "kT": start.get("kT", data["thermostat"]["kT"]),
        "seed": start.get("seed", data["seed"]),
    }
    if "relax" in start:
        kept["relax"] = start["relax"]
        kept["forces"] = {key: data.get(key) for key in ("repulsion", "bond", "core")}
        kept["gamma"] = data["thermostat"]["gamma"]
    return kept


def make_start(scene, progress=None):
    """Build, and where the scene asks for it relax, the first configuration.

    Parameters
    ----------
    scene : Scene
    progress : callable or None
        Called with the number of relaxation steps done.

    Returns
    -------
    State
        In the order of identities, with no force yet and step 0.
    """
    description = start_description(scene)
    rng = np.random.default_rng(description["seed"])
    position = _positions(scene, description["method"], rng)
    velocity = rng.normal(scale=np.sqrt(description["kT"]), size=position.shape)
    velocity -= velocity.mean(axis=1, keepdims=True)
    identity = np.arange(position.shape[1], dtype=np.uint32)
    state = State(position, velocity, None, identity, _species(scene), 0)
    if "relax" in description:
        state = _relax(scene, state, description["relax"], progress)
    return state


def _positions(scene, method, rng):
    """Random flights, each kind of molecule in the whole box or in a slab of its own."""
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
        parts.append(_flights(kind.count, len(kind.beads), low, slab, rng))
    x = np.concatenate(parts, axis=1)
    x -= box[:, None] * np.floor(x / box[:, None])
    return np.where(x < box[:, None], x, 0.0)


def _flights(count, length, low, size, rng):
    """(dimension, count * length) positions of random flights, folded back into a slab."""
    d = len(size)
    first = rng.random((count, 1, d)) * size
    steps = rng.normal(size=(count, length - 1, d))
    steps *= FLIGHT / np.linalg.norm(steps, axis=2, keepdims=True)
    x = np.concatenate([first, steps], axis=1).cumsum(axis=1)
    x = np.abs((x + size) % (2 * size) - size)  # reflected at 0 and at the slab's size
    return (x + low).reshape(-1, d).T.copy()


def _species(scene):
    """(n,) uint8 numbers of species, or None where there is one."""
    if len(scene.species) == 1:
        return None
    numbers = [
        np.tile([scene.species.index(name) for name in kind.beads], kind.count)
        for kind in scene.molecules
    ]
    return np.concatenate(numbers).astype(np.uint8)


def _relax(scene, state, relax, progress):
    """Steps with gw-vv, lambda 1/2; back to the order of identities and to step 0."""
    system = replace(
        system_of(scene),
        gaussian=False,
        dt=float(relax["dt"]),
        scheme=coefficients("gw-vv"),
        seed=start_description(scene)["seed"] + NOISE_OF_ITS_OWN,
        skin=0.0,
    )
    simulation = Simulation(system, state)
    while (left := relax["steps"] - simulation.state.step) > 0:
        simulation.advance(min(left, 500))
        if progress is not None:
            progress(simulation.state.step)
    done = simulation.state
    species = None if done.species is None else done.by_identity(done.species)
    return State(
        done.by_identity(done.position), done.by_identity(done.velocity), None,
        np.arange(len(done.identity), dtype=np.uint32), species, 0,
    )  # fmt: skip
