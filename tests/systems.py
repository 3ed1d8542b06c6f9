"""Small systems for the tests, and what they have in common."""

import gsd.fl
import numpy as np

from dpd.engine.simulation import Simulation, Snapshot
from dpd.engine.space import unfolded, wrapped
from dpd.engine.state import State, System
from dpd.jit import COMPILES
from dpd.observe.common.measured import observables
from dpd.physics.angle import Angle
from dpd.physics.bond import BondLaw
from dpd.physics.common.forces import bond_record
from dpd.physics.core import Core
from dpd.physics.integrator import scheme_named
from dpd.physics.repulsion import Soft
from dpd.scene.scene import Scene
from dpd.start.common.make import make_start, system_of

BOX_3D = (2.2, 3.7, 5.1)  # two, three and five cells
BOX_2D = (5.1, 2.2)  # the rows of cells run along the last axis


def fewer_in_python(count):
    """So many steps, or three where there is no compiler, and each takes a tenth of a second."""
    return count if COMPILES else 3


def make_system(box, scheme="gw-vv", prediction=0.5, *, bonds=None, core=None, **changes):
    """Groot and Warren's standard fluid in a box, with changes by name.

    Parameters
    ----------
    box : tuple
    scheme, prediction
        See `dpd.physics.integrator.scheme_named`.
    bonds : (members, stiffness, length) or None
    core : (diameter, push, width) or None
    """
    repulsion = changes.pop("repulsion", np.array([[25.0]]))
    values = {
        "pair": Soft(repulsion) if core is None else Core(repulsion, *core),
        "kT": 1.0,
        "friction": 4.5,
        "gaussian": False,
        "dt": 0.04,
        "seed": 1,
    } | changes
    if bonds is not None:
        members, stiffness, length = bonds
        values |= {"members": members, "bond": harmonic(stiffness, length)}
    return System(box=box, scheme=scheme_named(scheme, prediction), **values)


def frames_of(path):
    """All that the frames of a trajectory have."""
    with gsd.fl.open(str(path), "r") as file:
        names = file.find_matching_chunk_names("")
        return [
            {one: file.read_chunk(k, one).tobytes() for one in names if file.chunk_exists(k, one)}
            for k in range(file.nframes)
        ]


def harmonic(stiffness, length, number=None):
    """Harmonic bonds as kernels have them; of tables, ``number`` is the place of each bond's."""
    laws = np.stack(np.broadcast_arrays(stiffness, length), axis=-1).reshape(-1, 2).tolist()
    return bond_record([BondLaw(stiffness=c, length=rest) for c, rest in laws], number)


def harmonic_angles(stiffness, angle, number=None):
    """The same of angles, in radians."""
    laws = np.stack(np.broadcast_arrays(stiffness, angle), axis=-1).reshape(-1, 2).tolist()
    return bond_record([Angle(stiffness=k, angle=rest) for k, rest in laws], number)


def make_simulation(system, position, velocity, species=None, identity=None, threads=1):
    """Beads in motion, numbered in the order given unless ``identity`` says otherwise."""
    if identity is None:
        identity = np.arange(position.shape[1])
    state = State(position.copy(), velocity.copy(), None, identity.astype(np.uint32), species, 0)
    return Simulation(system, state, threads)


class Killed(BaseException):
    """What ends a run at once, without any of its clean-up."""


def kill_at(last):
    """Progress that ends a run once it has come to a step."""

    def progress(step):
        if step >= last:
            raise Killed

    return progress


def begun(data, threads=1):
    """A simulation of a scene at its start, what observes it, and its steps."""
    scene = Scene(data)
    system = system_of(scene)
    return Simulation(system, make_start(scene), threads), observables(scene, system), scene.steps


def values_of(observer):
    """What an observable leaves in a file, without dimensions and units."""
    return {name: variable[1] for name, variable in observer.variables().items()}


def look(data, observe, *positions):
    """What the one observable leaves in a file after looks at beads in these places.

    The beads are put inside the box, and stored in another order at each look.
    """
    scene = Scene(data | {"observe": [observe]}, "scene.yaml")
    system = system_of(scene)
    observer, *_ = observables(scene, system)
    for step, position in enumerate(positions):
        order = np.random.default_rng(step).permutation(scene.beads)
        species = scene.kinds[order] if len(scene.species) > 1 else None
        inside, image = wrapped(position, scene.box)  # images are by identity
        identity, still = order.astype(np.uint32), np.zeros_like(inside)
        state = State(inside[:, order], still, None, identity, species, step, image=image)
        observer.sample(Snapshot(system, state))
    return values_of(observer)


def assert_pairs(found):
    """No pair twice, the smaller number first: the same as a set."""
    assert found.shape[0] == 2 and found.dtype == np.uint32
    assert (found[0] < found[1]).all()
    seen = {(int(i), int(j)) for i, j in found.T}
    assert len(seen) == found.shape[1]
    return seen


def random_beads(box, count, seed=0):
    """Positions anywhere in the box, and velocities at kT 1 without total momentum."""
    rng = np.random.default_rng(seed)
    position = rng.random((len(box), count)) * np.array(box)[:, None]
    velocity = rng.normal(size=position.shape)
    return position, velocity - velocity.mean(axis=1, keepdims=True)


def chains(count, length):
    """Members of the bonds of ``count`` chains, bead after bead."""
    first = np.arange(count * length).reshape(count, length)
    return np.stack([first[:, :-1].ravel(), first[:, 1:].ravel()], axis=1).astype(np.uint32)


def by_identity(simulation, name):
    """An array of the state in the order of identities."""
    return simulation.state.by_identity(getattr(simulation.state, name))


def unfolded_places(simulation):
    """(dimension, n) positions by identity, which go on where beads leave the box."""
    return unfolded(by_identity(simulation, "position"), simulation.state.image, simulation.box)


def assert_same_place(found, expected, box, within):
    """Two sets of positions are the same up to whole box edges."""
    edges = np.array(box)[:, None]
    apart = found - expected
    apart -= edges * np.round(apart / edges)
    assert np.abs(apart).max() < within


def assert_same_state(one, other):
    """Two states hold the same bits."""
    assert one.step == other.step
    for name in ("position", "velocity", "force", "identity", "species"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name), err_msg=name)
