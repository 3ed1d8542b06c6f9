"""What every scene says beside its terms and observables, and what is refused of a scene."""

import math
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field, field_validator

from dpd.page import (
    LARGEST_SEED,
    MOST_STEPS,
    BondForce,
    OneOr,
    OneOrMore,
    Refusals,
    Section,
    Species,
    Term,
    check_table,
    find,
    inside,
    names,
    no_species,
    setting,
)  # fmt: skip
from dpd.scene.molecules import either_way, graph_of

AXES = "xyz"
STAGES = 100  # of a ramp at most
CUTOFF = 1.0
MOST_BEADS = 10**8  # 31 GB of state
MOST_WORK = 10**15  # bead-steps: about two years on one core
MOST_SPECIES = 256  # a bead's species is one byte
MOST_CELLS = 2**26  # cells of one cutoff in the box: half a gigabyte of counters
# Share by which whole molecules may miss the density that is asked for: 1 % changes the pressure,
# which goes with the square of the density, by 2 %.
MOST_MISSED = 0.01
Edge = Annotated[float, Field(gt=0, le=1e6)]
Number = Annotated[int, Field(ge=0)]


class MoleculeKind(Section):
    """A kind of molecule, and how many of them there are."""

    architecture: str = setting(
        'A molecule as species and repeats, "A", "A 10" or "A 3 B 9 A 3". In brackets a branch, '
        'which hangs on the bead before it, "A 3 (B 2) (C 4 (D)) A 3"; or, with a number behind '
        'it, a group that is repeated along the chain, "(A 2 B) 4". A species is a letter, then '
        "letters, digits, _, + or -, as W1, tail or Na+. An o behind a bracket bonds its last bead "
        'to its first, "(A 20)o".'
    )
    bonds: list[Annotated[list[Number], Field(min_length=2, max_length=2)]] | None = setting(
        "More bonds, by the numbers of its beads from 0, as {architecture: A 20, bonds: [[0, 9]]}: "
        "with these it may be any network.", None,
    )  # fmt: skip
    types: dict[str, list[Annotated[list[Number], Field(min_length=2, max_length=3)]]] = setting(
        "Types of some bonds and angles, as {stiff: [[0, 1], [1, 2]]}. Where a law has the name of "
        "one, as in bond: {stiff: {stiffness: 50}}, it is theirs. A file may give them.", {},
    )  # fmt: skip
    density: float | None = setting(
        "Beads of these molecules per r_c^dimension.", None, gt=0, le=1000
    )
    count: int | None = setting("Number of molecules, instead of a density.", None, ge=1, le=10**8)
    weights: list[float] | None = setting(
        "Of several lengths, as in {architecture: 'A [8, 12, 20]', weights: [1, 2, 1]}: how many "
        "molecules have each; if not given, equally many.", None,
    )  # fmt: skip

    @field_validator("architecture")
    @classmethod
    def _readable(cls, text):
        graph_of(text)
        return text

    def wrong_bonds(self) -> Refusals:
        """Bonds of beads that there are not, or that are bonded already."""
        beads, parents, rings = graph_of(self.architecture)
        there = {*zip(parents, range(len(beads))), *rings}
        for place, (one, other) in enumerate(self.bonds or ()):
            pair = min(one, other), max(one, other)
            if pair[1] >= len(beads):
                yield str(place), f"{one}, {other}: allowed: two of 0 to {len(beads) - 1}"
            elif pair in there or one == other:
                yield str(place), f"{one}, {other}: bonded already, or the same bead; remove it"
            there.add(pair)


class Pairs(Section):
    """How pairs are found; it decides the speed, not the result."""

    search: Literal["auto", "cells", "list"] = setting(
        "Cells sorted every step, or a list that lasts while beads hardly move; auto takes the "
        "list where dt sqrt(kT / m) is up to 0.15 of the skin in two dimensions, 0.09 in three, "
        "and the box stays as it is.", "auto",
    )  # fmt: skip
    skin: float | None = setting(
        "Distance beyond the cutoff within which pairs are listed; 0.35 over the density, but 0.1 "
        "to 0.5, where it is left out.", None, unit="r_c", gt=0, le=1,
    )  # fmt: skip


class PageFile(Section):
    """A file with pages, as results name it."""

    path: str = setting("Where it lies.", min_length=1)
    sha256: str = setting("The digest that it must have.", min_length=1)


class Steps(Section):
    """Length of the run in steps."""

    equilibrate: int | None = setting("Steps before sampling begins.", None, ge=0, le=MOST_STEPS)
    sample: int | None = setting("Steps with sampling.", None, ge=1, le=MOST_STEPS)


class Duration(Section):
    """Length of the run in tau. If both steps and duration are given, the longer one counts."""

    equilibrate: float | None = setting("Time before sampling begins.", None, ge=0, le=1e9)
    sample: float | None = setting("Time with sampling.", None, gt=0, le=1e9)


class Scheduled(Section):
    """Values that hold from a step on."""

    step: int = setting(
        "Step of the run, equilibration included, behind which they hold.", ge=0, le=MOST_STEPS
    )
    set: dict[str, Any] = setting(
        "Values by their keys, which are joined by dots, as {integrator.dt: 0.02}.", min_length=1
    )


class Ramp(Section):
    """A number, or the edges of the box, going evenly from one value to another."""

    from_: OneOrMore[float] = Field(alias="from", description="The first value.")
    to: OneOrMore[float] = setting("The last value.")
    over: Literal["equilibrate", "sample"] = setting("The steps that it lasts.", "sample")

    def conflicts(self) -> Refusals:
        if np.shape(self.from_) != np.shape(self.to):
            yield "to", f"{self.to}: allowed: as many numbers as in from, {self.from_}"

    def stages(self, key: str, equilibrate: int, sample: int) -> list[dict[str, Any]]:
        """Its schedule, each stage with the value of its middle."""
        early = self.over == "equilibrate"
        begin, steps = (0, equilibrate) if early else (equilibrate, sample)
        number, found = min(STAGES, steps), []
        low, high = np.array(self.from_), np.array(self.to)
        for k in range(number):
            value = (low + (high - low) * (k + 0.5) / number).tolist()
            found.append({"step": begin + k * steps // number, "set": {key: value}})
        return [*found, {"step": equilibrate, "set": {key: self.to}}] if early else found


class Engine(Section):
    """Another engine than our own."""

    name: Literal["lammps"] = setting("Its name.")
    ranks: int = setting(
        "Processes that share the beads, on one machine or on several of a cluster.", 1, ge=1,
        le=10**5,
    )  # fmt: skip


class Basics(Section):
    """One system and how long it is simulated.

    Reduced units: length r_c, energy kT, mass m, time tau = sqrt(m r_c^2 / kT).
    """

    dimension: int = setting("Number of space dimensions.", ge=2, le=3)
    box: OneOrMore[Edge] = setting(
        "Edge of the periodic box, one number or one per axis; at least two cutoffs. Along an axis "
        "with walls the distance of the two planes. A ramp, as {from: 8, to: 6}, moves beads along "
        "and divides velocities by the same. If not given, that of the file of the start.",
        unit="r_c",
    )  # fmt: skip
    molecules: list[MoleculeKind] = setting(
        "What the box holds, in the order in which slabs are filled. If not given, what is in the "
        "file of the start, with its bonds.", min_length=1,
    )  # fmt: skip
    mass: dict[Species, Annotated[float, Field(ge=1e-3, le=1e6)]] | None = setting(
        "Mass of a bead of each species, as {A: 1, B: 2}; 1 for those that are not named.", None,
        unit="m", of="some species", min_length=1,
    )  # fmt: skip
    pairs: Pairs = setting(str(Pairs.__doc__), Pairs)
    steps: Steps = setting(str(Steps.__doc__), Steps)
    duration: Duration = setting(str(Duration.__doc__), Duration)
    schedule: list[Scheduled] | None = setting(
        "Values of forces, thermostat, integrator and the like that change while the system runs, "
        "in the order of their steps; `dpd.Simulation` writes down here what it was told.", None,
    )  # fmt: skip
    pages: list[OneOr[str, PageFile]] = setting(
        "Python files with pages of your own; a relative path counts from the file of the "
        "scene.", [],
    )  # fmt: skip
    observe: list[Any] = setting("What is measured, by name, or by name with settings.", ["thermo"])
    engine: Engine | None = setting(
        "What moves the beads, if not our own engine: {name: lammps, ranks: 8} is LAMMPS with MPI; "
        "starts, observables and results stay as they are.", None,
    )  # fmt: skip
    unstable: Literal["fail", "record"] = setting(
        "What happens if a run blows up or its bonds get too long for the box: it fails, or its "
        "result records that it did (for maps of stability).", "fail",
    )  # fmt: skip
    keep_state: bool | None = setting(
        "Whether run.nc keeps the last configuration, and what `dpd extend` needs to make the run "
        "longer. If not given, `dpd run` keeps it and a study does not.", None,
    )  # fmt: skip
    seed: int = setting("Seed of start and noise.", 1, ge=0, le=LARGEST_SEED)

    def conflicts(self) -> Refusals:
        """What sections have against each other, and molecules."""
        for place, kind in enumerate(self.molecules):
            if (kind.density is None) == (kind.count is None):
                yield f"molecules.{place}", "needs a density or a count, and not both"
            if kind.weights is not None:
                text = "one positive number for each of several lengths, as in 'A [8, 12, 20]'"
                yield f"molecules.{place}.weights", f"{kind.weights}: allowed: {text}"
            yield from inside(f"molecules.{place}.bonds", kind.wrong_bonds())
        edges = self.box if isinstance(self.box, list) else [self.box] * self.dimension
        if len(edges) != self.dimension:
            yield "box", f"{len(edges)} edges in {self.dimension} dimensions"
        elif min(edges) < 2 * CUTOFF:
            yield (
                "box",
                f"an edge of {min(edges):g} is smaller than two cutoffs, a bead would meet another "
                f"one twice; allowed: >= {2 * CUTOFF:g}",
            )
        total = 0.0
        for kind in self.molecules:  # before these are written out bead by bead
            length = len(graph_of(kind.architecture)[0])
            total += max(
                length, (kind.density or 0) * math.prod(edges) + (kind.count or 0) * length
            )
        if total > MOST_BEADS:
            yield "molecules", f"{total:.3g} beads in all are too many; allowed: <= {MOST_BEADS}"


# --- what is refused: names that there are not, sizes, pages that do not go together


def unknown_names(scene: Any) -> Refusals:
    """Axes and species that settings name, and that are not there."""
    if "mass" in scene.data:
        yield from inside("mass", check_table(scene.data["mass"], scene, zip(scene.species), ""))
    for key, term in scene.terms.items():
        yield from inside(key, term.unknown(scene))
    for place, kind in enumerate(scene.molecules):
        there = {either_way(b) for n in (2, 3) if kind.types for b in kind.along(n).tolist()}
        for beads, name in kind.types:
            if beads not in there:
                yield f"molecules.{place}.types.{name}", f"{[*beads]}: no bond or angle, or typed"
            there -= {beads}
    observe = {f"observe.{key}": page for key, page in scene.observe.items()}
    for key, page in ({**scene.terms, "start": scene.start} | observe).items():
        for name, field in type(page).model_fields.items():
            extra, value = field.json_schema_extra, getattr(page, name)
            if isinstance(extra, dict) and "of" in extra and value is not None:
                yield from inside(f"{key}.{name}", _unknown(scene, extra["of"], value))


def _unknown(scene, of, value):
    """Axes or species of a setting that are not there."""
    if isinstance(value, dict):
        example = "..." if of == "species" else ""
        yield from check_table(value, scene, zip(scene.species), example)
        return
    for name in value if isinstance(value, list) else [value]:
        if of == "axis" and name in AXES[scene.dimension :]:
            allowed = ", ".join(AXES[: scene.dimension])
            yield "", f"{name!r} is no axis in {scene.dimension} dimensions; allowed: {allowed}"
        elif of != "axis" and isinstance(value, list) and name not in scene.species:
            yield "", no_species(name, scene.species)


def missed_by(scene: Any, place: int) -> str:
    """What whole molecules of a kind make of the density that is asked for."""
    kind, (asked, found) = scene.molecules[place], scene.missed_densities[place]
    edges = " x ".join(f"{edge:g}" for edge in scene.box)
    return (
        f"{kind.count} molecules of {len(kind.beads)} beads in a box of {edges} make {found:.4g} "
        f"instead of {asked:g}, {abs(found / asked - 1):.2%} off"
    )


def densities(scene: Any) -> Refusals:
    """Densities that whole molecules cannot meet."""
    for place, (asked, found) in scene.missed_densities.items():
        if abs(found / asked - 1) > MOST_MISSED:
            yield (
                f"molecules.{place}.density",
                f"{missed_by(scene, place)}; allowed: {MOST_MISSED:.0%}. Change "
                f"the box, or write 'count: {max(1, scene.molecules[place].count)}'",
            )


def limits(scene: Any) -> Refusals:
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
    bonds = [key for key, term in scene.terms.items() if isinstance(term, BondForce)]
    if len(bonds) > 1:
        yield bonds[1], f"the scene has {bonds[0]!r} as well; keep one law of bonds"
    if scene.has_bonds and not bonds:
        pages = {key: find(Term, key) for key in names(Term)} | scene.own_pages
        known = {key: page for key, page in pages.items() if issubclass(page, BondForce)}
        example = next(f"'{key}: {page.example}'" for key, page in known.items() if page.example)
        text = f"those of several beads need a law of bonds, one of {', '.join(known)}"
        yield "molecules", f"{text}, as {example}"
    for key, page in [*scene.terms.items(), ("start", scene.start)]:
        yield from inside(key, page.refuses(scene))
    if "engine" in scene.data:
        for key, term in scene.terms.items():
            if isinstance(why_not := term.lammps(scene), str):
                yield key, f"{key!r} {why_not}; change it, or remove the key 'engine'"
        alone = {
            next(iter(scene.ramps), "schedule"): scene.data.get("schedule"),
            "unstable": scene.data["unstable"] != "fail",
        }
        for key in filter(alone.get, alone):
            yield key, "is for our own engine; remove the key, or the key 'engine'"
    for key, term in scene.terms.items():
        for change, other in scene.made.items():
            if other != key and (why := term.why_not(change)):
                yield key, f"{key!r} {why}; not allowed with {other!r}, remove one of them"
