"""``start: {method: file}``: the first configuration is read from a file of any origin.

A scene numbers its beads molecule after molecule; a file may have them in any other order. Which
molecule of the file is which of the scene, and bead which bead, its bonds and species say.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from typing import TYPE_CHECKING, Any

import numpy as np

from dpd.engine.state import State
from dpd.errors import UserError, shown
from dpd.particles.formats import read
from dpd.particles.particles import UPRIGHT, Particles, molecules_of, shear_of, whole_images
from dpd.scene.molecules import middle_of
from dpd.start import start_description
from dpd.start.common.make import species_of, system_of, thermal_velocities

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from dpd.scene.scene import Scene

SAME = 1e-6  # relative difference of edges that counts for none: files have single precision


def state_from_file(scene: Scene, say: Callable[[str], object]) -> State:
    """Read the first configuration that a scene names, as a state with no force yet and step 0.

    Beads are renumbered where the file has the molecules in another order. Velocities are drawn at
    the temperature of the start where the file has none. All such things are said. A `UserError`
    refuses a file that cannot be read, is another than when the scene was read, or holds another
    system.
    """
    path = scene.start.path
    scene.start.refuse_other_file(scene.where)
    particles = read(path, scene.start.read_frame)
    said = list(particles.left_out)
    if particles.dimension == scene.dimension:
        particles = _between_walls(scene, particles, path)
    order = order_of(scene, particles, path)
    if scene.barostat_axes and not _same_box(scene.box, particles.box):
        edges = _edges(particles.box, " x ")
        said.append(f"its box of {edges} is that of the start, instead of the scene's")
    if (order != np.arange(len(order))).any():
        said.append("its molecules are in another order, so beads are numbered as in the scene")
    there, own = particles.masses_by_name(), scene.data.get("mass", {})
    if other := [name for name in scene.species if there.get(name, 1) != own.get(name, 1)]:
        masses = ", ".join(f"{name} {there.get(name, 1):g}" for name in other)
        said.append(f"it has other masses than the scene ({masses}); those of the scene count")
    if len(particles.angles) not in (0, len(scene.angled)):
        said.append(
            f"it has {len(particles.angles)} angles, and the scene {len(scene.angled)}; those of "
            "the scene act"
        )
    species, velocity = species_of(scene), particles.velocity
    if velocity is None:
        description = start_description(scene)
        kT, rng = description["kT"], np.random.default_rng(description["seed"])
        mass: Any = system_of(scene).mass_of(species)
        in_file = mass if np.ndim(mass) == 0 else mass[np.argsort(order)]
        velocity = thermal_velocities(particles.position.shape, kT, rng, in_file)
        said.append(f"it has no velocities, so they are drawn at kT {kT:g}")
    position, image = particles.position[:, order], particles.image[:, order]
    whole = whole_images(scene.molecules, position, image, particles.box)
    if image.any() and (whole != image).any():
        said.append(
            "by its images not all molecules are in one piece; beads are put at those at which "
            "their bonds pull"
        )
    for sentence in said:
        say(f"{path}: {sentence}")
    identity = np.arange(len(order), dtype=np.uint32)
    return State(
        position, velocity[:, order], None, identity, species, 0,
        slid=_slid(scene, particles.box, path),
        box=particles.box if scene.barostat_axes else None,
        image=whole,
    )  # fmt: skip


def _slid(scene, box, path):
    """By how much images have slid in the file, see `State`; refused where the scene has none."""
    if abs(getattr(box, "tilt", 0.0)) < UPRIGHT:
        return None
    axes, shear = (box.slide.flow, box.slide.gradient), shear_of(scene)
    if shear is None or (shear.flow, shear.gradient) != axes:
        raise UserError(
            f"{path}: its box is tilted by shear with the flow along {'xyz'[axes[0]]} and the "
            f"gradient along {'xyz'[axes[1]]}, and {scene.where} has no such shear; give it one, "
            "or take a file whose box has right angles"
        )
    if scene.start.relax:
        raise UserError(
            f"{scene.where}: start.relax: the box of {path} is tilted by shear, and relaxation is "
            "at rest; remove the key, or take a file whose box has right angles"
        )
    return box.slid


def _between_walls(scene, particles, path):
    """The beads of a file between the walls of a scene; as they are for a scene without walls.

    The middle of the file's box is taken for the middle between the planes. So a box may be as
    long as the distance of the planes, or longer by some empty space, as this program writes it.
    """
    edges, position = list(particles.box), particles.position.copy()
    for axis in scene.ended:
        apart, period, name = scene.box[axis], scene.period[axis], "xyz"[axis]
        if edges[axis] < apart * (1 - SAME):
            raise UserError(
                f"{path}: its box has an edge of {edges[axis]:.9g} along {name}, and the walls of "
                f"{scene.where} are {apart:.9g} apart; they have to be nearer, or take another file"
            )
        position[axis] += 0.5 * (period - edges[axis])
        reach = scene.origin[axis] - 1.0  # the rest of the gap is for the cutoff
        depth = np.abs(position[axis] - 0.5 * period) - 0.5 * apart
        bead = int(np.argmax(depth))
        if depth[bead] > reach:
            raise UserError(
                f"{path}: {particles.called(bead)} would be {depth[bead]:.3g} r_c behind a wall "
                f"along {name}; allowed: {reach:g}. The walls of {scene.where} are about the "
                "middle of the file's box; make them further apart, or take another file"
            )
        one, two = particles.bonds.T
        torn = np.abs(position[axis, one] - position[axis, two]) > 0.5 * edges[axis]
        if torn.any():
            raise UserError(
                f"{path}: {particles.called(int(one[torn.argmax()]))} is bonded through the face "
                f"at which a wall of {scene.where} stands; make molecules whole before"
            )
        edges[axis] = period
    return particles._replace(box=tuple(edges), position=position) if scene.ended else particles


# --- which bead of a file is which bead of a scene


def order_of(scene: Scene, particles: Particles, path: str) -> np.ndarray:
    """(n,) int64 array: the number in the file of each bead of the scene.

    Molecules of a kind are taken in the order of their first beads. Where the file has all beads
    as the scene numbers them, these are 0, 1, 2 and so on. A `UserError` names the first difference
    of box, species or molecules.
    """
    _check_box(scene, particles, path)
    species = _numbers_of_species(scene, particles, path)
    own, there = (np.unique(np.sort(each), axis=0) for each in (scene.bonded, particles.bonds))
    if np.array_equal(species, scene.kinds) and np.array_equal(own, there):
        return np.arange(len(species))
    codes: dict[tuple[int, ...], int] = {}
    found = _trees_of(particles, species.tolist(), codes, path)
    kinds = [
        canonical(kind.neighbours, [scene.species.index(name) for name in kind.beads], 0, codes)
        for kind in scene.molecules
    ]
    needed, order = Counter[int](), []
    for kind, (code, _) in zip(scene.molecules, kinds):
        needed[code] += kind.count
    for place, (kind, (code, beads)) in enumerate(zip(scene.molecules, kinds)):
        trees, text = found[code], shown(scene.data["molecules"][place]["architecture"], str)
        if len(trees) < needed[code]:
            raise UserError(
                f"{path}: it has {len(trees)} molecules {text} for the {needed[code]} of "
                f"{scene.where} (beads in the file: {_counted(scene, species)}; in the scene "
                f"{scene.beads} in all); take another file, or change 'molecules'"
            )
        numbers = np.empty((kind.count, len(beads)), np.int64)
        numbers[:, beads], found[code] = trees[: kind.count], trees[kind.count :]
        needed[code] -= kind.count
        order.append(numbers.ravel())
    if more := [beads for trees in found.values() for beads in trees]:
        first = min(more, key=min)
        raise UserError(
            f"{path}: it has {len(more)} molecules more than {scene.where}; the first, with "
            f"{particles.called(min(first))}, has {_counted(scene, species[first])}; add them to "
            "'molecules', or take another file"
        )
    return np.concatenate(order)


def _trees_of(particles, species, codes, path):
    """Beads of all molecules by their codes; refused is one with a ring."""
    molecule = molecules_of(particles)
    bonds = np.bincount(molecule[particles.bonds[:, 0]], minlength=molecule.max() + 1)
    ringed = (bonds >= np.bincount(molecule))[molecule]
    if ringed.any():
        raise UserError(
            f"{path}: {particles.called(ringed.argmax())} is of a molecule with a ring; molecules "
            "are chains or trees here"
        )
    neighbours: list[list[int]] = [[] for _ in range(particles.beads)]
    for one, other in particles.bonds.tolist():
        neighbours[one].append(other)
        neighbours[other].append(one)
    found = defaultdict(list)
    for bead in np.sort(np.unique(molecule, return_index=True)[1]).tolist():
        code, beads = canonical(neighbours, species, bead, codes)
        found[code].append(beads)
    return found


def canonical(
    neighbours: Sequence[Sequence[int]], species: Sequence[int], bead: int,
    codes: dict[tuple[int, ...], int],
) -> tuple[int, list[int]]:  # fmt: skip
    """The code of the tree that a bead is of, and its beads: n-th is n-th where codes agree.

    The tree hangs by its middle. The code of a bead, out of ``codes``, says its species and the
    codes of the beads that hang on it (Aho, Hopcroft and Ullman 1974).
    """
    found = []
    for root in sorted(set(middle_of(neighbours, bead))):
        above, order = {root: -1}, [root]
        for one in order:  # which grows
            for other in neighbours[one]:
                if other != above[one]:
                    above[other] = one
                    order.append(other)
        below: defaultdict[int, list[int]] = defaultdict(list)
        code: dict[int, int] = {}
        for one in reversed(order):
            below[one].sort(key=lambda each: (code[each], each))
            content = species[one], *(code[each] for each in below[one])
            code[one] = codes.setdefault(content, len(codes))
            below[above[one]].append(one)
        order = [root]
        for one in order:  # which grows
            order += below[one]
        found.append((code[root], order))
    return min(found)


def _check_box(scene, particles, path):
    if len(particles.box) != scene.dimension:
        raise UserError(
            f"{path}: it has {len(particles.box)} dimensions, and {scene.where} has "
            f"{scene.dimension}; take another file, or change 'dimension'"
        )
    wanted = tuple(  # the scene's edges, but for those that constant pressure changes
        there if scene.barostat_axes in ("all", name) else own
        for own, there, name in zip(scene.period, particles.box, "xyz")
    )
    if not _same_box(wanted, particles.box):
        raise UserError(
            f"{path}: its box is [{_edges(particles.box)}], and that of {scene.where} "
            f"[{_edges(scene.period)}]; they have to agree: write 'box: [{_edges(particles.box)}]' "
            "in the scene, or take another file"
        )


def _same_box(one, other):
    return np.allclose(one, other, rtol=SAME, atol=0)


def _edges(box, between=", "):
    return between.join(f"{edge:.9g}" for edge in box)


def _numbers_of_species(scene, particles, path):
    """Species of each bead of the file, as the scene numbers them."""
    used = np.unique(particles.species)
    unknown = [particles.names[k] for k in used if particles.names[k] not in scene.species]
    if unknown:
        raise UserError(
            f"{path}: it has beads of the species {shown(unknown[0])}, and {scene.where} has "
            f"{', '.join(scene.species)}; rename one or the other (in LAMMPS data: type labels, or "
            "comments behind the masses)"
        )
    place = [scene.species.index(name) if name in scene.species else 0 for name in particles.names]
    return np.array(place)[particles.species]


def _counted(scene, species):
    """How many beads there are of each species that there is."""
    counts = zip(np.bincount(species, minlength=len(scene.species)), scene.species)
    return ", ".join(f"{count} {name}" for count, name in counts if count)
