"""One configuration of beads, whatever file it came from or goes to."""

from typing import NamedTuple

import numpy as np

from dpd.engine.space import along_axes, wrapped
from dpd.errors import UserError

ROUNDING = 1e-5  # of an edge that a bead may be outside: single precision, numbers in text

NO_ANGLES = np.zeros((0, 3), np.uint32)


class Particles(NamedTuple):
    """Beads in the order of their identities, with their bonds.

    Attributes
    ----------
    box : tuple of float
        Edges in r_c, two or three. The box goes from 0 to its edges; under shear it is a
        `dpd.engine.slide.TiltedBox`, whose images have slid.
    position : (dimension, n) array
        In r_c, inside the box.
    image : (dimension, n) int32 array
        How many boxes further the bead is than its position says.
    velocity : None or (dimension, n) array
        In r_c / tau; under shear about the flow.
    species : (n,) uint8 array
        Numbers in ``names``.
    names : tuple of str
    bonds : (bonds, 2) uint32 array
        Identities of the two ends of each.
    step : int
    left_out : tuple of str
        What the file held that has no place here, a sentence each.
    angles : (angles, 3) uint32 array
        Identities of the three beads of each, the middle one in between.
    masses : None or (names,) array
        Of a bead of each species; None where all are 1.
    """

    box: tuple[float, ...]
    position: np.ndarray
    image: np.ndarray
    velocity: np.ndarray | None
    species: np.ndarray
    names: tuple[str, ...]
    bonds: np.ndarray
    step: int = 0
    left_out: tuple[str, ...] = ()
    angles: np.ndarray = NO_ANGLES
    masses: np.ndarray | None = None

    @property
    def dimension(self) -> int:
        return len(self.box)

    @property
    def beads(self) -> int:
        """Number of beads."""
        return self.position.shape[1]

    def masses_by_name(self) -> dict[str, float]:
        """Mass of a bead of each species; nothing where all are 1."""
        return {} if self.masses is None else dict(zip(self.names, self.masses.tolist()))

    def __str__(self) -> str:
        edges = " x ".join(f"{edge:g}" for edge in self.box)
        species = ", ".join(
            f"{(self.species == number).sum()} {name}" for number, name in enumerate(self.names)
        )
        velocities = "with" if self.velocity is not None else "without"
        return (
            f"{self.beads} beads ({species}) with {len(self.bonds)} bonds in a box of {edges}, "
            f"{velocities} velocities, at step {self.step}"
        )


def molecules_of(particles: Particles) -> np.ndarray:
    """(n,) numbers of molecules, from 0, by the bonds that hold them together."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    one, two = particles.bonds.astype(np.int64).T
    table = coo_array((np.ones(len(one), np.int8), (one, two)), shape=(particles.beads,) * 2)
    return connected_components(table, directed=False)[1]


def checked(particles: Particles, path: object) -> Particles:
    """Particles that a simulation can begin with.

    Beads that are outside of the box by no more than `ROUNDING` are put inside.

    Parameters
    ----------
    particles : Particles
        As they stand in a file, in arrays of the right shapes.
    path : path
        Of that file, for messages.

    Raises
    ------
    UserError
        If the box has no volume, a number is not finite, a bead is outside the box, or a bond has
        an end that is no bead, the same bead twice, or is there twice; the same for an angle.
    """

    def refuse(problem: str) -> None:
        raise UserError(f"{path}: {problem}")

    box = np.array(particles.box, dtype=float)
    if not (np.isfinite(box) & (box > 0)).all():
        edges = " x ".join(f"{edge:g}" for edge in box)
        refuse(f"the box of {edges} has an edge that is not a positive number; mend the box")
    if not particles.beads:
        refuse("holds no beads; at least one is needed")
    for name in ("position", "velocity"):
        array = getattr(particles, name)
        if array is not None and not np.isfinite(array).all():
            bad = ~np.isfinite(array).all(axis=0)
            refuse(
                f"bead {np.argmax(bad)} has a {name} that is not a finite number ({bad.sum()} of "
                f"{bad.size} beads have); write the file again from a run that is whole"
            )
    position, image = _inside(particles, box[:, None], refuse)
    _check_species(particles, refuse)
    _check_masses(particles, refuse)
    _check_bonds(particles.bonds, particles.beads, refuse)
    _check_angles(particles.angles, particles.beads, refuse)
    return particles._replace(
        box=particles.box if _slid(particles.box) else tuple(map(float, box)),
        position=position,
        image=image,
        velocity=None if particles.velocity is None else particles.velocity.astype(float),
        species=particles.species.astype(np.uint8),
        bonds=particles.bonds.astype(np.uint32).reshape(-1, 2),
        angles=particles.angles.astype(np.uint32).reshape(-1, 3),
    )


def _slid(box):
    """Whether it is a box whose images have slid."""
    return hasattr(box, "slide")


def _inside(particles, edges, refuse):
    """Positions in the box, with rounding mended, and their images."""
    position, image = particles.position.astype(float), particles.image
    if _slid(particles.box):  # files may have them in the tilted box
        across = position.copy()
        across[particles.box.slide.flow] = 0.0
        _refuse_outside(across, edges, refuse)
        inside = wrapped(position, particles.box)
        moved = np.rint(along_axes(position - inside, particles.box) / edges).astype(np.int32)
        return inside, image + moved
    _refuse_outside(position, edges, refuse)
    boxes = np.floor(position / edges)
    inside = position - edges * boxes
    over = inside >= edges  # by rounding
    inside[over] = 0.0
    return inside, (image + boxes + over).astype(np.int32)


def _refuse_outside(position, edges, refuse):
    outside = (position < -ROUNDING * edges) | (position > (1 + ROUNDING) * edges)
    if outside.any():
        bad = outside.any(axis=0)
        bead = int(np.argmax(bad))
        axis = int(np.argmax(outside[:, bead]))
        refuse(
            f"bead {bead} is at {position[axis, bead]:g} along {'xyz'[axis]}, counted from the "
            f"lower end of the box, whose edge is {edges[axis, 0]:g} ({bad.sum()} of {bad.size} "
            "beads are outside); wrap the positions into the box, with image flags if they are to "
            "be kept, or mend the box"
        )


def _check_species(particles, refuse):
    names, species = particles.names, particles.species
    if len(set(names)) != len(names):
        refuse(f"two kinds of beads have the same name ({', '.join(names)}); name them differently")
    if species.min() < 0 or species.max() >= len(names):
        bead = int(np.argmax((species < 0) | (species >= len(names))))
        refuse(
            f"bead {bead} is of kind {species[bead]}, and there are {len(names)} kinds, counted "
            "from 0; mend its kind"
        )


def _check_masses(particles, refuse):
    for name, mass in particles.masses_by_name().items():
        if not (np.isfinite(mass) and mass > 0):
            refuse(f"beads of {name} have the mass {mass:g}; allowed: numbers above 0")


def _check_bonds(bonds, count, refuse):
    if not bonds.size:
        return
    bad = (bonds < 0) | (bonds >= count)
    if bad.any():
        number = int(np.argmax(bad.any(axis=1)))
        end = bonds[number][bad[number]][0]
        refuse(
            f"bond {number} has an end at bead {end}, and beads go from 0 to {count - 1}; the "
            "file lacks beads, or the bond is wrong"
        )
    if (bonds[:, 0] == bonds[:, 1]).any():
        number = int(np.argmax(bonds[:, 0] == bonds[:, 1]))
        refuse(f"bond {number} ties bead {bonds[number, 0]} to itself; remove it")
    pairs = np.sort(bonds, axis=1)
    _, first, times = np.unique(pairs, axis=0, return_index=True, return_counts=True)
    if (times > 1).any():
        one, other = pairs[first[np.argmax(times > 1)]]
        refuse(f"beads {one} and {other} are bonded {times.max()} times; keep one of these bonds")


def _check_angles(angles, count, refuse):
    bad = (angles < 0) | (angles >= count)
    if bad.any():
        number = int(np.argmax(bad.any(axis=1)))
        bead = angles[number][bad[number]][0]
        refuse(
            f"angle {number} has bead {bead}, and beads go from 0 to {count - 1}; the file lacks "
            "beads, or the angle is wrong"
        )
    one, middle, other = angles.T
    twice = (one == middle) | (middle == other) | (one == other)
    if twice.any():
        number = int(np.argmax(twice))
        refuse(f"angle {number} has a bead twice: {angles[number].tolist()}; remove it")
