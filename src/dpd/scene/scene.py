"""WHAT is simulated: a validated, hashable description that knows what it needs."""

from __future__ import annotations

import json
import math
import os
from functools import cached_property, partial
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from dpd.digest import value_digest
from dpd.errors import UserError, shown, suggestion
from dpd.own import blame, check_slope, file_of, load
from dpd.page import (
    BondForce,
    Change,
    Observable,
    Page,
    PairForce,
    Refusals,
    Start,
    Term,
    find,
    names,
)
from dpd.scene.architecture import tree_of
from dpd.scene.bonding import Joined, all_species, joined
from dpd.scene.changes import changed
from dpd.scene.limits import check_beads, densities, limits
from dpd.scene.molecules import MissedDensity, Molecule
from dpd.scene.schedule import Stage, enter
from dpd.scene.sections import Basics
from dpd.scene.yaml import read_yaml, value_of
from dpd.sentences import attempt

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

CUTOFF = 1.0
AXES = "xyz"
SMALL_STEP = {2: 0.005, 3: 0.001}  # dt sqrt(kT) in r_c, up to which a pair list pays, measured
NOTED_MISSED = 1e-4  # share of a density that whole molecules may miss unsaid: rounding
FINEST = 1.0  # r_c, thickness of layers across a flow
LEAST = 10  # beads in a cell, in the mean, for each function that is fitted to their velocities


class Steps(NamedTuple):
    """How many steps a run takes: to equilibrate, and then to sample."""

    equilibrate: int
    sample: int


class Scene:
    """One system and how long it is simulated.

    Parameters
    ----------
    data : dict
        As `dpd.scene.sections.Basics` and the pages that it names have it.
    where : str
        File to name in messages.
    folder : path
        From which the path of a file to start from counts; the working folder if not given.
    pages : list
        Of one's own, beside those that it names: files, or classes and functions of a file or of a
        notebook's cell.

    Attributes
    ----------
    terms : dict of str to Term
        By key.
    observe : dict of str to Observable
        By key, with ``every`` filled in.
    start : Start
    page_files : dict of str to str
        Digests of the files of one's own pages, by their whole paths.
    stages : list of Stage
        Itself, and with the values that change while it runs.

    Raises
    ------
    UserError
        If anything in it is not allowed, or does not fit together: a line for each mistake.
    """

    def __init__(
        self,
        data: dict[str, Any],
        where: str = "scene",
        folder: str | Path = "",
        pages: Iterable[Any] = (),
    ) -> None:
        if not isinstance(data, dict):
            raise UserError(f"{where}: {shown(data)} is no scene; allowed: keys and values")
        if isinstance(given := data.get("pages", []), list):
            data = data | {"pages": [*given, *map(file_of, pages)]}
        self.where = where
        # What was chosen for a scene that left scheme and step to us, as plain data: see `settle`.
        self.chosen = None  # type: dict[str, Any] | None
        self.terms: dict[str, Any] = {}
        self.start: Any = None
        self.observe: dict[str, Any] = {}
        self.page_files: dict[str, str] = {}
        self.stages: list[Stage] = []
        try:
            self._build(data, folder)
        except UserError:
            raise
        except (Exception, SystemExit) as problem:  # whatever a page of one's own may raise
            if told := blame(problem, self.page_files):
                raise UserError(f"{where}: {told}") from None
            raise

    def _build(self, data, folder):
        self._own = self._pages(data, folder)
        self._read(data)
        check_beads(self.data, self.where)
        self.start = self.start.found(folder, self.where)
        self.data["start"] = self.start.plain()
        self.terms = {key: term.found(folder, self.where) for key, term in self.terms.items()}
        self.refuse(densities(self))
        self.refuse(self._names())
        for key in self._own.keys() & self.terms.keys():
            check_slope(self.terms[key], self)
        for key, term in self.terms.items():
            self.terms[key] = term.completed(self)
            self.data[key] = self.terms[key].plain()
        self.refuse(self._refusals())
        self.observe = {key: self._with_interval(page) for key, page in self.observe.items()}
        self.refuse(self.unobserved(self.made))
        self.stages = [Stage(0, self)]
        for place, each in enumerate(self.data.get("schedule", [])):
            where = f"{self.where}: schedule.{place}"
            if each["step"] > (end := sum(self.steps)):
                raise UserError(f"{where}.step: {each['step']} is behind the end of the run, {end}")
            enter(self, each["step"], each["set"], where)

    @classmethod
    def of_result(cls, text: Any, where: str) -> Scene:
        """The scene that a result or a checkpoint holds.

        Files of pages are named there with their digests: only the file that made it is run.

        Raises
        ------
        UserError
            If it is damaged, or a file of pages is another one by now.
        """
        try:
            data = json.loads(text)
        except (ValueError, TypeError):
            data = None
        if not isinstance(data, dict):
            raise UserError(f"{where}: its attribute 'scene' is damaged; make the file anew")
        pages = data.get("pages", [])
        for page in pages if isinstance(pages, list) else [None]:
            named = page if isinstance(page, dict) else {}
            if not named.get("sha256") or not os.path.isabs(str(named.get("path", ""))):
                raise UserError(f"{where}: it names a file of pages without its digest")
        return cls(data, where)

    @classmethod
    def read(
        cls, path: str | Path, pages: Iterable[Any] = (), settings: Iterable[str] = ()
    ) -> Scene:
        """Read a scene from a YAML file; with more files of pages, and with some other values.

        The latter are as the option ``--set`` has them, ``KEY=VALUE``, with keys joined by dots.
        """
        data, where = read_yaml(path), str(path)
        for setting in settings:
            key, sign, text = setting.partition("=")
            if not key or not sign:
                raise UserError(f"--set {setting}: write KEY=VALUE, as --set integrator.dt=0.02")
            where += f", --set {setting}"
            data = changed(data, {key: value_of(text, f"--set {setting}")}, where)
        return cls(data, where, Path(path).parent, pages)

    def __repr__(self):
        edges = " x ".join(f"{edge:g}" for edge in self.box)
        equilibrate, sample = self.steps
        times = f"{self.tau(equilibrate):g} + {self.tau(sample, equilibrate):g} tau"
        given = zip(self.molecules, self.data["molecules"])
        lines = {
            "box": f"{edges} r_c",
            "beads": f"{self.beads}, {self.density:.4g} per r_c^{self.dimension}",
            "molecules": "; ".join(f"{k.count} of {each['architecture']}" for k, each in given),
            "bonds": str(len(self.bonded)) if self.has_bonds else "",
            **{
                key: _in_a_line(self.data[key])
                for key in ("mass", *self.terms, "schedule")
                if key in self.data
            },
            "steps": f"{equilibrate} to equilibrate, {sample} to sample ({times})",
            "observe": ", ".join(self.observe),
        }
        text = [f"  {name:12s}{value}" for name, value in lines.items() if value]
        return "\n".join([f"<dpd.Scene {self.where}>", *text, *(f"  {n}" for n in self.notes)])

    # --- reading

    def _pages(self, data, folder):
        """Observables of one's own, by key; files are named by their whole paths from then on."""
        found: dict[str, Any] = {}
        given = data.get("pages", [])
        for place, one in enumerate(given if isinstance(given, list) else []):
            named = one if isinstance(one, dict) else {"path": one, "sha256": ""}
            path, digest = named.get("path"), named.get("sha256")
            if not isinstance(path, str) or not isinstance(digest, str):
                continue  # which is told with all else that is wrong
            path = os.path.abspath(os.path.join(folder, path))
            loaded, now = load(path, f"{self.where}: pages.{place}", digest)
            if path not in self.page_files and (twice := sorted(found.keys() & loaded.keys())):
                raise UserError(
                    f"{self.where}: pages.{place}: {path}: {twice[0]!r} is a page of another file "
                    "as well; take another key"
                )
            found |= loaded
            self.page_files[path] = now
        return found

    def _read(self, data):
        """Settings of all sections and pages, with their defaults."""
        own = [key for key, page in self._own.items() if issubclass(page, Term)]
        kinds = [*names(Term), *own]
        sections = [*kinds, "start"]
        basic = {key: value for key, value in data.items() if key not in sections}
        basics, wrong = attempt(Basics, basic, more=sections)
        for key in kinds:
            if key in data or key in NEEDED:
                page = self._own[key] if key in own else find(Term, key)
                self.terms[key] = self._page(page, data, key, wrong)
        self.start = self._start(data.get("start", {}), wrong)
        for item in basics.observe if basics else ():
            self._add_observable(item, wrong)
        if not wrong:
            self._check_start_forces(self.start.forces, wrong)
        if wrong:
            raise UserError("\n".join(f"{self.where}: {text}" for text in dict.fromkeys(wrong)))
        self.data = basics.model_dump(exclude_none=True, by_alias=True, exclude={"pages"})
        self.data |= {key: term.plain() for key, term in self.terms.items()}
        self.data["start"] = self.start.plain()
        self.data["pages"] = [{"path": p, "sha256": d} for p, d in self.page_files.items()]

    def _page(self, page, data, key, wrong):
        if key not in data and page.has_required():
            wrong.append(f"the file: the key {key!r} is missing ({page.summary()})")
            return None
        found, problems = attempt(page, data.get(key, {}), key)
        wrong += problems
        return found

    def _start(self, given, wrong):
        """The first configuration, by its method."""
        own = {key: page for key, page in self._own.items() if issubclass(page, Start)}
        known, method = [*names(Start), *own], Start.model_fields["method"].default
        if isinstance(given, dict) and isinstance(given.get("method"), str):
            method = given["method"]
        if method not in known:
            wrong.append(f"start.method: {shown(method)} is not known; {suggestion(method, known)}")
            return None
        page = own.get(method) or find(Start, method)
        if isinstance(given, dict):
            given = _without_others(page, given, wrong)
        found, problems = attempt(page, given, "start")
        wrong += problems
        return found

    def _check_start_forces(self, forces, wrong):
        """Settings of the bonds that are others while the start is made."""
        for key, given in (forces.model_extra or {}).items():
            bond = self.bond_force
            if bond is None or key != bond.key:
                known = [*type(forces).model_fields, *([bond.key] if bond else [])]
                wrong.append(f"start.forces: unknown key {shown(key)}; {suggestion(key, known)}")
                continue
            changed = bond.changed(given) if isinstance(given, dict) else given
            wrong += attempt(type(bond), changed, f"start.forces.{key}")[1]

    def _add_observable(self, item, wrong):
        """An observable by name, or by name with settings."""
        if isinstance(item, dict) and len(item) != 1:
            wrong.append(f"observe: {shown(item)} should be one name with its settings, as a list "
                         "item: - rdf: {range: 3}")  # fmt: skip
            return
        name, settings = next(iter(item.items())) if isinstance(item, dict) else (item, {})
        own = {key: page for key, page in self._own.items() if issubclass(page, Observable)}
        known = [*names(Observable), *own]
        if name not in known:
            wrong.append(f"observe: {shown(name)} is not known; {suggestion(name, known)}")
        elif name in self.observe:
            wrong.append(f"observe: {name!r} is there more than once; keep one")
        else:
            page = own.get(name) or find(Observable, name)
            self.observe[name], problems = attempt(page, settings, f"observe.{name}")
            wrong += problems

    def _with_interval(self, page):
        """An observable that knows how many steps lie between its samples."""
        if page.every:
            return page
        every = max(1, min(page.steps_between(self), self.steps.sample))
        return page.model_copy(update={"every": every})

    # --- refusing

    def refuse(self, problems: Iterable[tuple[str, str]]) -> None:
        """Raise all problems, if there are any, each a key and a sentence."""
        found = dict.fromkeys(f"{self.where}: {key}: {text}" for key, text in problems)
        if found:
            raise UserError("\n".join(found))

    def _names(self) -> Refusals:
        """Axes and species that pages name, and that are not there."""
        for key, term in self.terms.items():
            for inside, problem in term.unknown(self):
                yield f"{key}.{inside}" if inside else key, problem
        sections = [("", self._masses()), *((f"{key}.", page) for key, page in self.terms.items())]
        sections += [("start.", self.start)]
        sections += [(f"observe.{key}.", page) for key, page in self.observe.items()]
        for inside, page in sections:
            for name, (of, value) in page.items() if isinstance(page, dict) else _named(page):
                key = f"{inside}{name}"
                if of == "axis":
                    yield from self._axes_there(key, value)
                elif isinstance(value, dict):
                    yield from self.check_species(key, value, None if of == "species" else "")
                else:
                    yield from self._species_there(key, value)

    def _masses(self):
        return {"mass": ("some species", self.data["mass"])} if "mass" in self.data else {}

    def _axes_there(self, key, value):
        for name in value if isinstance(value, list) else [value]:
            if name in AXES and AXES.index(name) >= self.dimension:
                allowed = ", ".join(AXES[: self.dimension])
                text = f"{name!r} is no axis in {self.dimension} dimensions; allowed: {allowed}"
                yield key, text

    def _species_there(self, key, names):
        for name in names if isinstance(names, list) else ():
            if name not in self.species:
                yield key, self.no_species(name)

    def _refusals(self) -> Refusals:
        """What sections and terms have against each other."""
        yield from limits(self)
        bonds = [key for key, term in self.terms.items() if isinstance(term, BondForce)]
        if len(bonds) > 1:
            yield bonds[1], f"the scene has {bonds[0]!r} as well; keep one law of bonds"
        if self.has_bonds and not bonds:
            pages = {key: find(Term, key) for key in names(Term)} | self._own
            known = [key for key, page in pages.items() if issubclass(page, BondForce)]
            text = f"molecules of several beads need one of {', '.join(known)}"
            yield "bond", f"{text}, as 'bond: {{stiffness: 2, length: 0}}'"
        for key, page in [*self.terms.items(), ("start", self.start)]:
            for inside, problem in page.refuses(self):
                yield f"{key}.{inside}" if inside else key, problem
        for key, term in self.terms.items():
            for change, other in self.made.items():
                if other != key and not term.allows(change):
                    text = f"{key!r} {term.why_not(change)}; not allowed with {other!r}"
                    yield key, f"{text}, remove one of them"

    def unobserved(self, made: Mapping[Change, str]) -> Refusals:
        """What observables have against the scene, and the changes that it makes."""
        for key, page in self.observe.items():
            for inside, problem in page.refusals(self, made):
                yield f"observe.{key}.{inside}" if inside else "observe", problem

    def no_species(self, name: str) -> str:
        """In words that no molecule has a species, and what may be meant."""
        found = f"no molecule has the species {name!r}"
        for other in self.species:
            if other.startswith(name) and other[len(name) :].isdigit():
                meant = f"'{name} {other[len(name) :]}', several beads of {name}"
                return f"{found}; allowed: {', '.join(self.species)}; did you mean {meant}?"
        return f"{found}; {suggestion(name, self.species)}"

    def check_species(
        self, key: str, values: Mapping[str, Any], example: float | str | None = None
    ) -> Refusals:
        """A table by species: unknown names, and species without a value.

        Parameters
        ----------
        example : float or str or None
            A usual value, for messages; "" where species may be left out.
        """
        for name in values:
            if name not in self.species:
                pair = "one value for each species, not for pairs" if " " in name else ""
                yield f"{key}.{name}", pair or self.no_species(name)
        if example == "" or not set(values) <= set(self.species):
            return  # the latter may be what is missing
        for name in self.species:
            if name not in values:
                add = f"add '{name}: {'...' if example is None else f'{example:g}'}'"
                yield key, f"no value for the species {name!r}; {add}, or give one number for all"

    def check_pairs(self, key: str, values: Mapping[str, float], example: float) -> Refusals:
        """A table by pairs of species: unknown names, two values of a pair, pairs without one."""
        known = True
        for pair, value in values.items():
            place, pair_names = f"{key}.{pair}" if key else pair, pair.split()
            if len(pair_names) != 2:
                yield place, f"one value for each pair of species: write '{pair} {pair}'"
                return
            for name in dict.fromkeys(pair_names):
                if name not in self.species:
                    yield place, self.no_species(name)
                    known = False
            swapped = values.get(f"{pair_names[1]} {pair_names[0]}", value)
            if swapped != value and pair_names == sorted(pair_names):
                yield place, f"{value:g}, but {swapped:g} in the other order"
        for i, one in enumerate(self.species if known else ()):
            for other in self.species[i:]:
                if f"{one} {other}" not in values and f"{other} {one}" not in values:
                    pair = f"{one} {other}"
                    yield key, f"no value for the pair {pair!r}; add '{pair}: {example:g}'"

    # --- what it is

    @property
    def own_forces(self) -> list[PairForce]:
        """Pair forces of one's own, in the order of their files."""
        return [term for term in self.terms.values() if isinstance(term, PairForce)]

    @property
    def bond_force(self) -> BondForce | None:
        """The law of its bonds."""
        found = (term for term in self.terms.values() if isinstance(term, BondForce))
        return next(found, None)

    @cached_property
    def made(self) -> dict[Change, str]:
        """What terms do to the world, each change by the key of the first that makes it."""
        found: dict[Change, str] = {}
        for key, term in self.terms.items():
            for change in term.changes(self):
                found.setdefault(change, key)
        return found

    @cached_property
    def digest(self) -> str:
        """Digest of all that decides the run, settings of observables that have defaults too.

        Of a file to start from its content counts, not where it lies; pages of one's own count as
        sources.
        """
        places, start = self.start.places, self.data["start"]
        start = {key: value for key, value in start.items() if key not in places}
        observe = {key: page.plain() for key, page in self.observe.items()}
        without = {key: value for key, value in self.data.items() if key != "pages"}
        forces = {term.key: term.content() for term in self.own_forces}
        return value_digest(without | {"observe": observe, "start": start} | forces)

    def files_beside(self, path: str | Path) -> dict[str, Path]:
        """Files that observables write beside the result at a path, as run.gsd, by their keys."""
        asked = self.observe.items()
        return {key: Path(path).with_suffix(page.suffix) for key, page in asked if page.suffix}

    @property
    def kT(self) -> float:
        """Temperature of the thermostat."""
        return float(self.terms["thermostat"].kT)

    @property
    def dt(self) -> float:
        """Time step in tau; with scheme auto a first guess, see `is_auto`."""
        return float(self.terms["integrator"].named.dt)

    @property
    def is_auto(self) -> bool:
        """Whether scheme and step are left to us, and yet to be tried."""
        return self.terms["integrator"].is_auto

    @property
    def dimension(self) -> int:
        return self.data["dimension"]

    @cached_property
    def box(self) -> tuple[float, ...]:
        """Edges in r_c, one per axis."""
        box = self.data["box"]
        edges = box if isinstance(box, list) else [box] * self.dimension
        return tuple(float(edge) for edge in edges)

    @property
    def volume(self) -> float:
        return math.prod(self.box)

    @cached_property
    def molecules(self) -> tuple[Molecule, ...]:
        """The kinds of molecules, in the scene's order."""
        kinds = []
        for kind in self.data["molecules"]:
            beads, parents = tree_of(kind["architecture"])
            count = kind.get("count") or round(kind["density"] * self.volume / len(beads))
            kinds.append(Molecule(beads, parents, count))
        return tuple(kinds)

    @cached_property
    def species(self) -> tuple[str, ...]:
        """Names of the species, sorted; their places are the numbers that the engine uses."""
        return tuple(sorted({name for kind in self.molecules for name in kind.beads}))

    @cached_property
    def kinds(self) -> np.ndarray:
        """(n,) uint8 array: the number of the species of each bead."""
        number = {name: place for place, name in enumerate(self.species)}
        each = [
            np.tile([number[name] for name in kind.beads], kind.count) for kind in self.molecules
        ]
        return np.concatenate(each).astype(np.uint8)

    @property
    def beads(self) -> int:
        """Number of beads."""
        return sum(kind.count * len(kind.beads) for kind in self.molecules)

    @property
    def density(self) -> float:
        """Beads per r_c^dimension, from the whole number of molecules."""
        return self.beads / self.volume

    @cached_property
    def missed_densities(self) -> list[MissedDensity]:
        """Densities of the scene that whole molecules miss by more than `NOTED_MISSED`."""
        missed = []
        for place, (kind, given) in enumerate(zip(self.molecules, self.data["molecules"])):
            found = kind.count * len(kind.beads) / self.volume
            density = MissedDensity(place, given.get("density", found), found)
            if density.share > NOTED_MISSED:
                missed.append(density)
        return missed

    @cached_property
    def notes(self) -> list[str]:
        """Sentences for a person on what the scene does not quite get."""
        missed = [
            f"molecules.{density.place}.density: {self.sizes(density)} instead of "
            f"{density.asked:g} ({density.share:.2%} off)"
            for density in self.missed_densities
        ]
        return missed + [note for term in self.terms.values() for note in term.notes(self)]

    def sizes(self, density: MissedDensity) -> str:
        """Box, count and the density that they make, in words."""
        kind = self.molecules[density.place]
        edges = " x ".join(f"{edge:g}" for edge in self.box)
        of = f" of {len(kind.beads)} beads" if len(kind.beads) > 1 else ""
        return f"{kind.count} molecules{of} in a box of {edges} make {density.found:.4g}"

    @cached_property
    def repulsion(self) -> np.ndarray:
        """(species, species) array of a_ij."""
        return self.by_pair(self.repulsions)

    @cached_property
    def repulsions(self) -> dict[str, float]:
        """a_ij by pairs of species as "A B", those that are given as chi with them."""
        return {k: v for term in self.terms.values() for k, v in term.repulsions(self).items()}

    @cached_property
    def friction(self) -> float | np.ndarray:
        """gamma: a number, or one by pairs of species, or for langevin by species."""
        return self.friction_of(self.data["thermostat"]["gamma"])

    @cached_property
    def masses(self) -> np.ndarray | None:
        """(species,) array; None where the scene names no masses."""
        if "mass" not in self.data:
            return None
        return np.array([float(self.data["mass"].get(name, 1)) for name in self.species])

    @property
    def lightest(self) -> float:
        """Mass of the lightest beads."""
        return 1.0 if self.masses is None else float(self.masses.min())

    @cached_property
    def bonds(self) -> Joined:
        """All bonds, molecule after molecule; empty where every molecule is a single bead."""
        return self.bonds_with({} if self.bond_force is None else self.bond_force.laws(self))

    def bonds_with(self, laws: Mapping[str, Any]) -> Joined:
        """The same with other laws, by pairs of species, or by no name."""
        return joined(self, laws, lambda kind: kind.bonds)

    @property
    def bonded(self) -> np.ndarray:
        """(n, 2) uint32 array of the numbers of bonded beads, molecule after molecule."""
        return self.bonds.members

    @cached_property
    def angles(self) -> Joined | None:
        """All angles, molecule after molecule; None without them."""
        if "angle" not in self.data:
            return None
        return joined(self, self.data["angle"], lambda kind: kind.triples)

    @property
    def angled(self) -> np.ndarray:
        """(n, 3) uint32 array of the numbers of the beads of angles; empty without them."""
        return np.zeros((0, 3), np.uint32) if self.angles is None else self.angles.members

    @cached_property
    def lengths(self) -> np.ndarray:
        """(molecules,) array: beads of each molecule."""
        return np.repeat(
            [len(kind.beads) for kind in self.molecules], [kind.count for kind in self.molecules]
        )

    @cached_property
    def steps(self) -> Steps:
        """Steps to equilibrate and to sample: the longer of steps and duration."""
        dt = self.dt
        steps, duration = self.data["steps"], self.data["duration"]
        longer = (
            max(steps.get(part, 0), round(duration.get(part, 0) / dt)) for part in Steps._fields
        )
        return Steps(*longer)

    def tau(self, steps: Any, since: int = 0, every: int = 1) -> Any:
        """Time in tau that so many times ``every`` steps take behind a step of the run."""
        time, steps = self.dt * every * steps, every * steps
        for former, stage in pairwise(self.stages):
            longer = np.clip(since + steps - max(since, stage.step), 0, None)
            time = time + (stage.scene.dt - former.scene.dt) * longer
        return time

    def during(self, first: int, last: int) -> list[Scene]:
        """The scenes of the stages that steps behind the first, up to the last, belong to."""
        ends = [stage.step for stage in self.stages[1:]] + [math.inf]
        return [
            stage.scene
            for stage, end in zip(self.stages, ends)
            if stage.step < last and end > first
        ]

    @property
    def work(self) -> int:
        """Bead-steps of the whole run."""
        return self.beads * sum(self.steps)

    @property
    def skin(self) -> float:
        """Skin of the pair list in r_c; 0 for cells."""
        return self.skin_at(self.dt)

    def skin_at(self, dt: float) -> float:
        """The same for steps of another length."""
        chosen, skin = self.data["pairs"]["search"], self.data["pairs"]["skin"]
        if chosen == "auto":
            thermal = dt * (self.kT / self.lightest) ** 0.5
            room = min(self.period) >= 2 * (CUTOFF + skin) and Change.SLIDES not in self.made
            chosen = "list" if room and thermal <= SMALL_STEP[self.dimension] else "cells"
        return float(skin) if chosen == "list" else 0.0

    # --- species

    def by_species(self, given: float | Mapping[str, float]) -> tuple[float, ...]:
        """A value for each species, from one for all or from a table."""
        if not isinstance(given, dict):
            return (float(given),) * len(self.species)  # type: ignore[arg-type]
        return tuple(float(given[name]) for name in self.species)

    def by_pair(self, values: Mapping[str, float]) -> np.ndarray:
        """(species, species) array of values by pairs as "A B"; NaN for pairs without one."""
        table = np.full((len(self.species),) * 2, np.nan)
        for pair, value in values.items():
            i, j = (self.species.index(name) for name in pair.split())
            table[i, j] = table[j, i] = value
        return table

    def friction_of(self, gamma: float | Mapping[str, float]) -> float | np.ndarray:
        """Friction as the engine takes it: a number, or an array by pairs or by species."""
        if not isinstance(gamma, dict):
            return float(gamma)  # type: ignore[arg-type]
        by_pair = any(" " in name for name in gamma)
        return self.by_pair(gamma) if by_pair else np.array(self.by_species(gamma))

    @property
    def has_bonds(self) -> bool:
        """Whether any molecule has several beads."""
        return any(len(kind.beads) > 1 for kind in self.molecules)

    @cached_property
    def bonded_species(self) -> list[tuple[str, ...]]:
        """Species of all bonded pairs, each once."""
        return all_species(self, lambda kind: kind.bonds)

    @cached_property
    def angled_species(self) -> list[tuple[str, ...]]:
        """Species of all beads in angles, each three once."""
        return all_species(self, lambda kind: kind.triples)

    # --- what terms do to the space and to the flow

    @cached_property
    def origin(self) -> tuple[float, ...]:
        """Where the box begins in the periodic one, along each axis.

        The engine knows periodic boxes alone. Along an axis that ends its box has a gap on either
        side, so wide that beads behind opposite ends do not feel each other: nothing repeats then.
        """
        return tuple(
            max(term.gap(self, axis) for term in self.terms.values())
            for axis in range(self.dimension)
        )

    @property
    def period(self) -> tuple[float, ...]:
        """Edges of the periodic box in which beads move: those of the box, and of both gaps."""
        return tuple(edge + 2 * low for edge, low in zip(self.box, self.origin))

    @property
    def ended(self) -> tuple[int, ...]:
        """The axes along which nothing repeats."""
        return tuple(axis for axis, low in enumerate(self.origin) if low)

    @property
    def room(self) -> tuple[float, ...]:
        """The least distances that images of a bead may have along each axis.

        Half of it is how far a separation may reach along an axis and still be told from images.
        """
        return tuple(map(min, zip(*(term.room(self) for term in self.terms.values()))))

    @property
    def stretched(self) -> str:
        """The axes along which the box changes its size: ``all``, one of them, or nothing."""
        return "".join(term.stretched() for term in self.terms.values())

    @property
    def flows(self) -> bool:
        """Whether something drives a flow, but for a shear, about which velocities are kept."""
        return Change.FLOWS in self.made

    @property
    def across(self) -> tuple[int, ...]:
        """The axes across which a flow that is driven changes."""
        found = dict.fromkeys((*self._across(Change.ENDS), *self._across(Change.FLOWS)))
        return tuple(found) or self._across(Change.SLIDES) or (self.box.index(max(self.box)),)

    def _across(self, change):
        """Those of the terms that are there for a change: walls, what drives, a shear."""
        return tuple(
            axis for term in self.terms.values() if term.mainly == change
            for axis in term.across(self)
        )  # fmt: skip

    def axis_of_profile(self, name: str | None) -> int:
        """The axis of a profile: the one named, or the one across which things change most."""
        return self.across[0] if name is None else AXES.index(name)

    def flow_layers(self, extent: tuple[float, ...]) -> tuple[tuple[int, float], ...]:
        """The axes across which a driven flow changes, each with the thickness of layers.

        In cells that are cut by these layers the flow's profile is fitted to the velocities of
        beads.

        Parameters
        ----------
        extent : tuple of float
            Edges of the space that beads fill.
        """
        if not self.flows:
            return ()
        axes = self.across
        least = LEAST * (1 + len(axes)) * math.prod(extent[axis] for axis in axes) / self.beads
        return tuple((axis, max(FINEST, least ** (1 / len(axes)))) for axis in axes)

    @property
    def brakes(self) -> bool:
        """Whether friction with what is no bead takes up momentum, along all axes."""
        return any(term.brakes(self) for term in self.terms.values())

    @property
    def takes_heat(self) -> bool:
        """Whether a friction holds the temperature: of pairs, of beads, or of walls."""
        return bool(np.any(self.friction)) or self.brakes

    @property
    def momentum_axes(self) -> tuple[int, ...]:
        """The axes along which nothing but a body force changes the total momentum."""
        if self.brakes:
            return ()
        return tuple(axis for axis in range(self.dimension) if axis not in self.ended)


NEEDED = ("integrator", "repulsion", "thermostat")  # in every scene


def _without_others(page, given, wrong):
    """What is given for a start without settings of other methods, which have no effect.

    They are told, but for defaults, which results of former versions have.
    """
    rest = dict(given)
    for other in (
        map(partial(find, Start), names(Start)) if given.keys() - page.model_fields else ()
    ):
        for key in other.model_fields.keys() & rest.keys() - page.model_fields.keys():
            field, value = other.model_fields[key], rest.pop(key)
            default = field.get_default(call_default_factory=True)
            if value != getattr(default, "model_dump", lambda: None)():
                wrong.append(
                    f"start.{key}: has no effect with method {page.key!r}; take 'method: "
                    f"{other.key}', or remove the key"
                )
    return rest


def _in_a_line(value: Any) -> str:
    """Settings as a person reads them."""
    if not isinstance(value, dict):
        return f"{value:g}" if isinstance(value, float) else str(value)
    parts = (f"{name}: {_in_a_line(part)}" for name, part in value.items())
    return f"{{{', '.join(parts)}}}"


def _named(page: Page) -> Iterable[tuple[str, tuple[str, Any]]]:
    """Settings that name axes or species: what they name, and their values."""
    for name, field in type(page).model_fields.items():
        extra = field.json_schema_extra
        value = getattr(page, name)
        if isinstance(extra, dict) and "of" in extra and value is not None:
            yield name, (str(extra["of"]), value)
