"""WHAT is simulated: a validated, hashable description that knows what it needs."""

from __future__ import annotations

import math
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from dpd.digest import value_digest
from dpd.errors import UserError
from dpd.page import Change, Observable, find, refusals
from dpd.physics.schemes import WITHOUT_EXCHANGE, scheme_named
from dpd.scene.architecture import tree_of
from dpd.scene.automatic import choose
from dpd.scene.bonding import Joined, check_bonding, joined
from dpd.scene.chi import FromChi, chi_notes, repulsions_from_chi
from dpd.scene.description import description
from dpd.scene.limits import check_beads, check_limits
from dpd.scene.molecules import MissedDensity, Molecule
from dpd.scene.pressure import with_pressure
from dpd.scene.schema import read_yaml, schema, validate, with_defaults
from dpd.scene.start import reads_file, with_file
from dpd.scene.tables import check_tables, friction_table, mass_table, pair_table
from dpd.scene.walls import period_of

CUTOFF = 1.0
SMALL_STEP = {2: 0.005, 3: 0.001}  # dt sqrt(kT) in r_c, up to which a pair list pays, measured
MOST_CELLS = 2**26  # cells of one cutoff in the box: half a gigabyte of counters
TOLERANCE = 0.01  # of scheme auto, in pressure and kT
# Share by which whole molecules may miss the density that is asked for: 1 % changes the pressure,
# which goes with the square of the density, by 2 %. Less is noted, rounding is not.
MOST_MISSED, NOTED_MISSED = 0.01, 1e-4

# What sections of a scene do to the world.
MADE = {
    "shear": Change.SLIDES, "pressure": Change.STRETCHES, "walls": Change.ENDS,
    "body_force": Change.FLOWS, "core": Change.JUMPS,
}  # fmt: skip


class Steps(NamedTuple):
    """How many steps a run takes: to equilibrate, and then to sample."""

    equilibrate: int
    sample: int


class Scene:
    """One system and how long it is simulated.

    Parameters
    ----------
    data : dict
        As src/dpd/schemas/scene.yaml has it.
    where : str
        File to name in messages.
    folder : path
        From which the path of a file to start from counts; the working folder if not given.

    Raises
    ------
    UserError
        If anything in it is not allowed, or does not fit together.
    """

    def __init__(self, data: dict[str, Any], where: str = "scene", folder: str | Path = "") -> None:
        validate(data, "scene", where)
        self.data = with_defaults(data, schema("scene"))
        check_beads(self.data, where)
        if reads_file(self):
            self.data["start"] = with_file(self.data["start"], folder, where)
        self.where = where
        # What was chosen for a scene that left scheme and step to us, as plain data: see `settle`.
        self.chosen = None  # type: dict[str, Any] | None
        # Then its scheme and step are a first guess, until `settle` of the pipeline has tried them.
        self.is_auto = self.data["integrator"]["scheme"] == "auto"
        self._choose_integrator()
        self._check()
        if "pressure" in self.data:
            self.data["pressure"] = with_pressure(self)

    @classmethod
    def read(cls, path: str | Path) -> Scene:
        """Read a scene from a YAML file."""
        return cls(read_yaml(path), str(path), Path(path).parent)

    def __repr__(self):
        return description(self)

    def _choose_integrator(self):
        integrator = self.data["integrator"]
        if integrator["scheme"] != "auto":
            if "tolerance" in integrator:
                self._fail("integrator.tolerance", "only scheme 'auto' has one")
            if "dt" not in integrator:
                self._fail("integrator", "the key 'dt' is missing (Time step in tau.)")
            return
        if "dt" in integrator:
            self._fail("integrator.dt", "scheme 'auto' comes with its own; remove the key")
        self.tolerance = integrator.setdefault("tolerance", TOLERANCE)
        with_all = self.data | {"repulsion": self.repulsions}
        self.data["integrator"] = choose(with_all, self.density, self.where)

    @cached_property
    def digest(self) -> str:
        """Digest of all that decides the run, settings of observables that have defaults too.

        Of a file to start from its content counts, not where it lies.
        """
        start = {key: value for key, value in self.data["start"].items() if key != "path"}
        return value_digest(self.data | {"observe": self.observe, "start": start})

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
            f"molecules.{density.place}.density: {self._sizes(density)} instead of "
            f"{density.asked:g} ({density.share:.2%} off)"
            for density in self.missed_densities
        ]
        return missed + chi_notes(self)

    def _sizes(self, density):
        """Box, count and the density that they make, in words."""
        kind = self.molecules[density.place]
        edges = " x ".join(f"{edge:g}" for edge in self.box)
        of = f" of {len(kind.beads)} beads" if len(kind.beads) > 1 else ""
        return f"{kind.count} molecules{of} in a box of {edges} make {density.found:.4g}"

    @cached_property
    def repulsion(self) -> np.ndarray:
        """(species, species) array of a_ij."""
        return pair_table(self, self.repulsions)

    @cached_property
    def from_chi(self) -> tuple[FromChi, ...]:
        """The repulsions that the scene gives as chi."""
        return repulsions_from_chi(self)

    @property
    def repulsions(self) -> dict[str, float]:
        """a_ij by pairs of species as "A B", those that are given as chi with them."""
        return self.data["repulsion"] | {each.pair: each.repulsion for each in self.from_chi}

    @cached_property
    def friction(self) -> float | np.ndarray:
        """gamma: a number, or one by pairs of species, or for langevin by species."""
        return friction_table(self, self.data["thermostat"]["gamma"])

    @cached_property
    def masses(self) -> np.ndarray | None:
        """(species,) array; None where the scene names no masses."""
        return mass_table(self)

    @property
    def lightest(self) -> float:
        """Mass of the lightest beads."""
        return 1.0 if self.masses is None else float(self.masses.min())

    @cached_property
    def bonds(self) -> Joined:
        """All bonds, molecule after molecule; empty where every molecule is a single bead."""
        return joined(self, self.data.get("bond", {}), lambda kind: kind.bonds)

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
        dt = self.data["integrator"]["dt"]
        steps, duration = self.data["steps"], self.data["duration"]
        longer = (
            max(steps.get(part, 0), round(duration.get(part, 0) / dt)) for part in Steps._fields
        )
        return Steps(*longer)

    def watched(self, name: str) -> int:
        """Steps that an observable looks at: all, if it asks for the equilibration as well."""
        whole_run = self.observe[name].get("equilibration", False)
        return sum(self.steps) if whole_run else self.steps.sample

    @property
    def work(self) -> int:
        """Bead-steps of the whole run."""
        return self.beads * sum(self.steps)

    @property
    def skin(self) -> float:
        """Skin of the pair list in r_c; 0 for cells."""
        return self.skin_at(self.data["integrator"]["dt"])

    def skin_at(self, dt: float) -> float:
        """The same for steps of another length."""
        chosen, skin = self.data["pairs"]["search"], self.data["pairs"]["skin"]
        if chosen == "auto":
            thermal = dt * (self.data["thermostat"]["kT"] / self.lightest) ** 0.5
            room = min(period_of(self)) >= 2 * (CUTOFF + skin) and "shear" not in self.data
            chosen = "list" if room and thermal <= SMALL_STEP[self.dimension] else "cells"
        return float(skin) if chosen == "list" else 0.0

    @cached_property
    def observe(self) -> dict[str, dict[str, Any]]:
        """Settings of each observable by name, with ``every`` filled in."""
        rules = schema("scene")["properties"]["observe"]["items"]["oneOf"][1]["properties"]
        dt, sample, chosen = self.data["integrator"]["dt"], self.steps.sample, {}
        for item in self.data["observe"]:
            name, given = (item, {}) if isinstance(item, str) else next(iter(item.items()))
            settings = with_defaults(given, rules[name])
            if "every" not in settings:
                every = find(Observable, name).steps_between(settings, dt, sample)
                settings["every"] = max(1, min(every, sample))
            chosen[name] = settings
        return chosen

    def _fail(self, key, problem):
        raise UserError(f"{self.where}: {key}: {problem}")

    def _check(self):
        self._check_box()
        self._check_molecules()
        check_tables(self)
        self._check_core()
        check_bonding(self, self._fail)
        self._check_thermostat()
        if self.steps.sample < 1:
            self._fail("steps.sample", "nothing to sample; set steps.sample or duration.sample")
        if self.data["start"]["method"] == "polymerize":
            if self.dimension != 2:
                self._fail("start.method", "'polymerize' grows chains in two dimensions only")
            if "bond" not in self.data:
                self._fail("start.method", "'polymerize' has nothing to grow: no chains, no bond")
            branched = [k for k in self.molecules if not k.is_chain]
            if branched:
                text = self.data["molecules"][self.molecules.index(branched[0])]["architecture"]
                self._fail("start.method", f"'polymerize' grows chains; {text!r} has branches")
        check_limits(self)
        self._check_observe()

    def _check_observe(self):
        asked = self.data["observe"]
        names = [each if isinstance(each, str) else next(iter(each)) for each in asked]
        for name in names:
            if names.count(name) > 1:
                self._fail("observe", f"{name!r} is there {names.count(name)} times; keep one")
        made = {change: key for key, change in MADE.items() if key in self.data}
        if not self.data.get("core", {}).get("radius"):
            made.pop(Change.JUMPS, None)
        for name in names:
            for key, problem in refusals(find(Observable, name), self, made):
                self._fail(f"observe.{name}.{key}" if key else "observe", problem)

    def _check_box(self):
        if len(self.box) != self.dimension:
            self._fail("box", f"{len(self.box)} edges in {self.dimension} dimensions")
        for edge in self.box:
            if edge < 2 * CUTOFF:
                self._fail(
                    "box",
                    f"an edge of {edge:g} is smaller than two cutoffs, a bead would meet "
                    f"another one twice; allowed: >= {2 * CUTOFF:g}",
                )

        for edge in period_of(self):
            if edge < 2 * (CUTOFF + self.skin):
                self._fail(
                    "pairs.skin",
                    f"{self.skin:g} needs a box of at least {2 * (CUTOFF + self.skin):g}, an edge "
                    f"is {edge:g}; use search: cells",
                )
        if self.volume > MOST_CELLS:
            self._fail("box", f"a volume of {self.volume:g} is too large; allowed: <= {MOST_CELLS}")

    def _check_molecules(self):
        for place, (kind, given) in enumerate(zip(self.molecules, self.data["molecules"])):
            if kind.count < 1:
                self._fail(
                    f"molecules.{place}.density",
                    f"{given['density']:g} is not one molecule of {len(kind.beads)} beads in a "
                    f"box of {self.volume:g} r_c^{self.dimension}",
                )
        for density in self.missed_densities:
            if density.share > MOST_MISSED:
                fitting = (density.found / density.asked) ** (1 / self.dimension)
                edges = ", ".join(f"{fitting * edge:.6g}" for edge in self.box)
                edges = f"[{edges}]" if isinstance(self.data["box"], list) else edges.split(",")[0]
                count = self.molecules[density.place].count
                self._fail(
                    f"molecules.{density.place}.density",
                    f"{density.asked:g} is not met: {self._sizes(density)}, {density.share:.1%} "
                    f"off; allowed: {MOST_MISSED:.0%}. Write 'box: {edges}', in which {count} of "
                    f"them fit, or 'count: {count}' instead of the density",
                )

    def _check_thermostat(self):
        scheme, kind = self.data["integrator"]["scheme"], self.data["thermostat"]["kind"]
        if kind == "langevin" and scheme_named(scheme).exchange is not None:
            self._fail(
                "integrator.scheme",
                f"{scheme!r} lets pairs exchange momentum, a Langevin thermostat has no pairs; "
                f"allowed: {WITHOUT_EXCHANGE}",
            )

    def _check_core(self):
        core = self.data.get("core", {"radius": 0, "smooth": 0})
        if 2 * core["radius"] + core["smooth"] > CUTOFF:
            self._fail(
                "core.smooth",
                f"{core['smooth']:g} beyond a core of diameter {2 * core['radius']:g} goes past "
                f"the cutoff; allowed: <= {CUTOFF - 2 * core['radius']:g}",
            )
