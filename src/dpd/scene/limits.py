"""What a scene may ask for: sizes that can be run, and settings that have an effect."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from dpd.errors import UserError
from dpd.page import MOST_STEPS
from dpd.scene.architecture import length_of
from dpd.scene.start import relaxing, start_forces

if TYPE_CHECKING:
    from dpd.page import Refusals
    from dpd.scene.scene import Scene

CUTOFF = 1.0
MOST_BEADS = 10**8  # 31 GB of state
MOST_WORK = 10**15  # bead-steps: about two years on one core
MOST_SPECIES = 256  # a bead's species is one byte
MOST_CELLS = 2**26  # cells of one cutoff in the box: half a gigabyte of counters
# Share by which whole molecules may miss the density that is asked for: 1 % changes the pressure,
# which goes with the square of the density, by 2 %.
MOST_MISSED = 0.01


def check_beads(data: dict[str, Any], where: str) -> None:
    """Refuse more beads than fit, before molecules are written out bead by bead.

    Parameters
    ----------
    data : dict
        A valid scene with defaults.
    where : str
        File to name in messages.

    Raises
    ------
    UserError
    """
    box = data["box"]
    volume = float(np.prod(box if isinstance(box, list) else [box] * data["dimension"]))
    total = 0
    for place, kind in enumerate(data["molecules"]):
        length = length_of(kind["architecture"], f"{where}: molecules.{place}.architecture")
        beads = (
            max(length, kind["density"] * volume) if "density" in kind else kind["count"] * length
        )
        total += beads
        if total > MOST_BEADS:
            key = "density" if "density" in kind else "count"
            raise UserError(
                f"{where}: molecules.{place}.{key}: {kind[key]:g} makes {total:.3g} beads in all; "
                f"allowed: <= {MOST_BEADS}"
            )


def limits(scene: Scene) -> Refusals:
    """What is too large or too small, and settings that would be without effect.

    Yields
    ------
    tuple of str
        A key, and what is wrong.
    """
    if len(scene.species) > MOST_SPECIES:
        yield "molecules", f"{len(scene.species)} species; allowed: <= {MOST_SPECIES}"
    yield from _of_box(scene)
    yield from _of_length(scene)
    yield from _of_start(scene)


def _of_box(scene):
    """Edges and volume."""
    for edge in scene.period:
        if edge < 2 * (CUTOFF + scene.skin):
            yield (
                "pairs.skin",
                f"{scene.skin:g} needs a box of at least {2 * (CUTOFF + scene.skin):g}, an edge "
                f"is {edge:g}; use search: cells",
            )
    if scene.volume > MOST_CELLS:
        yield "box", f"a volume of {scene.volume:g} is too large; allowed: <= {MOST_CELLS}"


def densities(scene: Scene) -> Refusals:
    """Densities that whole molecules cannot meet."""
    for place, (kind, given) in enumerate(zip(scene.molecules, scene.data["molecules"])):
        if kind.count < 1:
            yield (
                f"molecules.{place}.density",
                f"{given['density']:g} is not one molecule of {len(kind.beads)} beads in a box of "
                f"{scene.volume:g} r_c^{scene.dimension}",
            )
    for density in scene.missed_densities:
        if density.share > MOST_MISSED and density.found:
            fitting = (density.found / density.asked) ** (1 / scene.dimension)
            edges = ", ".join(f"{fitting * edge:.6g}" for edge in scene.box)
            edges = f"[{edges}]" if isinstance(scene.data["box"], list) else edges.split(",")[0]
            count = scene.molecules[density.place].count
            yield (
                f"molecules.{density.place}.density",
                f"{density.asked:g} is not met: {scene.sizes(density)}, {density.share:.1%} off; "
                f"allowed: {MOST_MISSED:.0%}. Write 'box: {edges}', in which {count} of them fit, "
                f"or 'count: {count}' instead of the density",
            )


def _of_length(scene):
    """Steps and bead-steps of relaxation and run."""
    if scene.steps.sample < 1:
        yield "steps.sample", "nothing to sample; set steps.sample or duration.sample"
    steps = sum(scene.steps) + relaxing(scene)
    work = scene.beads * steps
    if steps > MOST_STEPS or work > MOST_WORK:
        yield (
            "steps and duration",
            f"{steps:.3g} steps, {work:.3g} bead-steps; allowed: <= {MOST_STEPS:.0e} steps and "
            f"<= {MOST_WORK:.0e} bead-steps, about two years on one core",
        )


def _of_start(scene):
    """Forces of growth and relaxation, which act there as whole forces."""
    own = scene.data["start"]["forces"]
    by_species = scene.friction.ndim == 1 if isinstance(scene.friction, np.ndarray) else False
    if by_species and "gamma" not in own and scene.start.acts:
        yield (
            "thermostat.gamma",
            "one value for each species, and the start is relaxed or grown with friction between "
            "pairs; add start.forces.gamma, as 4.5",
        )
    forces = start_forces(scene)
    core = forces.get("core", {})
    for key in ("radius", "force"):
        if "core" in own and key not in core:
            yield (
                "start.forces.core",
                f"the key {key!r} is missing, and the scene has no 'core' to take it from",
            )
    if 2 * core.get("radius", 0) + core.get("smooth", 0) > CUTOFF:
        yield (
            "start.forces.core",
            f"a core of diameter {2 * core['radius']:g} and an edge of {core.get('smooth', 0):g} "
            "go past the cutoff; allowed: <= 1 together",
        )
