"""What a scene is made of: its box, its molecules, and tables by their species."""

from __future__ import annotations

import math
from functools import cached_property
from itertools import combinations_with_replacement
from typing import TYPE_CHECKING, Any

import numpy as np

from dpd.scene.molecules import Joined, Molecule, joined, tree_of
from dpd.scene.reading import Settings

if TYPE_CHECKING:
    from collections.abc import Mapping

NOTED_MISSED = 1e-4  # share of a density that whole molecules may miss unsaid: rounding


class Composition(Settings):
    """The beads of a scene, in the order of its molecules."""

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
    def missed_densities(self) -> dict[int, tuple[float, float]]:
        """Densities asked for and found, by kinds whose whole molecules miss them."""
        missed = {}
        for place, (kind, given) in enumerate(zip(self.molecules, self.data["molecules"])):
            found = kind.count * len(kind.beads) / self.volume
            if abs(found / given.get("density", found) - 1) > NOTED_MISSED:
                missed[place] = given["density"], found
        return missed

    def sizes(self, place: int) -> str:
        """Box, count and the density that they make, in words."""
        kind = self.molecules[place]
        edges = " x ".join(f"{edge:g}" for edge in self.box)
        of = f" of {len(kind.beads)} beads" if len(kind.beads) > 1 else ""
        density = kind.count * len(kind.beads) / self.volume
        return f"{kind.count} molecules{of} in a box of {edges} make {density:.4g}"

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

    @property
    def bonded(self) -> np.ndarray:
        """(n, 2) uint32 array of the numbers of bonded beads, molecule after molecule."""
        return self.joined[2].members

    @property
    def angled(self) -> np.ndarray:
        """(n, 3) uint32 array of the numbers of the beads of angles; empty without them."""
        return self.joined[3].members

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
        return bool(self.species_along(2))

    def species_along(self, size: int) -> list[tuple[str, ...]]:
        """Species of all bonded pairs, or triples, each once, in the order in which they come."""
        found = (name for kind in self.molecules for name in kind.species_along(size))
        return list(dict.fromkeys(min(name, name[::-1]) for name in found))
