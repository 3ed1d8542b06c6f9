"""Systems of every kind, each for the engine and for the plain reference."""

import numpy as np

from dpd.physics.body_force import BodyForce
from dpd.physics.many_body import NORM, ManyBody
from dpd.physics.pressure import Pressure
from dpd.physics.shear import Shear
from dpd.physics.walls import Walls
from dpd.scene.molecules import Molecule
from tests.engine.reference import PressedReference, Reference
from tests.systems import (
    chains,
    harmonic,
    harmonic_angles,
    make_simulation,
    make_system,
    random_beads,
)

BOX, FLAT = (2.5, 3.7, 5.1), (5.1, 2.5)
CORE, SMOOTH_CORE = (0.3, 100.0, None), (0.3, 100.0, 0.1)
TABLE = np.array([[25.0, 40.0], [40.0, 30.0]])
DRAWN = np.array([[-40.0, -20.0], [-20.0, -30.0]])  # with many-body forces
FRICTION, MASSES = np.array([[4.5, 12.0], [12.0, 0.5]]), np.array([0.5, 3.0])
GAP = 2.0  # behind each wall: a reach of 1 and the cutoff
STAR = Molecule(("A",) * 6, (-1, 0, 1, 1, 3, 1), (), 5)  # three arms and a stem on bead 1


def joined(kind):
    """Bonds and angles of all molecules of a kind."""
    first = len(kind.beads) * np.arange(kind.count)[:, None, None]
    return tuple(
        (first + inside).reshape(-1, inside.shape[1]).astype(np.uint32)
        for inside in (kind.bonds, kind.triples)
    )


def laws(tabled, members, triples):
    """One law for all bonds and one for all angles, or a table of each."""
    if not tabled:
        return harmonic(60.0, 0.5), harmonic_angles(7.0, 2.0)
    bond = harmonic(np.array([60.0, 20.0, 90.0]), np.array([0.5, 0.0, 0.8]), members[:, 1] % 3)
    angle = harmonic_angles(np.array([7.0, 3.0]), np.array([2.0, np.pi]), triples[:, 2] % 2)
    return bond, angle


def stars(box, tabled, **changes):
    """Stars and single beads, 50 in all: system, positions and velocities."""
    members, triples = joined(STAR)
    bond, angle = laws(tabled, members, triples)
    system = make_system(
        box, seed=12, bond=bond, members=members, angle=angle, angle_members=triples, **changes
    )
    return system, *bonded_beads(box, 50, members)


def bonded_beads(box, count, members):
    """Beads anywhere, but each 0.6 from the one that it hangs on."""
    position, velocity = random_beads(box, count, seed=3)
    rng = np.random.default_rng(7)
    for one, other in members:
        arm = rng.normal(size=len(box))
        position[:, other] = position[:, one] + 0.6 * arm / np.linalg.norm(arm)
    return position % np.array(box)[:, None], velocity


def between(edges, axes, repulsion, velocity=None):
    """Box and `Walls` for planes at a distance along some axes."""
    dimension = len(edges)
    box = tuple(edge + 2 * GAP * (axis in axes) for axis, edge in enumerate(edges))
    places = [place for axis in axes for place in (GAP, GAP + edges[axis])]
    velocity = np.zeros((2, dimension)) if velocity is None else np.array(velocity)
    return box, Walls(
        repulsion=np.array(repulsion, float),
        axis=np.repeat(np.array(axes, np.int64), 2),
        place=np.array(places),
        inward=np.tile([1.0, -1.0], len(axes)),
        velocity=np.tile(velocity, (len(axes), 1)),
        reach=1.0,
    )


def walled(axes, edges=(2.9, 2.5, 4.1), **changes):
    """Rough walls, which move if they are two, and a force in two directions."""
    dimension = len(edges)
    moving = [[0.3] * dimension, [-0.2] * dimension]
    for each in moving:
        each[axes[0]] = 0.0
    box, walls = between(edges, axes, [25.0, 60.0], moving if len(axes) == 1 else None)
    body = BodyForce(np.array([0.4, -0.7]), 0, dimension - 2, 0.5 * edges[dimension - 2])
    own = {"walls": walls, "wall_friction": 9.0, "body_force": body, "dt": 0.01}
    return {"box": box, "between": (edges, axes), "mixed": True} | own | changes


def sheared(box, *shear, **changes):
    return {"box": box, "shear": Shear(*shear), "mixed": True} | changes


def pressed(box, *law, **changes):
    return {"box": box, "pressure": Pressure(*law), "kind": PressedReference} | changes


def crowded(range=0.75, box=(2.6, 3.7, 5.1), **changes):
    law = {"many_body": ManyBody(25.0, range, NORM[len(box)] / range ** len(box))}
    law |= {"repulsion": DRAWN, "dt": 0.01}
    return {"box": box, "count": 100, "mixed": "beads"} | law | changes


MIXED, DPD_VV = {"mixed": True}, {"scheme": "dpd-vv"}
BY_SPECIES = {"friction": FRICTION, "masses": MASSES, "mixed": True, "dt": 0.01}
BATH = {"per_bead": True, "mixed": True, "dt": 0.01}
CASES = {
    "gw-vv": {} | MIXED,
    "gw-vv, 2D": {"box": FLAT} | MIXED,
    "lambda 0.65, gaussian": {"prediction": 0.65, "gaussian": True},
    "euler, 2D, gaussian": {"box": FLAT, "scheme": "euler", "gaussian": True},
    "euler-acceleration": {"scheme": "euler-acceleration"},
    "verlet-no-acceleration, 0.5": {"scheme": "verlet-no-acceleration"},
    "verlet-no-acceleration, 0.65": {"scheme": "verlet-no-acceleration", "prediction": 0.65},
    "dpd-vv": {} | DPD_VV,
    "dpd-vv, 2D, list": {"box": FLAT, "skin": 0.2, "dt": 0.01, "gaussian": True} | DPD_VV | MIXED,
    "list": {"skin": 0.2, "dt": 0.01},
    "core, list": {"box": FLAT, "core": CORE, "skin": 0.2, "dt": 0.01} | MIXED,
    "core": {"box": FLAT, "core": CORE, "dt": 0.01} | MIXED,
    "smooth core, list": {"box": FLAT, "core": SMOOTH_CORE, "skin": 0.2, "dt": 0.01} | MIXED,
    "bath, list": BATH | {"prediction": 0.65, "skin": 0.2},
    "bath, gaussian": BATH | {"scheme": "verlet-no-acceleration", "gaussian": True},
    "bath, dpd-vv, 2D": BATH | DPD_VV | {"box": FLAT},
    "by species": BY_SPECIES,
    "by species, 2D, list": BY_SPECIES | {"box": FLAT, "skin": 0.2, "gaussian": True},
    "by species, dpd-vv, list": BY_SPECIES | DPD_VV | {"skin": 0.2},
    "by species, bath": BY_SPECIES | {"per_bead": True, "friction": np.diag(FRICTION)},
    "by species, bath, dpd-vv": BY_SPECIES | DPD_VV | {
        "per_bead": True, "friction": np.diag(FRICTION)},
    "mass": {"masses": np.array([4.0]), "friction": np.array([[9.0]])},
    "trees": {"tabled": False},
    "trees, 2D, tables": {"box": FLAT, "tabled": True},
    "walls": walled((2,), prediction=0.65),
    "walls, 2D": walled((1,), (3.4, 4.1), gaussian=True),
    "walls, list, gaussian": walled((0, 2), skin=0.2, gaussian=True),
    "walls, dpd-vv": walled((2,)) | DPD_VV,
    "smooth walls in a bath": walled((2,), wall_friction=0.0, per_bead=True),
    "shear": sheared((3.1, 3.7, 5.1), 1.3, 0, 1),
    "shear, 2D": sheared((5.1, 2.2), 2.3, 0, 1),
    "shear, gradient along rows": sheared((3.1, 2.2, 3.7), -1.3, 0, 2),
    "shear, flow across layers": sheared((2.2, 3.1, 3.7), 1.3, 1, 2),
    "shear, tilt of two": sheared((9.1, 2.2, 2.2), 4.0, 0, 1),
    "shear, dpd-vv": sheared((3.1, 2.2, 3.7), -1.3, 0, 2) | DPD_VV,
    "shear, bath": sheared((3.1, 3.7, 5.1), 1.3, 0, 1, per_bead=True),
    "pressure": pressed((2.6, 3.7, 5.1), 8.0, 0.5, 0.1, (0, 1, 2), 3) | MIXED,
    "pressure along z": pressed((2.6, 3.7, 5.1), 8.0, 0.5, 0.1, (2,), 4, prediction=0.65),
    "pressure, 2D": pressed((5.1, 2.6), 30.0, 0.5, 0.03, (0, 1), 2) | MIXED,
    "pressure along x, 2D": pressed((5.1, 2.6), 30.0, 0.5, 0.03, (0,), 5),
    "pressure, trials in vain": pressed((2.6, 3.7, 5.1), 8.0, 0.5, 0.4, (0, 1, 2), 3) | MIXED,
    "pressure, dpd-vv": pressed((2.6, 3.7, 5.1), 8.0, 0.5, 0.1, (0, 1, 2), 3) | DPD_VV,
    "many-body": crowded(),
    "many-body, 2D, list": crowded(box=FLAT, skin=0.1, count=50, dt=0.002),
    "many-body, shear": crowded(1.0, shear=Shear(0.7, 0, 1)),
    "many-body, pressure": crowded(
        pressure=Pressure(40.0, 0.5, 0.003, (0, 1, 2), 3), kind=PressedReference),
}  # fmt: skip
SPLIT = {scheme: {"scheme": scheme, "dt": 0.01} | MIXED
         for scheme in ("shardlow", "aboba", "lowe-andersen")}  # fmt: skip


def system_of(box=BOX, count=50, mixed=False, tabled=None, between=None, kind=None, **changes):
    """System, positions, velocities and species of a case."""
    values, species = {"dt": 0.02, "seed": 12} | changes, None
    if tabled is not None:
        return *stars(box, tabled, **changes), None
    if mixed:
        species = (np.arange(count) % 2).astype(np.uint8)
        values = {"repulsion": TABLE} | values
    if mixed is True:
        values = {"bonds": (chains(8, 5), 60.0, 0.7)} | values
    system = make_system(box, **values)
    if between:
        position, velocity = random_beads(between[0], count, 9)
        position[list(between[1])] += GAP
        return system, position, velocity, species
    return system, *bonded_beads(box, count, [] if system.members is None else system.members), \
        species  # fmt: skip


def simulation_of(name, threads=1, **changes):
    """The engine's beads of a case."""
    system, position, velocity, species = system_of(**(CASES | SPLIT)[name] | changes)
    return make_simulation(system, position, velocity, species, threads=threads)


def beside(name, **changes):
    """The same, and those of the reference."""
    case = (CASES | SPLIT)[name] | changes
    system, position, velocity, species = system_of(**case)
    scheme, prediction = case.get("scheme", "gw-vv"), case.get("prediction", 0.5)
    kind = case.get("kind", Reference)
    reference = kind(system, scheme, prediction, position, velocity, species)
    return make_simulation(system, position, velocity, species), reference
