"""One configuration of beads, whatever file it came from or goes to."""

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple, Self

import numpy as np

from dpd.engine.space import TURN, along_axes, slide_of, tilted, wrapped
from dpd.engine.state import State
from dpd.errors import UserError
from dpd.scene.molecules import Molecule, either_way, written
from dpd.scene.scene import Scene

ROUNDING = 1e-5  # of an edge: beads outside, tilts beyond half; single precision, text
FLAT = 1e-4  # r_c by which heights of beads of two dimensions may differ
MOST_IMAGES = 2**30  # boxes that a bead may be away
LARGEST_STEP = 10**18
# Tilt factors say how far the second or third vector of a box goes along the first or second axis,
# over its edge. Here positions stay in the upright box, whose images have slid.
FACTORS = (0, 1), (0, 2), (1, 2)  # axes of xy, xz and yz
UPRIGHT = 1e-9  # a tilt factor that is less is rounding: the box has right angles

NO_ANGLES = np.zeros((0, 3), np.uint32)


class Particles(NamedTuple):
    """Beads in the order of their identities, with their bonds."""

    box: tuple[float, ...]  # edges in r_c, from 0 on; a `TiltedBox` under shear
    position: np.ndarray  # (dimension, n) in r_c, inside the box
    image: np.ndarray  # (dimension, n) int32: how many boxes further the bead is
    velocity: np.ndarray | None  # (dimension, n) in r_c / tau; under shear about the flow
    species: np.ndarray  # (n,) uint8, numbers in names
    names: tuple[str, ...]
    bonds: np.ndarray  # (bonds, 2) uint32, identities of the two ends
    step: int = 0
    left_out: tuple[str, ...] = ()  # what the file held that has no place here, a sentence each
    angles: np.ndarray = NO_ANGLES  # (angles, 3) uint32, the middle bead in between
    masses: np.ndarray | None = None  # (names,) of a bead of each species; None where all are 1
    types: Mapping[tuple[int, ...], str] = {}  # of bonds and angles by beads, where they differ
    identity: np.ndarray | None = None  # what the file calls each bead; None for 0, 1 ...

    @property
    def dimension(self) -> int:
        return len(self.box)

    @property
    def beads(self) -> int:
        return self.position.shape[1]

    def called(self, bead: int | np.integer) -> str:
        """A bead as its file names it, for messages."""
        return f"bead {bead}" if self.identity is None else f"atom {self.identity[bead]}"

    def masses_by_name(self) -> dict[str, float]:
        """Mass of a bead of each species; nothing where all are 1."""
        return {} if self.masses is None else dict(zip(self.names, self.masses.tolist()))

    def __str__(self) -> str:
        edges = " x ".join(f"{edge:g}" for edge in self.box)
        counts = np.bincount(self.species, minlength=len(self.names))
        species = ", ".join(f"{count} {name}" for count, name in zip(counts, self.names))
        return (
            f"{self.beads} beads ({species}) with {len(self.bonds)} bonds in a box of {edges}, "
            f"with{'out' * (self.velocity is None)} velocities, at step {self.step}"
        )

    @property
    def molecules(self) -> np.ndarray:
        """(n,) numbers of molecules, from 0, by the bonds that hold them together."""
        from scipy.sparse import coo_array
        from scipy.sparse.csgraph import connected_components

        one, two = self.bonds.astype(np.int64).T
        table = coo_array((np.ones(len(one), np.int8), (one, two)), shape=(self.beads,) * 2)
        return connected_components(table, directed=False)[1]

    def numbered(self, kind: str) -> tuple[list[str], np.ndarray]:
        """Names of the types of bonds or angles, the kind itself for none; the number of each."""
        members = getattr(self, f"{kind}s").tolist() if self.types else ()
        names = [self.types.get(either_way(one), kind) for one in members]
        found, numbers = np.unique(names or [kind], return_inverse=True)
        return found.tolist(), np.broadcast_to(numbers, len(getattr(self, f"{kind}s")))

    def only(self, kept: np.ndarray) -> Self:
        """Some of the beads, with the bonds and angles among them."""
        number, velocity = (np.cumsum(kept) - 1).astype(np.uint32), self.velocity
        left = {one: name for one, name in self.types.items() if kept[[*one]].all()}
        return self._replace(
            position=self.position[:, kept],
            image=self.image[:, kept],
            velocity=None if velocity is None else velocity[:, kept],
            species=self.species[kept],
            bonds=number[self.bonds[kept[self.bonds].all(axis=1)]],
            angles=number[self.angles[kept[self.angles].all(axis=1)]],
            types={tuple(number[[*one]].tolist()): name for one, name in left.items()},
        )

    def in_tilted_box(self) -> tuple[np.ndarray, np.ndarray]:
        """Positions and images of beads put into the tilted box, as other programs want them."""
        position, image = self.position.copy(), self.image.copy()
        if slide := slide_of(self.box):
            edge = self.box[slide.flow]
            turns = np.floor(along_axes(position, self.box)[slide.flow] / edge)
            position[slide.flow] -= edge * turns
            image[slide.flow] += turns.astype(image.dtype)
        return position, image

    def checked(self, path: object, periodic: bool = False) -> Self:
        """Particles of a file that a simulation can begin with; `UserError` for others.

        Beads outside of the box by `ROUNDING` are put in; in a ``periodic`` one all, which is said.
        """

        def refuse_if(bad: Any, problem: str, remedy: str = "mend the file") -> None:
            if np.any(bad):
                which = f"{self.called(np.argmax(bad))} " if np.ndim(bad) else ""
                raise UserError(f"{path}: {which}{problem}; {remedy}")

        box, names, beads = np.array(self.box, dtype=float), self.names, self.beads
        edges = " x ".join(f"{edge:g}" for edge in box)
        refuse_if(len(box) not in (2, 3), f"has {len(box)} dimensions", "allowed: 2 or 3")
        sound = (np.isfinite(box) & (box > 0)).all()
        refuse_if(not sound, f"the box of {edges} has an edge that is not a positive number")
        refuse_if(not beads, "holds no beads", "at least one is needed")
        good = 0 <= self.step < LARGEST_STEP
        refuse_if(not good, f"is of a step that is not from 0 to {LARGEST_STEP:g}")
        arrays = {name: getattr(self, name) for name in ("position", "velocity", "image")}
        for name, array in arrays.items():
            if array is not None:
                wrong = array.shape != (len(box), beads)
                refuse_if(wrong, f"{name} is not {len(box)} numbers for each of {beads} beads")
                bad = ~np.isfinite(array).all(axis=0)
                refuse_if(bad, f"has a {name} that is not a finite number", "write it again")
        position, image, far = self._inside(box[:, None])
        away = ~(np.abs(image) < MOST_IMAGES).all(axis=0)
        remedy = "mend its position or its image flags"
        refuse_if(away, f"is {MOST_IMAGES} boxes away or more", remedy)
        refuse_if(
            far & (not periodic),
            f"is outside of the box of {edges} ({far.sum()} of {beads} are)",
            "wrap positions into the box, with image flags if they are to be kept, or mend the box",
        )
        twice = len(set(names)) < len(names)
        refuse_if(twice, f"kinds of beads have the same name ({', '.join(names)})", "rename one")
        refuse_if(
            (self.species < 0) | (self.species >= len(names)),
            f"is of a kind that is not one of the {len(names)} that are named",
        )
        for name, mass in self.masses_by_name().items():
            light = not (np.isfinite(mass) and mass > 0)
            refuse_if(light, f"beads of {name} have the mass {mass:g}", "allowed: numbers above 0")
        bonds, angles = self.bonds.reshape(-1, 2), self.angles.reshape(-1, 3)
        for name, members in {"bond": bonds, "angle": angles}.items():
            outside = (members < 0) | (members >= beads)
            refuse_if(outside.any(), f"{name}s have beads that are not from 0 to {beads - 1}")
            ordered = np.sort(members, axis=1)
            for bad in members[(ordered[:, 1:] == ordered[:, :-1]).any(axis=1)]:
                same = ", ".join(map(self.called, bad))
                refuse_if(True, f"a bead is twice in the {name} of {same}", "remove it")
        found, times = np.unique(np.sort(bonds, axis=1), axis=0, return_counts=True)
        for pair in found[times > 1]:
            ends = " and ".join(map(self.called, pair))
            refuse_if(True, f"{ends} are bonded more than once", "keep one of these bonds")
        wrapped_in = f"{far.sum()} beads outside of the box are put in, and their images counted"
        return self._replace(
            box=self.box if slide_of(self.box) else tuple(map(float, box)),
            position=position,
            image=image.astype(np.int32),
            velocity=None if self.velocity is None else self.velocity.astype(float),
            species=self.species.astype(np.uint8),
            bonds=bonds.astype(np.uint32),
            angles=angles.astype(np.uint32),
            types={either_way(one): name for one, name in self.types.items()},
            left_out=(*self.left_out, *[wrapped_in] * bool(far.any())),
        )

    def _inside(self, edges):
        """Positions in the box, their images, and which beads are outside beyond rounding."""
        box, position = self.box, self.position.astype(float)
        far = (position < -ROUNDING * edges) | (position > (1 + ROUNDING) * edges)
        if slide := slide_of(box):  # files may have them in the tilted box
            far[slide.flow] = False
        inside, _ = wrapped(position, box)
        image = self.image + np.rint(along_axes(position - inside, box) / edges)
        return inside, image, far.any(axis=0)


def whole_images(
    kinds: Sequence[Molecule], position: np.ndarray, image: np.ndarray, box: Sequence[float]
) -> np.ndarray:
    """Images, by identities, with which every molecule is in one piece: that of its first bead."""
    places, found, first = along_axes(position, box), image.copy(), 0
    for kind in kinds:
        end = first + kind.count * len(kind.beads)
        shape = len(box), kind.count, len(kind.beads)
        place, steps = (each[:, first:end].reshape(shape) for each in (places, found))
        parent, bead = kind.tree.T
        apart = place[:, :, bead] - place[:, :, parent]
        steps[:, :, 1:] = -np.rint(apart / np.array(box)[:, None, None])
        found[:, first:end] = kind.summed(steps).reshape(len(box), -1)
        first = end
    return found


def spanned(beads: int, bonds: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A molecule's beads in the order of a walk from its first one, deeper first.

    ``bonds``: (n, 2), each once. Returns the order, for each bead in it the one on which it hangs
    (-1 for the first), and, (rings, 2), the bonds that close rings: these as numbers in the order.
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import depth_first_order

    if beads == 1:  # of which a solvent has many
        return np.zeros(1, np.int64), np.full(1, -1), np.zeros((0, 2), np.int64)
    one, other = np.concatenate([bonds, bonds[:, ::-1]]).T
    table = coo_array((np.ones(len(one), np.int8), (one, other)), shape=(beads, beads)).tocsr()
    order, before = depth_first_order(table, 0)
    place = np.argsort(order)
    parents = np.concatenate([[-1], place[before[order[1:]]]])
    numbers = np.sort(place[bonds], axis=1)
    rings = numbers[parents[numbers[:, 1]] != numbers[:, 0]]
    return order, parents, rings[np.lexsort(rings.T[::-1])]


def molecules_of(particles: Particles) -> list[dict[str, Any]]:
    """Kinds of molecules as a scene has them; alike are those with beads in the same order."""
    found: dict[tuple, dict[str, Any]] = {}
    for beads, bonds, typed in each_molecule(particles):
        order, parents, rings = spanned(len(beads), bonds)
        types = in_order(typed, order)
        names = [particles.names[k] for k in particles.species[beads[order]]]
        key = tuple(names), tuple(parents.tolist()), rings.tobytes(), types
        kind = found.setdefault(key, {"architecture": written(names, parents), "count": 0})
        kind["count"] += 1
        if len(rings):
            kind["bonds"] = rings.tolist()
        for name in sorted({name for _, name in types}):
            of_type = [list(one) for one, other in types if other == name]
            kind.setdefault("types", {})[name] = of_type
    return list(found.values())


Types = list[tuple[tuple[int, ...], str]]  # of bonds and angles, with the beads of each


def in_order(types: Types, order: np.ndarray) -> tuple[tuple[tuple[int, ...], str], ...]:
    """Types by the places of beads in an order of them, sorted."""
    place = np.argsort(order) if types else order
    return tuple(sorted((either_way(place[[*one]].tolist()), name) for one, name in types))


def each_molecule(particles: Particles) -> Iterator[tuple[np.ndarray, np.ndarray, Types]]:
    """Beads of each molecule, ascending; its bonds, and their types, by their places in these."""
    molecule, bonds = particles.molecules, np.unique(np.sort(particles.bonds, axis=1), axis=0)
    each = np.split(np.argsort(molecule, kind="stable"), np.cumsum(np.bincount(molecule))[:-1])
    types: dict[int, Types] = defaultdict(list)
    for one, name in particles.types.items():
        if len({*molecule[[*one]].tolist()}) == 1:  # an angle may have beads of others
            types[molecule[one[0]]].append((one, name))
    of = np.searchsorted(np.sort(molecule[bonds[:, 0]]), np.arange(1, len(each)))
    bonds = bonds[np.argsort(molecule[bonds[:, 0]], kind="stable")].astype(np.int64)
    for beads, inside in sorted(zip(each, np.split(bonds, of)), key=lambda both: both[0][0]):
        own = ((np.searchsorted(beads, one), name) for one, name in types[molecule[beads[0]]])
        yield (
            beads,
            np.searchsorted(beads, inside),
            [(tuple(one.tolist()), name) for one, name in own],
        )


def of_scene(
    scene: Scene, box: tuple[float, ...], position: np.ndarray, image: np.ndarray,
    velocity: np.ndarray | None, step: int,
) -> Particles:  # fmt: skip
    """Beads of a scene in the order of their identities, with each molecule in one piece."""
    image = whole_images(scene.molecules, position, image, box)
    return Particles(
        box, position, image, velocity, scene.kinds, scene.species, scene.bonded, step,
        angles=scene.joined[3][0], masses=scene.masses, types=scene.types,
    )  # fmt: skip


def of_state(scene: Scene, state: State) -> Particles:
    """The beads of a state, by their identities."""
    now = scene.during(state.step - 1, max(state.step, 1))[-1]  # with the rate that holds
    box = box_at(now, state.step, state.slid) if state.box is None else state.box
    position, velocity = (state.by_identity(each) for each in (state.position, state.velocity))
    return of_scene(scene, box, position, state.image, velocity, state.step)


def frame_number(frame: int, count: int, path: object) -> int:
    """A frame that may be counted from the last one, as -1, from 0 on; refused if not there."""
    if not -count <= frame < count:
        allowed = f"0 to {count - 1}, or -1 for the last, to {-count}" if count else "none"
        raise UserError(f"{path}: there is no frame {frame}; allowed: {allowed}")
    return frame % count


def shear_of(scene: Scene) -> Any:
    return scene.terms["shear"].records(scene)["shear"] if "shear" in scene.terms else None


def box_at(scene: Scene, step: int, slid: int | None) -> tuple[float, ...]:
    """The box of a scene with its images where they are at a step; see `State` for ``slid``."""
    return tilted(scene.period, shear_of(scene), scene.dt, step, slid or 0)


def tilt_factors(box: Sequence[float]) -> list[float]:
    """xy, xz and yz of a box; zeros without shear."""
    slide = slide_of(box)
    if slide is None:
        return [0.0] * len(FACTORS)
    axes = slide.flow, slide.gradient
    return [float(slide.tilt[0]) if pair == axes else 0.0 for pair in FACTORS]


def box_of_file(
    edges: Sequence[float] | np.ndarray, factors: Sequence[float] | np.ndarray, path: object
) -> tuple[float, ...]:
    """A box with tilt factors xy, xz, yz: one may differ from 0, by up to half an edge."""
    edges, tilts = tuple(map(float, edges)), [0.0 if abs(f) < UPRIGHT else f for f in factors]
    tilted_by = {pair: float(tilt) for pair, tilt in zip(FACTORS, tilts) if tilt}
    if not tilted_by or not all(edge > 0 for edge in edges):
        return edges
    (flow, gradient), factor = next(iter(tilted_by.items()))
    turns = factor * edges[gradient] / edges[flow] if gradient < len(edges) else np.nan
    if len(tilted_by) > 1 or not abs(turns) <= 0.5 + ROUNDING:
        found = ", ".join(f"{factor:g}" for factor in factors)
        raise UserError(
            f"{path}: its box has the tilt factors {found}; allowed: one that is not 0, by which "
            "the box tilts by up to half an edge"
        )
    slid = round(float(np.clip(turns, -0.5, 0.5)) * TURN) % TURN
    from dpd.physics.shear import Shear  # which few runs need

    return tilted(edges, Shear(0.0, flow, gradient), 1.0, 0, slid)


def centre(box: Sequence[float]) -> np.ndarray:
    """(dimension, 1) array: the middle of a box, tilted or not, whose corner is at 0."""
    middle, slide = 0.5 * np.array(box, dtype=float), slide_of(box)
    if slide is not None:
        middle[slide.flow] += slide.tilt[0] * middle[slide.gradient]
    return middle[:, None]
