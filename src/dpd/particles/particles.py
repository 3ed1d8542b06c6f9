"""One configuration of beads, whatever file it came from or goes to."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from dpd.engine.space import TURN, along_axes, tilted, wrapped
from dpd.errors import UserError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from dpd.physics.shear import Shear
    from dpd.scene.molecules import Molecule
    from dpd.scene.scene import Scene

ROUNDING = 1e-5  # of an edge: beads outside, tilts beyond half; single precision, text
FLAT = 1e-4  # r_c by which heights of beads of two dimensions may differ
MOST_IMAGES = 2**30  # boxes that a bead may be away
LARGEST_STEP = 10**18
# Tilt factors say how far the second or third vector of a box goes along the first or second axis,
# over its edge. Here positions stay in the upright box, whose images have slid.
FACTORS = (0, 1), (0, 2), (1, 2)  # axes of xy, xz and yz
SLID = "slid"  # attribute of a first configuration whose images have slid
UPRIGHT = 1e-9  # a tilt factor that is less is rounding: the box has right angles

NO_ANGLES = np.zeros((0, 3), np.uint32)


class Particles(NamedTuple):
    """Beads in the order of their identities, with their bonds.

    Attributes
    ----------
    box : tuple of float
        Edges in r_c, two or three. The box goes from 0 to its edges; under shear it is a
        `dpd.engine.space.TiltedBox`, whose images have slid.
    position : (dimension, n) array
        In r_c, inside the box.
    image : (dimension, n) int32 array
        How many boxes further the bead is than its position says.
    velocity : None or (dimension, n) array
        In r_c / tau; under shear about the flow.
    species : (n,) uint8 array
        Numbers in ``names``.
    bonds : (bonds, 2) uint32 array
        Identities of the two ends of each.
    left_out : tuple of str
        What the file held that has no place here, a sentence each.
    angles : (angles, 3) uint32 array
        Identities of the three beads of each, the middle one in between.
    masses : None or (names,) array
        Of a bead of each species; None where all are 1.
    identity : None or (n,) array
        What the file calls each bead; None where it counts them from 0.
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
    identity: np.ndarray | None = None

    @property
    def dimension(self) -> int:
        return len(self.box)

    @property
    def beads(self) -> int:
        """Number of beads."""
        return self.position.shape[1]

    def called(self, bead: int | np.integer) -> str:
        """A bead as its file names it, for messages."""
        return f"bead {bead}" if self.identity is None else f"atom {self.identity[bead]}"

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


def whole_images(
    kinds: Sequence[Molecule], position: np.ndarray, image: np.ndarray, box: Sequence[float]
) -> np.ndarray:
    """Images with which every molecule is in one piece, as its bonds pull: over nearest images.

    Arrays are in the order of identities; the first bead of each molecule keeps its image.
    """
    places, found, first = along_axes(position, box), image.copy(), 0
    for kind in kinds:
        end = first + kind.count * len(kind.beads)
        shape = len(box), kind.count, len(kind.beads)
        place, steps = (each[:, first:end].reshape(shape) for each in (places, found))
        parent, bead = kind.bonds.T
        apart = place[:, :, bead] - place[:, :, parent]
        steps[:, :, 1:] = -np.rint(apart / np.array(box)[:, None, None])
        found[:, first:end] = kind.summed(steps).reshape(len(box), -1)
        first = end
    return found


def of_scene(
    scene: Scene, box: tuple[float, ...], position: np.ndarray, image: np.ndarray,
    velocity: np.ndarray | None, step: int,
) -> Particles:  # fmt: skip
    """Beads of a scene in the order of their identities, with each molecule in one piece."""
    return Particles(
        box=box,
        position=position,
        image=whole_images(scene.molecules, position, image, box),
        velocity=velocity,
        species=scene.kinds,
        names=scene.species,
        bonds=scene.bonded,
        angles=scene.angled,
        step=step,
        masses=scene.masses,
    )


def only(particles: Particles, kept: np.ndarray) -> Particles:
    """Some of the beads, with the bonds and angles among them."""
    number = (np.cumsum(kept) - 1).astype(np.uint32)
    bonds, angles = (
        number[members[kept[members].all(axis=1)]]
        for members in (particles.bonds, particles.angles)
    )
    return particles._replace(
        position=particles.position[:, kept],
        image=particles.image[:, kept],
        velocity=None if particles.velocity is None else particles.velocity[:, kept],
        species=particles.species[kept],
        bonds=bonds,
        angles=angles,
    )


def molecules_of(particles: Particles) -> np.ndarray:
    """(n,) numbers of molecules, from 0, by the bonds that hold them together."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    one, two = particles.bonds.astype(np.int64).T
    table = coo_array((np.ones(len(one), np.int8), (one, two)), shape=(particles.beads,) * 2)
    return connected_components(table, directed=False)[1]


def checked(particles: Particles, path: object, periodic: bool = False) -> Particles:
    """Particles of a file that a simulation can begin with.

    Beads that are outside of the box by no more than `ROUNDING` are put inside; if it is periodic,
    as a format may have it, beads further outside as well, which is said.

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
    if not 0 <= particles.step < LARGEST_STEP:
        refuse(f"is of a step that is not from 0 to {LARGEST_STEP:g}; mend its number")
    for name in ("position", "velocity"):
        array = getattr(particles, name)
        if array is not None and not np.isfinite(array).all():
            bad = ~np.isfinite(array).all(axis=0)
            refuse(
                f"{particles.called(np.argmax(bad))} has a {name} that is not a finite number "
                f"({bad.sum()} of {bad.size} beads have); write the file again from a run that is "
                "whole"
            )
    position, image, far = _inside(particles, box[:, None], refuse)
    if far.any() and not periodic:
        bead = int(np.argmax(far.any(axis=0)))
        axis = int(np.argmax(far[:, bead]))
        refuse(
            f"{particles.called(bead)} is at {particles.position[axis, bead]:g} along "
            f"{'xyz'[axis]}, counted from the lower end of the box, whose edge is {box[axis]:g} "
            f"({far.any(axis=0).sum()} of {particles.beads} beads are outside); wrap the positions "
            "into the box, with image flags if they are to be kept, or mend the box"
        )
    wrapped_in = f"{far.any(axis=0).sum()} beads outside of the box are put in, and their images"
    _check_species(particles, refuse)
    _check_masses(particles, refuse)
    for name in ("bond", "angle"):
        _check_members(particles, name, refuse)
    return particles._replace(
        box=particles.box if _slid(particles.box) else tuple(map(float, box)),
        position=position,
        image=image,
        velocity=None if particles.velocity is None else particles.velocity.astype(float),
        species=particles.species.astype(np.uint8),
        bonds=particles.bonds.astype(np.uint32).reshape(-1, 2),
        angles=particles.angles.astype(np.uint32).reshape(-1, 3),
        left_out=(*particles.left_out, *[f"{wrapped_in} counted"] * bool(far.any())),
    )


def _slid(box):
    return hasattr(box, "slide")


def _inside(particles, edges, refuse):
    """Positions in the box, their images, and along which axes they are outside beyond rounding."""
    box, position = particles.box, particles.position.astype(float)
    far = (position < -ROUNDING * edges) | (position > (1 + ROUNDING) * edges)
    if _slid(box):  # files may have them in the tilted box
        far[box.slide.flow] = False
    with np.errstate(over="ignore", invalid="ignore"):
        inside, _ = wrapped(position, box)
        image = particles.image + np.rint(along_axes(position - inside, box) / edges)
    away = ~(np.abs(image) < MOST_IMAGES).all(axis=0)
    if away.any():
        refuse(
            f"{particles.called(np.argmax(away))} is {MOST_IMAGES} boxes away or more "
            f"({away.sum()} of {away.size} beads are); mend its position or its image flags"
        )
    return inside, image.astype(np.int32), far


def _check_species(particles, refuse):
    names, species = particles.names, particles.species
    if len(set(names)) != len(names):
        refuse(f"two kinds of beads have the same name ({', '.join(names)}); name them differently")
    if not all(map(str.isprintable, names)):
        refuse(f"names of kinds of beads have letters that cannot be shown ({names}); rename them")
    if species.min() < 0 or species.max() >= len(names):
        bead = int(np.argmax((species < 0) | (species >= len(names))))
        refuse(
            f"{particles.called(bead)} is of kind {species[bead]}, and there are {len(names)} "
            "kinds, counted from 0; mend its kind"
        )


def _check_masses(particles, refuse):
    for name, mass in particles.masses_by_name().items():
        if not (np.isfinite(mass) and mass > 0):
            refuse(f"beads of {name} have the mass {mass:g}; allowed: numbers above 0")


def _check_members(particles, name, refuse):
    """Refuse a bond or an angle of a bead that is not there, or with a bead twice."""
    members, count = getattr(particles, f"{name}s"), particles.beads
    if (bad := (members < 0) | (members >= count)).any():
        number = int(np.argmax(bad.any(axis=1)))
        refuse(
            f"{name} {number} has bead {members[number][bad[number]][0]}, and beads go from 0 to "
            f"{count - 1}; the file lacks beads, or the {name} is wrong"
        )
    inside = np.sort(members, axis=1)
    if (twice := (inside[:, 1:] == inside[:, :-1]).any(axis=1)).any():
        beads = ", ".join(map(particles.called, members[np.argmax(twice)]))
        refuse(f"a bead is twice in the {name} of {beads}; remove it")
    _, first, times = np.unique(inside, axis=0, return_index=True, return_counts=True)
    if name == "bond" and (times > 1).any():
        one, other = map(particles.called, inside[first[np.argmax(times > 1)]])
        refuse(f"{one} and {other} are bonded {times.max()} times; keep one of these bonds")


def shear_of(scene: Scene) -> Shear | None:
    return scene.terms["shear"].record(scene) if "shear" in scene.terms else None


def box_at(scene: Scene, step: int, slid: int | None) -> tuple[float, ...]:
    """The box of a scene with its images where they are at a step; see `State` for ``slid``."""
    return tilted(scene.period, shear_of(scene), scene.dt, step, slid or 0)


def tilt_factors(box: Sequence[float]) -> list[float]:
    """xy, xz and yz of a box; zeros without shear."""
    slide = getattr(box, "slide", None)
    if slide is None:
        return [0.0] * len(FACTORS)
    axes = slide.flow, slide.gradient
    return [float(slide.tilt[0]) if pair == axes else 0.0 for pair in FACTORS]


def box_of_file(
    edges: Sequence[float], factors: Sequence[float] | np.ndarray, path: object
) -> tuple[float, ...]:
    """A box with tilt factors xy, xz and yz, if any, of which one may differ from 0.

    Refused if more than one do, or if it tilts by more than half an edge.
    """
    edges, tilts = tuple(map(float, edges)), [0.0 if abs(f) < UPRIGHT else f for f in factors]
    pairs = [pair for pair, tilt in zip(FACTORS, tilts) if tilt]
    if not pairs or not all(edge > 0 for edge in edges):
        return edges
    (flow, gradient), factor = pairs[0], next(filter(None, tilts))
    turns = float(factor) * edges[gradient] / edges[flow] if gradient < len(edges) else np.nan
    if len(pairs) > 1 or not abs(turns) <= 0.5 + ROUNDING:
        found = ", ".join(f"{factor:g}" for factor in factors)
        raise UserError(
            f"{path}: its box has the tilt factors {found}; allowed: one that is not 0, by which "
            "the box tilts by up to half an edge"
        )
    slid = round(float(np.clip(turns, -0.5, 0.5)) * TURN) % TURN
    from dpd.physics.shear import Shear

    return tilted(edges, Shear(0.0, flow, gradient), 1.0, 0, slid)


def in_tilted_box(particles: Particles) -> tuple[np.ndarray, np.ndarray]:
    """Positions and images of beads put into the tilted box, as other programs want them."""
    position, image = particles.position.copy(), particles.image.copy()
    slide = getattr(particles.box, "slide", None)
    if slide is not None:
        edge = particles.box[slide.flow]
        turns = np.floor(along_axes(position, particles.box)[slide.flow] / edge)
        position[slide.flow] -= edge * turns
        image[slide.flow] += turns.astype(image.dtype)
    return position, image


def centre(box: Sequence[float]) -> np.ndarray:
    """(dimension, 1) array: the middle of a box, tilted or not, whose corner is at 0."""
    middle, slide = 0.5 * np.array(box, dtype=float), getattr(box, "slide", None)
    if slide is not None:
        middle[slide.flow] += slide.tilt[0] * middle[slide.gradient]
    return middle[:, None]
