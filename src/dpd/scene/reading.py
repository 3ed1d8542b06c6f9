"""From plain data to settings, by sections and pages, and to the beads that they mean."""

import math
import os
import re
from collections.abc import Mapping
from contextlib import suppress
from functools import cached_property
from itertools import combinations_with_replacement
from typing import Any

import numpy as np

from dpd.errors import UserError, shown, suggestion
from dpd.page import NEEDED, Change, Observable, Start, Term, find, is_table, names
from dpd.page.own import load
from dpd.scene.molecules import Joined, Molecule, either_way, graph_of, joined, of_each_length
from dpd.scene.sections import Basics, Ramp
from dpd.scene.yaml import attempt

WORD = re.compile(r"[\w.+-]+")  # in a scene, which may be the name of a type
NOTED_MISSED = 1e-4  # share of a density that whole molecules may miss unsaid: rounding


class Settings:
    """What the file of a scene says, each section by itself, and its beads."""

    def __init__(self, where: str) -> None:
        self.where = where  # the file, for messages
        self.data: dict[str, Any] = {}  # plain, with all defaults but those of observables
        self.terms: dict[str, Any] = {}  # pages by key, as all that follow
        self.observe: dict[str, Any] = {}
        self.start: Any = None
        self.start_changes: dict[str, Any] = {}  # terms that act otherwise while the start is made
        self.own_pages: dict[str, Any] = {}
        self.ramps: dict[str, Ramp] = {}  # by the keys that they were given for
        self.page_files: dict[str, str] = {}  # digests of files of pages, by whole paths
        self.laws_by_type: set[str] = set()  # that bonds and angles have by their types
        self._wrong: list[str] = []

    # --- reading

    def _load_pages(self, given, folder):
        """Pages of one's own; files are named by their whole paths from then on."""
        for place, one in enumerate(given if isinstance(given, list) else []):
            named = one if isinstance(one, dict) else {"path": one, "sha256": ""}
            path, digest = named.get("path"), named.get("sha256")
            if not isinstance(path, str) or not isinstance(digest, str):
                continue  # which is told with all else that is wrong
            path = os.path.abspath(os.path.join(folder, path))
            loaded, now = load(path, f"{self.where}: pages.{place}", digest)
            twice = sorted(self.own_pages.keys() & loaded.keys())
            if path not in self.page_files and twice:
                raise UserError(
                    f"{self.where}: pages.{place}: {path}: {twice[0]!r} is a page of another file "
                    "as well; take another key"
                )
            self.own_pages |= loaded
            self.page_files[path] = now

    def _completed(self, data, folder):
        """With box and molecules of its start, if it has none, lengths one by one, no ramps."""
        data |= self._without_ramps({key: data[key] for key in data if key == "box"})
        given = data.get("start")
        method = given.get("method") if isinstance(given, dict) else None
        page = self._page(Start, method) if method in self._keys(Start) else Start
        missing = [key for key in page.completes if key not in data]
        if missing:
            start = self._section(Start, method, given, "start")
            self._refuse_wrong()
            there = start.found(folder, self.where).system(self.where, WORD.findall(str(data)))
            walls = [key for key in self._keys(Term) if self._page(Term, key).mainly == Change.ENDS]
            if data.keys() & {*walls}:  # the box of a result is larger then, by their gaps
                there.pop("box")
            data = data | {key: there[key] for key in missing if key in there}
        with suppress(TypeError, KeyError, ValueError):  # which is told with all else that is wrong
            edges = np.broadcast_to(np.array(data["box"], float), data["dimension"])
            each = (of_each_length(kind, edges.prod()) for kind in data["molecules"])
            data |= {"molecules": [kind for several in each for kind in several]}
            types = {name for kind in data["molecules"] for name in kind.get("types", ())}
            graphs = [graph_of(kind["architecture"]) for kind in data["molecules"]]
            types -= {name for beads, *_ in graphs for name in beads}  # whose laws are of species
            for key in data.keys() & {*self._keys(Term)}:
                if size := self._page(Term, key).joins:
                    data[key] = self._by_type(data[key], {t: " ".join([t] * size) for t in types})
        terms = [key for key in self._keys(Term) if key in data]
        return data | self._without_ramps({key: data[key] for key in terms})

    def _without_ramps(self, data, key=""):
        """A section with each ramp as its first value; these are kept, by their keys."""
        if not isinstance(data, dict):
            return data
        if not (data.keys() & {"from", "to"} and data.keys() <= {"from", "to", "over"}):
            names = {name: f"{key}.{name}" if key else name for name in data}
            return {name: self._without_ramps(data[name], names[name]) for name in data}
        ramp, wrong = attempt(Ramp, data, key)
        self._wrong += wrong
        self._refuse_wrong()
        self.ramps[key] = ramp
        return ramp.from_

    def _by_type(self, data, types):
        """A section with the name of a type once for each bead that it joins, as of species."""
        if not isinstance(data, dict):
            return data
        found: dict[Any, Any] = {}
        for key, each in data.items():  # a changed one stands behind the whole law
            name, each = types.get(str(key), key), self._by_type(each, types)
            found[name] = found.get(name, {}) | each if isinstance(each, dict) else each
        self.laws_by_type |= {*types.values()} & found.keys()
        return found

    def _keys(self, kind):
        """Of all pages of a kind, those of one's own last."""
        own = [key for key, page in self.own_pages.items() if issubclass(page, kind)]
        return [*names(kind), *own]

    def _page(self, kind, key):
        """The page of a key that there is."""
        own = self.own_pages.get(key)
        return own if own and issubclass(own, kind) else find(kind, key)

    def _read(self, data):
        """Settings of all sections and pages; refused with a line for each mistake."""
        terms = self._keys(Term)
        sections = [*terms, "start"]
        basic = {key: value for key, value in data.items() if key not in sections}
        basics, self._wrong = attempt(Basics, basic, more=sections)
        for key in terms:
            if key in data or key in NEEDED:
                page = self._page(Term, key)
                if key not in data and page.has_required():
                    self._wrong.append(f"the file: the key {key!r} is missing ({page.summary()})")
                else:
                    self.terms[key] = self._section(Term, key, data.get(key, {}), key)
        start, method = data.get("start", {}), Start.model_fields["method"].default
        method = start.get("method", method) if isinstance(start, dict) else method
        self.start = self._section(Start, method, start, "start", "start.method")
        for item in basics.observe if basics else ():
            if isinstance(item, list) or (isinstance(item, dict) and len(item) != 1):
                text = f"{shown(item)} should be one name with its settings, as - rdf: {{range: 3}}"
                self._wrong.append(f"observe: {text}")
                continue
            name, settings = next(iter(item.items())) if isinstance(item, dict) else (item, {})
            if name in self.observe:
                self._wrong.append(f"observe: {name!r} is there more than once; keep one")
            page = self._section(Observable, name, settings, f"observe.{name}", "observe")
            self.observe[name] = page
        if not self._wrong:
            self._read_start_forces()
        self._refuse_wrong()
        self.data = basics.model_dump(exclude_none=True, by_alias=True, exclude={"pages"})
        self.data |= {key: term.plain() for key, term in self.terms.items()}
        self.data["pages"] = [{"path": p, "sha256": d} for p, d in self.page_files.items()]

    def _refuse_wrong(self):
        if wrong := dict.fromkeys(self._wrong):
            raise UserError("\n".join(f"{self.where}: {text}" for text in wrong))

    def _section(self, kind, name, given, key, where=""):
        """The settings of a page by their key, if there is such a page, and they are right."""
        found, problems, known = None, [], self._keys(kind)
        if name in known:
            found, problems = attempt(self._page(kind, name), given, key)
        else:
            self._wrong.append(f"{where}: {shown(name)} is not known; {suggestion(name, known)}")
        self._wrong += problems
        return found

    def _read_start_forces(self):
        """Terms that act otherwise while the start is made."""
        forces, terms = self.start.forces, self._keys(Term)
        for key, given in dict(forces.model_extra or {}).items():
            if key not in terms or not self._may_act_in_start(key):
                known = sorted([*type(forces).model_fields, *filter(self._may_act_in_start, terms)])
                text = f"unknown key {shown(key)}; {suggestion(key, known)}"
                self._wrong.append(f"start.forces: {text}")
                continue
            page, whole = self._page(Term, key), given
            if key in self.terms and isinstance(given, dict):
                plain = self.terms[key].plain()
                whole = plain | given
                if is_table(plain):  # of laws: in each
                    whole = {name: law | given for name, law in plain.items()}
            found = self.start_changes[key] = self._section(Term, key, whole, f"start.forces.{key}")
            if found is not None and not page.bare:  # numbers as its settings have them
                forces.model_extra[key] = {each: found.plain()[each] for each in given}

    def _may_act_in_start(self, key):
        page = self._page(Term, key)
        return page.own_in_start and (key in self.terms or not page.joins)

    # --- its beads, in the order of its molecules

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
            beads, parents, rings = graph_of(kind["architecture"])
            rings += tuple((min(pair), max(pair)) for pair in kind.get("bonds", ()))
            count = kind.get("count") or round(kind["density"] * self.volume / len(beads))
            types = tuple(
                (either_way(members), name)
                for name, each in kind.get("types", {}).items() for members in each
                if " ".join([name] * len(members)) in self.laws_by_type
            )  # fmt: skip
            kinds.append(Molecule(beads, parents, tuple(sorted(rings)), count, types))
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
        return sum(kind.count * len(kind.beads) for kind in self.molecules)

    @property
    def density(self) -> float:
        """Beads per r_c^dimension, from the whole number of molecules."""
        return self.beads / self.volume

    @cached_property
    def missed_densities(self) -> dict[int, tuple[float, float]]:
        """Densities asked for and found, by kinds whose whole molecules miss them."""
        missed = {}
        for place, (kind, given) in enumerate(zip(self.molecules, self.data["molecules"])):
            found = kind.count * len(kind.beads) / self.volume
            if abs(found / given.get("density", found) - 1) > NOTED_MISSED:
                missed[place] = given["density"], found
        return missed

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
    def joined(self) -> dict[int, Joined]:
        """What laws join, by the number of beads: all bonds, and angles that a law names."""
        laws: dict[int, Any] = {2: {}, 3: {}}
        laws |= {term.joins: term.laws(self) for term in self.terms.values() if term.joins}
        return {size: joined(self.molecules, each, size) for size, each in laws.items()}

    @cached_property
    def types(self) -> dict[tuple[int, ...], str]:
        """Types of bonds and angles that have any, by the numbers of beads."""
        found, first = dict[tuple[int, ...], str](), 0
        for kind in self.molecules:
            for one in range(first, first + kind.count * len(kind.beads), len(kind.beads)):
                found |= {tuple(one + bead for bead in beads): name for beads, name in kind.types}
            first += kind.count * len(kind.beads)
        return found

    @property
    def bonded(self) -> np.ndarray:
        """(n, 2) uint32 array of the numbers of bonded beads, molecule after molecule."""
        return self.joined[2][0]

    @cached_property
    def lengths(self) -> np.ndarray:
        """(molecules,) array: beads of each molecule."""
        return np.repeat(
            [len(kind.beads) for kind in self.molecules], [kind.count for kind in self.molecules]
        )

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

    @property
    def pairs(self) -> list[tuple[str, ...]]:
        """All pairs of species, each once."""
        return list(combinations_with_replacement(self.species, 2))

    @property
    def has_bonds(self) -> bool:
        """Whether any molecule has several beads."""
        return any(len(kind.beads) > 1 for kind in self.molecules)

    def species_along(self, size: int) -> list[tuple[str, ...]]:
        """Species of all bonded pairs, or triples, each once, in the order in which they come."""
        found = (name for kind in self.molecules for name in kind.species_along(size))
        return list(dict.fromkeys(min(name, name[::-1]) for name in found))
