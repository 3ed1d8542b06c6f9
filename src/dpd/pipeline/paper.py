"""The file of a paper: its sweeps and figures, under a study."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Annotated, Any, Literal, NamedTuple

from pydantic import Field

from dpd.digest import shortened
from dpd.errors import UserError, suggestion
from dpd.page import NAMES, Refusals, Section, inside, setting
from dpd.pipeline.study import (
    WHERE,
    as_studied,
    file_and_seed,
    file_of_paper,
    lineage,
    read_study,
    studies,
)
from dpd.pipeline.sweep import Sweep, SweepFile, Value, unfold
from dpd.pipeline.theory import TheorySweep, unfold_theory
from dpd.scene.yaml import read_yaml
from dpd.sentences import read_section

if TYPE_CHECKING:
    from collections.abc import Collection

KEY = r"^[a-z][a-z0-9_]{0,79}$"
NAMES[KEY] = "small letters, digits and _, up to 80"
Key = Annotated[str, Field(pattern=KEY)]
Measurement = Literal["lammps", "scaling", "schemes", "features", "tension"]
MEASURED = ("closest_contact",)  # of a sweep that is simulated, see `structure.derive`


class Sampling(Section):
    """What the paper says of its own sampling."""

    sweeps: list[str] = setting("Names of sweeps that do what the paper did.", min_length=1)
    at: dict[str, Annotated[list[Value], Field(min_length=1)]] | None = setting(
        "Labels on axes of these sweeps, if it says so of some points alone.", None
    )
    steps: int | None = setting("Steps that the paper sampled.", None, ge=1)
    dt: float | None = setting("Its time step in tau, if runs of ours have another.", None, gt=0)
    duration: float | None = setting(
        "Time in tau that it sampled, if it gives that and no steps.", None, gt=0
    )
    runs: int | None = setting("Runs of that many steps, if there were several.", None, ge=1)
    at_least: bool = setting('Whether the text says "at least".', False)
    beads: int | None = setting("Number of beads in its system.", None, ge=1)
    molecules: int | None = setting("Number of molecules in its system.", None, ge=1)
    where: str = setting("Section, figure or table that says so, or that leaves it unsaid.")

    def conflicts(self) -> Refusals:
        """Steps and a duration, and what belongs to steps without them."""
        if self.steps is not None and self.duration is not None:
            yield "duration", "there are 'steps' as well; keep one"
        for key in ("runs", "dt"):
            if getattr(self, key) is not None and self.steps is None:
                yield key, "the key 'steps' is missing, which it belongs to"


class FigureFile(Section):
    """What a figure is made from."""

    sweeps: list[str] = setting("Names of sweeps.", [])
    measurements: list[str] = setting("Names of measurements.", [])


class PaperFile(Section):
    """The sweeps of a paper, timings of the engine, and the figures that are made from them."""

    title: str = setting("Title for the report.")
    reference: str = setting("Where it was published.", "")
    sweeps: dict[Key, SweepFile] = setting("Named families of runs.")
    measurements: list[Measurement] = setting(
        "Timings of the engine that figures need; for the benchmark.", []
    )
    sampling: list[Sampling] = setting(
        "What the paper says of its own sampling. The report compares the sweeps with it. What the "
        "paper leaves unsaid has a `where` alone; sweeps that are not named have no counterpart in "
        "the paper.", [],
    )  # fmt: skip
    figures: dict[Key, FigureFile] = setting(
        "What each figure is made from, by the name of its file in paper_figures.", {}
    )

    def conflicts(self) -> Refusals:
        """What is wrong with a sweep, and names of what the paper has not, or has twice."""
        for name, sweep in self.sweeps.items():
            yield from inside(f"sweeps.{name}", sweep.conflicts())
            yield from inside(f"sweeps.{name}.derive", self._derived(name))
        yield from self._seeds()
        for name in self.measurements:
            if name in self.sweeps:
                text = (
                    f"{name!r} is the name of a sweep as well, and a figure could not tell them "
                    "apart; rename the sweep"
                )
                yield "measurements", text
        for figure, given in self.figures.items():
            for kind, there in (("sweeps", self.sweeps), ("measurements", self.measurements)):
                for name in getattr(given, kind):
                    if name not in there:
                        said = f"no {kind[:-1]} {name!r}; {suggestion(name, there)}"
                        yield f"figures.{figure}.{kind}", said
        for number, sampling in enumerate(self.sampling):
            yield from inside(f"sampling.{number}", sampling.conflicts())
            yield from inside(f"sampling.{number}", self._sampled(sampling))

    def _seeds(self):
        """Two sweeps with the same seeds: their noise would be the same."""
        users: dict[str, str] = {}
        for name, sweep in self.sweeps.items():
            seeds = sweep.seeds or name
            if seeds in users:
                text = (
                    f"{seeds!r} gives it the noise of the sweep {users[seeds]!r}; allowed: the "
                    "former name of a sweep that was renamed"
                )
                yield f"sweeps.{name}.seeds", text
            users[seeds] = name

    def _sampled(self, said):
        """What is said of the sampling of a sweep that the paper has not, or has no runs."""
        for name in said.sweeps:
            if name not in self.sweeps:
                yield "sweeps", f"no sweep {name!r}; {suggestion(name, self.sweeps)}"
                continue
            if self.sweeps[name].theory is not None:
                yield "sweeps", f"{name!r} is calculated and has no runs"
            axes = self.sweeps[name].axes or {}
            for axis in said.at or {}:
                if axis not in axes:
                    yield "at", f"sweep {name} has no axis {axis!r}; {suggestion(axis, axes)}"

    def _derived(self, name):
        """Sources that are no sweep, are derived themselves, or have not the values it needs."""
        own, scene = self.sweeps[name].axes or {}, self.sweeps[name].scene
        for key, rule in (self.sweeps[name].derive or {}).items():
            if not _has(scene, key):
                text = (
                    "the sweep's scene has no such key; give it there with a value to plan with, "
                    "or correct the key"
                )
                yield key, text
            source = self.sweeps.get(rule.from_)
            if source is None:
                said = f"no sweep {rule.from_!r}; {suggestion(rule.from_, self.sweeps)}"
                yield f"{key}.from", said
                continue
            if source.theory is None and rule.quantity not in MEASURED:
                said = f"no quantity {rule.quantity!r}; {suggestion(rule.quantity, MEASURED)}"
                yield f"{key}.quantity", said
            yield from inside(f"{key}.from", _unlike(own, source, rule.from_))


def _unlike(own, source, name):
    """Why points with some axes do not find theirs in the sweep that measures for them."""
    axes = source.axes or {}
    if source.derive:
        yield "", f"{name!r} has derived values itself; name a sweep that has none"
    if not own.keys() & axes.keys():
        yield "", f"{name!r} shares no axis with this sweep; its axes: {', '.join(axes) or 'none'}"
    for axis, described in axes.items():
        if axis not in own and len(described.taken) > 1:
            yield "", f"{name!r} has several values on the axis {axis!r}; give it one"
        for value in own[axis].taken if axis in own else ():
            if value not in described.taken:
                yield "", f"{name!r} has no {axis} {value}, which this sweep needs; add it there"


def _has(scene, key):
    """Whether a scene has a key of dotted parts."""
    for part in key.split("."):
        if not isinstance(scene, dict) or part not in scene:
            return False
        scene = scene[part]
    return True


class Figure(NamedTuple):
    """What feeds a figure: names of sweeps, and of measurements."""

    sweeps: tuple[str, ...]
    measurements: tuple[str, ...]


@dataclass(frozen=True)
class Paper:
    """A paper under a study."""

    name: str
    title: str
    reference: str
    sweeps: dict[str, Sweep]  # those that are simulated
    measurements: tuple[str, ...]
    figures: dict[str, Figure]
    sampling: tuple[dict[str, Any], ...] = ()  # what is given of each `Sampling`
    theory: dict[str, TheorySweep] = field(default_factory=dict)  # those that are calculated


def read_paper(
    name: str, study: str, only: Collection[str] | None = None, points: Collection[str] = ()
) -> Paper:
    """A paper's sweeps and figures under a study; of them ``only`` some sweeps, if not None.

    Where ``points`` are named, no more than these are unfolded, in a sweep that has them. Raises
    `UserError` if anything in the files is not allowed, or they do not fit together.
    """
    path = file_of_paper("papers", name)
    where, names = shortened(path), lineage(study)
    first, seed = read_study(study).first or (), file_and_seed("study", study)[1]
    given = as_studied(read_yaml(path), names, studies(), f"{where}: ")
    paper = read_section(PaperFile, given, where)
    runs = [sweep for sweep, given in paper.sweeps.items() if given.theory is None]
    for number, (of, _, sweep) in enumerate(each.rpartition(".") for each in first):
        if of == name and sweep not in runs:
            said = f"{WHERE}: studies.{names[0]}.first.{number}"
            raise UserError(f"{said}: {name} has no sweep {sweep!r}; {suggestion(sweep, runs)}")
    for sweep in only or ():
        if sweep not in paper.sweeps:
            raise UserError(f"{where}: no sweep {sweep!r}; {suggestion(sweep, paper.sweeps)}")
    sweeps, theory = {}, {}
    for sweep, given in paper.sweeps.items():
        key = f"{where}: sweeps.{sweep}"
        if only is not None and sweep not in only:
            continue
        if given.theory is not None:
            theory[sweep] = unfold_theory(name, sweep, given, key, seed)
        else:
            sweeps[sweep] = unfold(name, sweep, given, key, path.parent, seed, points)
    figures = {
        figure: Figure(tuple(given.sweeps), tuple(given.measurements))
        for figure, given in paper.figures.items()
    }
    sampling = tuple(said.model_dump(exclude_unset=True) for said in paper.sampling)
    return Paper(
        name, paper.title, paper.reference, sweeps, tuple(paper.measurements), figures, sampling,
        theory,
    )  # fmt: skip
