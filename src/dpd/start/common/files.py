"""First configurations and files: made once for all runs; or read from a file of any origin."""

import json
import time
from collections import defaultdict
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from dpd import files
from dpd.digests import start_sources
from dpd.engine.loop import arrays_of, put_back
from dpd.engine.space import along_axes, unfolded
from dpd.engine.state import State
from dpd.errors import UserError, shown
from dpd.particles import read
from dpd.particles.netcdf import STATE
from dpd.particles.particles import (
    UPRIGHT,
    Particles,
    each_molecule,
    in_order,
    of_state,
    shear_of,
    spanned,
    whole_images,
)
from dpd.scene.scene import Scene
from dpd.start import start_description, start_digest
from dpd.start.common.make import make_start, species_of, system_of, thermal_velocities

SAME = 1e-6  # relative difference of edges that counts for none: files have single precision
REMEDY = (
    "let snakemake make it again; for a run of your own name a file for --start that is not there "
    "yet: the first configuration is made and kept in it"
)


def write_start(
    scene: Scene,
    path: str | Path,
    progress: Callable[[int], object] | None = None,
    say: Callable[[str], object] | None = None,
) -> None:
    """Make the first configuration of a scene, see `make_start`, and write it."""
    begun = time.perf_counter()
    state = make_start(scene, progress, say)
    attributes: dict[str, Any] = {
        "scene": json.dumps(scene.data),  # of one of the runs that share the start
        "start": json.dumps(start_description(scene)),
        "start_digest": start_digest(scene),
        "start_sources": start_sources(scene),
        "seconds": time.perf_counter() - begun,
    }
    files.write(path, {}, attributes, {STATE: arrays_of(state, ())})


def read_start(scene: Scene, path: str | Path) -> State:
    """Read a first configuration; refused if of another scene or other sources, or damaged."""
    attributes = files.attributes(path)
    if (found := attributes.get("start_digest")) != start_digest(scene):
        raise UserError(
            f"{path}: not the first configuration of {scene.where} (start_digest {found}, now "
            f"{start_digest(scene)}); {REMEDY}"
        )
    files.check_digest(path, attributes, "start_sources", start_sources(scene), REMEDY)
    state = put_back(files.read(path, STATE)[0], ())
    with files.reading(path, remedy=REMEDY):
        of_state(scene, state).checked(path)
    return state


def begin(
    scene: Scene, path: Path, progress: Callable[[int], object] | None, say: Callable[[str], object]
) -> tuple[Scene, State]:
    """Begin a run of one's own with the first configuration in a file, made if it is not there."""
    if not path.exists():
        if path.suffix.lower() != ".nc":
            raise UserError(
                f"{path}: there is no such file to start from. (A name in .nc that is not there "
                "yet would be made.)"
            )
        write_start(scene, path, progress, say)
    found = begins_with(scene, path, say)
    return found, read_start(found, path) if found is scene else make_start(found, progress, say)


def begins_with(scene: Scene, path: Path, say: Callable[[str], object]) -> Scene:
    """The scene that `begin` runs: the same one, if its start is in the file."""
    attributes = files.attributes(path) if path.suffix.lower() == ".nc" else {}
    if "start_digest" in attributes and attributes["start_digest"] == start_digest(scene):
        if attributes.get("start_sources") == start_sources(scene):
            return scene
        say(f"{path}: made by other sources than today's, which may make other bits of it")
    if "scene_digest" in attributes and int(attributes.get("seed", -1)) == scene.data["seed"]:
        say(
            f"{path}: its run had the seed {scene.data['seed']} as well, so the same noise comes "
            "again; another 'seed' makes the two independent"
        )
    return starting_from(scene, path)


def starting_from(scene: Scene, path: Path) -> Scene:
    """The same scene with its first configuration from a file, as it stands there."""
    same = {key: scene.data["start"][key] for key in ("kT", "seed") if key in scene.data["start"]}
    start = same | {"method": "file", "path": str(path)}
    return Scene(scene.data | {"start": start}, scene.where)


# --- a file of any origin


def state_from_file(scene: Scene, say: Callable[[str], object]) -> State:
    """The file that a scene names, at step 0; `UserError` if it, or its system, is another."""
    path = scene.start.path
    particles = read(path, scene.start.read_frame)
    said = list(particles.left_out)
    if particles.dimension == scene.dimension:
        particles = _between_walls(scene, particles, path)
    order = order_of(scene, particles, path)
    if scene.barostat_axes and not np.allclose(scene.box, particles.box, SAME, 0):
        edges = _edges(particles.box, " x ")
        said.append(f"its box of {edges} is that of the start, instead of the scene's")
    if (order != np.arange(len(order))).any():
        said.append("its molecules are in another order, so beads are numbered as in the scene")
    if particles.types and not scene.types:
        said.append("no law has the name of a type of its bonds or angles: species decide")
    there, own = particles.masses_by_name(), scene.data.get("mass", {})
    if other := [name for name in scene.species if there.get(name, 1) != own.get(name, 1)]:
        masses = ", ".join(f"{name} {there.get(name, 1):g}" for name in other)
        said.append(f"it has other masses than the scene ({masses}); those of the scene count")
    species, velocity = species_of(scene), particles.velocity
    if velocity is None:
        description = start_description(scene)
        kT, rng = description["kT"], np.random.default_rng(description["seed"])
        mass: Any = system_of(scene).mass_of(species)
        in_file = mass if np.ndim(mass) == 0 else mass[np.argsort(order)]
        velocity = thermal_velocities(particles.position.shape, kT, rng, in_file)
        said.append(f"it has no velocities, so they are drawn at kT {kT:g}")
    position, image = particles.position[:, order], particles.image[:, order]
    image = whole_images(scene.molecules, position, image, particles.box)
    one, other = unfolded(position, image, particles.box)[:, scene.bonded.T].swapaxes(0, 1)
    across = abs(along_axes(one - other, particles.box)) > np.array(particles.box)[:, None] / 2
    if through := len(np.unique(particles.molecules[order[scene.bonded[across.any(axis=0), 0]]])):
        said.append(
            f"molecules that are bonded to their own images, as a gel is: {through}; the sizes of "
            "such a one, as its radius of gyration, are those of one image"
        )
    for sentence in said:
        say(f"{path}: {sentence}")
    identity = np.arange(len(order), dtype=np.uint32)
    return State(
        position, velocity[:, order], None, identity, species, 0,
        slid=_slid(scene, particles.box, path),
        box=particles.box if scene.barostat_axes else None,
        image=image,
    )  # fmt: skip


def _slid(scene, box, path):
    """By how much images have slid in the file, see `State`; refused where the scene has none."""
    if abs(getattr(box, "tilt", 0.0)) < UPRIGHT:
        return None
    axes, shear = (box.slide.flow, box.slide.gradient), shear_of(scene)
    if shear is None or (shear.flow, shear.gradient) != axes or scene.start.relax:
        raise UserError(
            f"{path}: its box is tilted by shear with the flow along {'xyz'[axes[0]]} and the "
            f"gradient along {'xyz'[axes[1]]}, and {scene.where} has no such shear, or relaxes its "
            "start at rest by start.relax; take that shear, or a file whose box has right angles"
        )
    return box.slid


def _between_walls(scene, particles, path):
    """Particles whose box ends in the gaps behind the walls of a scene, about the same middle."""
    edges, position = list(particles.box), particles.position.copy()
    for axis in scene.ended:
        if edges[axis] < scene.box[axis] * (1 - SAME):
            continue  # which is refused like any other box that is too small
        one, other = position[axis, particles.bonds.T]
        if (np.abs(one - other) > 0.5 * edges[axis]).any():
            raise UserError(
                f"{path}: molecules are bonded through the face at which a wall of {scene.where} "
                "stands; make them whole before"
            )
        position[axis] += 0.5 * (scene.period[axis] - edges[axis])
        edges[axis] = scene.period[axis]
    return particles._replace(box=tuple(edges), position=position) if scene.ended else particles


def order_of(scene: Scene, particles: Particles, path: str) -> np.ndarray:
    """(n,) int64 numbers in the file of the scene's beads; `UserError` for another system.

    Molecules of a kind come in the order of their first beads; their beads as in the architecture,
    or in an order in which a walk from the first bead, deeper first, comes to the same.
    """
    wanted = tuple(  # the scene's edges, but for those that constant pressure changes
        there if scene.barostat_axes in ("all", name) else own
        for own, there, name in zip(scene.period, particles.box, "xyz")
    )
    if particles.dimension != scene.dimension or not np.allclose(wanted, particles.box, SAME, 0):
        raise UserError(
            f"{path}: its box is [{_edges(particles.box)}], and that of {scene.where} "
            f"[{_edges(scene.period)}]; they have to agree: write 'box: [{_edges(particles.box)}]' "
            "in the scene, or take another file"
        )
    used = [particles.names[k] for k in np.unique(particles.species)]
    if unknown := [name for name in used if name not in scene.species]:
        raise UserError(
            f"{path}: it has beads of the species {shown(unknown[0])}, and {scene.where} has "
            f"{', '.join(scene.species)}; rename one or the other"
        )
    place = [scene.species.index(name) if name in scene.species else 0 for name in particles.names]
    species, order = np.array(place)[particles.species], []
    own, bonds = (np.unique(np.sort(each), axis=0) for each in (scene.bonded, particles.bonds))
    same = np.array_equal(species, scene.kinds) and np.array_equal(own, bonds)
    laws = scene.laws_by_type
    typed = {k: n for k, n in particles.types.items() if " ".join([n] * len(k)) in laws}
    if same and typed in ({}, scene.types):
        return np.arange(len(species))
    found = defaultdict(list)
    for beads, inside, types in each_molecule(particles._replace(types=typed)):
        key, walk = _content(species[beads], inside, types)
        found[key].append(beads[walk])
    for kind, given in zip(scene.molecules, scene.data["molecules"]):
        own = np.array([scene.species.index(name) for name in kind.beads])
        types = [*kind.types] if typed else []
        key, walk = _content(own, np.unique(kind.bonds, axis=0), types)
        there = [beads[np.argsort(walk)] for beads in found[key]]
        if len(there) < kind.count:
            raise UserError(
                f"{path}: it has {len(there)} molecules {shown(given['architecture'], str)} for "
                f"{kind.count} of {scene.where} (in the file: {_counted(scene, species)}); take "
                "another, or leave out 'molecules', which are those of the file then"
            )
        order += there[: kind.count]
        del found[key][: kind.count]
    if more := sum(map(len, found.values())):
        raise UserError(
            f"{path}: it has {more} molecules more than {scene.where} (in the file: "
            f"{_counted(scene, species)}); add them"
        )
    return np.concatenate(order)


def _content(species, bonds, types):
    """What tells kinds of molecules apart, and the walk through one in which it is found."""
    walk, parents, rings = spanned(len(species), bonds)
    typed = in_order(types, walk)
    return (species[walk].tobytes(), parents.tobytes(), rings.tobytes(), typed), walk


def _edges(box, between=", "):
    return between.join(f"{edge:.9g}" for edge in box)


def _counted(scene, species):
    """How many beads there are of each species that there is."""
    counts = zip(np.bincount(species, minlength=len(scene.species)), scene.species)
    return ", ".join(f"{count} {name}" for count, name in counts if count)
