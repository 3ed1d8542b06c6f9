"""WHAT is simulated: a validated, hashable description that knows what it needs."""

import json
import math
import os
from collections.abc import Iterable, Mapping
from functools import cached_property
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple, Self

import numpy as np
import yaml

from dpd.digests import value_digest
from dpd.errors import UserError, shown, suggestion
from dpd.page import BondForce, Change, Refusals
from dpd.page.own import blame, check_slope, file_of
from dpd.scene.reading import Settings
from dpd.scene.sections import AXES, CUTOFF, densities, limits, missed_by, unknown_names
from dpd.scene.yaml import changed, read_yaml, value_of

# A list of pairs pays where dt sqrt(kT / m) is little of its skin, and the skin that is best falls
# with the density; both measured (benchmarks/README.md).
SMALL_STEP = {2: 0.15, 3: 0.09}  # of the skin
SKIN, THIN, THICK = 0.35, 0.1, 0.5  # in r_c: at density 1, at least, at most


class Steps(NamedTuple):
    """How many steps a run takes: to equilibrate, and then to sample."""

    equilibrate: int
    sample: int


class Stage(NamedTuple):
    """What a run is like behind a step, until the next one."""

    step: int
    scene: "Scene"


class Scene(Settings):
    """One system and how long it is simulated, as `dpd.scene.sections.Basics` and its pages say.

    ``where`` is the file to name in messages, ``folder`` that from which relative paths count.
    ``pages`` of one's own, beside those that it names, are files, or classes and functions of a
    file or of a notebook's cell. A `UserError` has a line for each mistake.
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
        super().__init__(where)
        # What was chosen for a scene that left scheme and step to us, as plain data: see `settle`.
        self.chosen: dict[str, Any] | None = None
        self.stages: list[Stage] = []  # itself, and with values that change while it runs
        self.stretches = False  # whether a ramp or a schedule changes the box
        try:
            self._build(data, folder)
        except UserError:
            raise
        except (Exception, SystemExit) as problem:  # whatever a page of one's own may raise
            if text := blame(problem, self.page_files):
                raise UserError(f"{where}: {text}") from None
            raise

    def _build(self, data, folder):
        self._load_pages(data.get("pages", []), folder)
        self._read(self._completed(data, folder))
        self.start = self.start.found(folder, self.where)
        self.data["start"] = self.start.plain()
        self.terms = {key: term.found(folder, self.where) for key, term in self.terms.items()}
        self.refuse(densities(self))
        self.refuse(unknown_names(self))
        for key in self.own_pages.keys() & self.terms.keys():
            check_slope(self.terms[key], self)
        for key, term in self.terms.items():
            self.terms[key] = term.completed(self)
            self.data[key] = self.terms[key].plain()
        scheduled = self._scheduled()
        self.refuse(limits(self))
        for key, page in self.observe.items():
            every = page.every or max(1, min(page.steps_between(self), self.steps.sample))
            self.observe[key] = page.model_copy(update={"every": every})
        self.refuse(self.unobserved(self.made))
        self.stages = [Stage(0, self)]
        for key, each in scheduled:
            if each["step"] > (end := sum(self.steps)):
                raise UserError(
                    f"{self.where}: {key}.step: {each['step']} is behind the end of the run, {end}"
                )
            enter(self, each["step"], each["set"], f"{self.where}: {key}")

    def _scheduled(self):
        """The schedule, which has the stages of ramps from here on, and the key of each part."""
        given = self.data.get("schedule", [])
        found = [(f"schedule.{place}", each) for place, each in enumerate(given)]
        for key, ramp in self.ramps.items():
            for each in given:
                if any(f"{key}.".startswith(f"{name}.") for name in each["set"]):
                    self.refuse([(key, "has a ramp, and 'schedule' sets it as well; keep one")])
            found += [(key, each) for each in ramp.stages(key, *self.steps)]
        self.stretches = any("box" in each["set"] for _, each in found)
        if self.ramps:
            found.sort(key=lambda each: each[1]["step"])
            self.data["schedule"] = [each for _, each in found]
        return found

    @classmethod
    def of_result(cls, text: Any, where: str) -> Self:
        """The scene that a result holds, with digests of its pages; refused if it is damaged."""
        try:
            data = dict(json.loads(text))
            pages = [(page["path"], page["sha256"]) for page in data.get("pages", [])]
        except (ValueError, TypeError, KeyError):
            raise UserError(
                f"{where}: its attribute 'scene' is damaged; make the file anew"
            ) from None
        if not all(digest and os.path.isabs(path) for path, digest in pages):
            raise UserError(f"{where}: it names a file of pages without its digest")
        return cls(data, where)

    @classmethod
    def read(
        cls, path: str | Path, pages: Iterable[Any] = (), settings: Iterable[str] = ()
    ) -> Self:
        """Read a scene from a YAML file, with settings as ``--set KEY=VALUE`` has them."""
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
        data = {key: value for key, value in self.data.items() if value and key != "pages"}
        lines = [
            f"<dpd.Scene {self.where}: {self.beads} beads, {len(self.bonded)} bonds in {edges} r_c"
            f", {equilibrate} steps to equilibrate, {sample} to sample "
            f"({self.tau(equilibrate):g} + {self.tau(sample, equilibrate):g} tau)>",
            yaml.safe_dump(data, sort_keys=False, default_flow_style=None).rstrip(),
        ]
        return "\n  ".join([*"\n".join(lines).splitlines(), *self.notes])

    # --- refusing

    def refuse(self, problems: Iterable[tuple[str, str]]) -> None:
        """Raise all problems, if there are any, each a key and a sentence."""
        if found := dict.fromkeys(f"{self.where}: {key}: {text}" for key, text in problems):
            raise UserError("\n".join(found))

    def unobserved(self, made: Mapping[Change, str]) -> Refusals:
        """What observables have against the scene, and the changes that it makes."""
        for key, page in self.observe.items():
            for inside, problem in page.refusals(self, made):
                yield f"observe.{key}.{inside}" if inside else "observe", problem

    # --- what it is

    @property
    def bond_force(self) -> BondForce | None:
        return next((t for t in self.terms.values() if isinstance(t, BondForce)), None)

    @property
    def start_terms(self) -> dict[str, Any]:
        """What acts while a start grows and relaxes, by key: of the scene, but for changes."""
        acting = {key: term for key, term in self.terms.items() if term.in_start}
        acting |= self.start_changes
        return {key: term for key, term in acting.items() if term.joins <= self.start.joins}

    @property
    def relaxing(self) -> int:
        return self.start.relax.steps if self.start.relax else 0

    @property
    def made(self) -> dict[Change, str]:
        """What is done to the world, each change by the key of the first that makes it."""
        found: dict[Change, str] = {Change.STRETCHES: "box"} if self.stretches else {}
        for key, term in self.terms.items():
            for change in term.changes(self):
                found.setdefault(change, key)
        return found

    @cached_property
    def digest(self) -> str:
        """Digest of all that decides the run: of files the content, of pages only settings."""
        observe = {key: page.plain() for key, page in self.observe.items()}
        without = {key: value for key, value in self.data.items() if key != "pages"}
        if "engine" in without:  # by how many processes does not matter, as with threads
            without["engine"] = without["engine"]["name"]
        terms = {key: term.content() for key, term in self.terms.items()}
        return value_digest(without | {"observe": observe, "start": self.start.content()} | terms)

    def files_beside(self, path: str | Path) -> dict[str, Path]:
        """Files that observables write beside the result at a path, as run.gsd, by their keys."""
        asked = self.observe.items()
        return {key: Path(path).with_suffix(page.suffix) for key, page in asked if page.suffix}

    @property
    def kT(self) -> float:
        return float(self.terms["thermostat"].kT)

    @property
    def dt(self) -> float:
        """Time step in tau; with scheme auto a first guess, see `is_auto`."""
        return float(self.terms["integrator"].named.dt)

    @property
    def ranks(self) -> int:
        """Processes that another engine shares the beads among; 1 of our own."""
        return self.data.get("engine", {"ranks": 1})["ranks"]

    @property
    def is_auto(self) -> bool:
        """Whether scheme and step are left to us, and yet to be tried."""
        return self.terms["integrator"].is_auto

    @property
    def notes(self) -> list[str]:
        """Sentences for a person on what the scene does not quite get."""
        missed = [
            f"molecules.{place}.density: {missed_by(self, place)}"
            for place in self.missed_densities
        ]
        return missed + [note for term in self.terms.values() for note in term.notes(self)]

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
        gamma = self.data["thermostat"]["gamma"]
        if not isinstance(gamma, dict):
            return float(gamma)
        by_pair = any(" " in name for name in gamma)
        return self.by_pair(gamma) if by_pair else np.array(self.by_species(gamma))

    @cached_property
    def steps(self) -> Steps:
        """Steps to equilibrate and to sample: the longer of steps and duration."""
        dt = self.dt
        steps, tau = self.data["steps"], self.data["duration"]
        return Steps(*(max(steps.get(k, 0), round(tau.get(k, 0) / dt)) for k in Steps._fields))

    def tau(self, steps: Any, since: int = 0, every: int = 1) -> Any:
        """Time in tau of so many times ``every`` steps behind a step of the run."""
        time, steps = self.dt * every * steps, every * steps
        for former, stage in pairwise(self.stages):
            longer = np.clip(since + steps - max(since, stage.step), 0, None)
            time = time + (stage.scene.dt - former.scene.dt) * longer
        return time

    def during(self, first: int, last: int) -> "list[Scene]":
        """The scenes of the stages that steps behind the first, up to the last, belong to."""
        ends = [stage.step for stage in self.stages[1:]] + [math.inf]
        stages = zip(self.stages, ends)
        return [stage.scene for stage, end in stages if stage.step < last and end > first]

    @property
    def work(self) -> int:
        return self.beads * sum(self.steps)

    @property
    def skin(self) -> float:
        """Skin of the pair list in r_c; 0 for cells."""
        return self.skin_at(self.dt)

    def skin_at(self, dt: float) -> float:
        """Skin with steps of another length."""
        chosen, skin = self.data["pairs"]["search"], self.data["pairs"].get("skin")
        skin = skin or round(min(max(SKIN * self.volume / self.beads, THIN), THICK), 2)
        if chosen == "auto":
            thermal = dt * (self.kT / self.lightest) ** 0.5
            still = not {Change.SLIDES, Change.STRETCHES} & self.made.keys()
            room = still and min(self.period) >= 2 * (CUTOFF + skin)
            chosen = "list" if room and thermal <= SMALL_STEP[self.dimension] * skin else "cells"
        return float(skin) if chosen == "list" else 0.0

    # --- what terms do to the space and to the flow

    @cached_property
    def origin(self) -> tuple[float, ...]:
        """Where the box begins in the periodic one of the engine, which has a gap at ends."""
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
        """The least distances that images of a bead may have along each axis."""
        return tuple(map(min, zip(*(term.room(self) for term in self.terms.values()))))

    @property
    def barostat_axes(self) -> str:
        """The axes along which the box changes its size: ``all``, one of them, or nothing."""
        return "".join(term.barostat_axes for term in self.terms.values())

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


def enter(scene: Scene, step: int, settings: Mapping[str, Any], where: str) -> None:
    """Go on with other values, by keys that are joined by dots, behind a step; or refuse them."""

    def refuse(text):
        raise UserError(f"{where}: {text}")

    last = scene.stages[-1]
    if step < last.step:
        refuse(f"step {step} is before {last.step}, at which a schedule or a ramp changes values")
    for key in settings:
        if (section := key.split(".")[0]) not in scene.terms and key != "box":
            known = suggestion(section, [*scene.terms, "box"])
            refuse(f"{key!r} cannot change while the system runs; {known}")
    if scene.is_auto or scene.data["duration"]:
        refuse("counts steps; name scheme and dt, and 'steps', no duration")
    search = {"search": "list", "skin": scene.skin} if scene.skin else {"search": "cells"}
    data = {key: value for key, value in last.scene.data.items() if key != "schedule"}
    molecules = [
        {key: value for key, value in given.items() if key != "density"} | {"count": kind.count}
        for kind, given in zip(scene.molecules, data["molecules"])
    ]  # fmt: skip
    now = Scene(changed(data | {"pairs": search, "molecules": molecules}, settings, where), where)
    now.stretches = "box" in settings or last.scene.stretches
    for change in scene.made.keys() ^ now.made.keys():
        refuse(
            f"{(scene.made | now.made)[change]!r} would begin or cease to act, which what is "
            "measured must know from the first step; begin with a small value"
        )
    if now.period != scene.period and not scene.stretches:
        refuse("beads would need another room behind walls; take stiffer walls from the beginning")
    for key, term in scene.terms.items():
        if not term.may_become(now.terms[key]):
            refuse(f"{key!r} cannot become this while the system runs: its axes stay")
    if now.dt != last.scene.dt and step > scene.steps.equilibrate:
        scene.refuse(scene.unobserved(scene.made | {Change.VARIES: "schedule"}))
    scene.stages.append(Stage(step, now))
