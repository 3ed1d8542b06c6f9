"""What is refused of a scene: names that there are not, sizes, pages that do not go together."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from dpd.page import MOST_STEPS, BondForce, Term, check_species, find, inside, names, no_species

if TYPE_CHECKING:
    from collections.abc import Iterator

    from dpd.page import Page, Refusals
    from dpd.scene.scene import Scene

AXES = "xyz"
CUTOFF = 1.0
MOST_WORK = 10**15  # bead-steps: about two years on one core
MOST_SPECIES = 256  # a bead's species is one byte
MOST_CELLS = 2**26  # cells of one cutoff in the box: half a gigabyte of counters
# Share by which whole molecules may miss the density that is asked for: 1 % changes the pressure,
# which goes with the square of the density, by 2 %.
MOST_MISSED = 0.01


def unknown_names(scene: Scene) -> Refusals:
    """Axes and species that settings name, and that are not there."""
    if "mass" in scene.data:
        yield from inside("mass", check_species(scene.data["mass"], scene.species, ""))
    pages: dict[str, Page] = {**scene.terms, "start": scene.start}
    pages |= {f"observe.{key}": page for key, page in scene.observe.items()}
    for key, term in scene.terms.items():
        yield from inside(key, term.unknown(scene))
    for key, page in pages.items():
        for name, of, value in _named(page):
            yield from inside(f"{key}.{name}", _unknown(scene, of, value))


def _named(page: Page) -> Iterator[tuple[str, str, Any]]:
    """Settings that name axes or species, what they name, and their values."""
    for name, field in type(page).model_fields.items():
        extra, value = field.json_schema_extra, getattr(page, name)
        if isinstance(extra, dict) and "of" in extra and value is not None:
            yield name, str(extra["of"]), value


def _unknown(scene, of, value):
    if isinstance(value, dict):
        yield from check_species(value, scene.species, "..." if of == "species" else "")
        return
    for name in value if isinstance(value, list) else [value]:
        if of == "axis" and name in AXES[scene.dimension :]:
            allowed = ", ".join(AXES[: scene.dimension])
            yield "", f"{name!r} is no axis in {scene.dimension} dimensions; allowed: {allowed}"
        elif of != "axis" and isinstance(value, list) and name not in scene.species:
            yield "", no_species(name, scene.species)


def densities(scene: Scene) -> Refusals:
    """Densities that whole molecules cannot meet."""
    for place, (asked, found) in scene.missed_densities.items():
        key, kind = f"molecules.{place}.density", scene.molecules[place]
        if not found:
            volume = f"{scene.volume:g} r_c^{scene.dimension}"
            beads = f"one molecule of {len(kind.beads)} beads"
            yield key, f"{asked:g} is not {beads} in a box of {volume}"
        elif abs(found / asked - 1) > MOST_MISSED:
            fitting = (found / asked) ** (1 / scene.dimension)
            edges = [f"{fitting * edge:.6g}" for edge in scene.box]
            box = f"[{', '.join(edges)}]" if isinstance(scene.data["box"], list) else edges[0]
            yield (
                key,
                f"{asked:g} is not met: {scene.sizes(place)}, {abs(found / asked - 1):.1%} off; "
                f"allowed: {MOST_MISSED:.0%}. Write 'box: {box}', in which {kind.count} of them "
                f"fit, or 'count: {kind.count}' instead of the density",
            )


def limits(scene: Scene) -> Refusals:
    """What is too large or too small, and what sections and pages have against each other."""
    if len(scene.species) > MOST_SPECIES:
        yield "molecules", f"{len(scene.species)} species; allowed: <= {MOST_SPECIES}"
    reach, edge = 2 * (CUTOFF + scene.skin), min(scene.period)
    if edge < reach:
        text = f"{scene.skin:g} needs a box of at least {reach:g}, an edge is {edge:g}"
        yield "pairs.skin", f"{text}; use search: cells"
    if scene.volume > MOST_CELLS:
        yield "box", f"a volume of {scene.volume:g} is too large; allowed: <= {MOST_CELLS}"
    if scene.steps.sample < 1:
        yield "steps.sample", "nothing to sample; set steps.sample or duration.sample"
    steps = sum(scene.steps) + scene.relaxing
    work = scene.beads * steps
    if steps > MOST_STEPS or work > MOST_WORK:
        yield (
            "steps and duration",
            f"{steps:.3g} steps, {work:.3g} bead-steps; allowed: <= {MOST_STEPS:.0e} steps and "
            f"<= {MOST_WORK:.0e} bead-steps, about two years on one core",
        )
    per_bead = np.ndim(scene.friction) == 1
    if per_bead and scene.start.forces.gamma is None and scene.start.acts:
        yield (
            "thermostat.gamma",
            "one value for each species, and the start is relaxed or grown with friction between "
            "pairs; add start.forces.gamma, as 4.5",
        )
    yield from _bonds(scene)
    for key, page in [*scene.terms.items(), ("start", scene.start)]:
        yield from inside(key, page.refuses(scene))
    for key, term in scene.terms.items():
        for change, other in scene.made.items():
            if other != key and (why := term.why_not(change)):
                yield key, f"{key!r} {why}; not allowed with {other!r}, remove one of them"


def _bonds(scene):
    """One law for bonds where there are some."""
    bonds = [key for key, term in scene.terms.items() if isinstance(term, BondForce)]
    if len(bonds) > 1:
        yield bonds[1], f"the scene has {bonds[0]!r} as well; keep one law of bonds"
    if scene.has_bonds and not bonds:
        pages = {key: find(Term, key) for key in names(Term)} | scene.own_pages
        known = {key: page for key, page in pages.items() if issubclass(page, BondForce)}
        example = next(f"'{key}: {page.example}'" for key, page in known.items() if page.example)
        text = f"those of several beads need a law of bonds, one of {', '.join(known)}"
        yield "molecules", f"{text}, as {example}"
