"""Studies and papers: what their files say, and a paper's sweeps and figures under a study."""

import re
from collections.abc import Collection
from dataclasses import dataclass, field
from math import prod
from pathlib import Path
from typing import Annotated, Any, Literal, NamedTuple

from pydantic import Field

from dpd.errors import UserError, shown, suggestion
from dpd.folders import PAPERS_DIR, ROOT, shortened
from dpd.page import NAMES, OneOr, Refusals, Section, inside, setting
from dpd.pipeline.sweep import Sweep, SweepFile, Value, unfold
from dpd.scene.yaml import read_section, read_yaml

CONFIG = ROOT / "config"
WHERE, ROOT_STUDY = "config/config.yaml", "paper"  # whose values stand where no other is named
NAME = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_.-]*")
# The name of a study, on what engine, and with a seed of its own.
VARIANT = re.compile(r"(.*?)(-lammps)?(?:-seed([2-9]|[1-9][0-9]+))?")
FILE = f"^{NAME.pattern}$"
NAMES[FILE] = "letters, digits and _ . -, the first one no . or -"
KEY = r"^[a-z][a-z0-9_]{0,79}$"
NAMES[KEY] = "small letters, digits and _, up to 80"
Key = Annotated[str, Field(pattern=KEY)]
Measurement = Literal["lammps", "scaling", "schemes", "features", "tension"]
MEASURED = ("closest_contact",)  # of a sweep that is simulated, see `structure.derive`


# --- studies


class Study(Section):
    """How long and how large the simulations are; see `as_studied`."""

    description: str = setting("One line for the report.")
    parent: str = setting("The study whose values it has where it has none of its own.", "paper")


class Config(Section):
    """Which study of which papers."""

    study: str = setting("Name of one of the studies.")
    studies: dict[Annotated[str, Field(pattern=FILE)], OneOr[str, Study]] = setting(
        "Studies by name; a name alone is that of the parent, as `night: quick`."
    )
    seed: int = setting(
        "That all random numbers of the study follow from. With another than 1 its results are "
        "results/STUDY-seedN, and STUDY-seedN is its name in all commands.", 1, ge=1, le=10**9,
    )  # fmt: skip
    engine: Literal["lammps"] | None = setting(
        "What moves the beads, if not our own engine. Of a study it makes what it can have, in "
        "results/STUDY-lammps.", None,
    )  # fmt: skip
    longest_job: int = setting(
        "Minutes that a job on a cluster may ask for; a run that needs more goes on in its next "
        "try.", 1440, ge=10,
    )  # fmt: skip
    batch: float = setting(
        "Seconds: runs that are expected to take less share a job, as many as that makes.", 60, ge=0
    )
    papers: list[str] = setting("Names of files in config/papers.", min_length=1)

    def conflicts(self) -> Refusals:
        """Studies without the one whose values the papers' files have first; children before it."""
        if ROOT_STUDY not in self.studies:
            yield "studies", "the study 'paper' is missing, of which all others are children"
        known = [ROOT_STUDY]
        for name, given in self.studies.items():
            if name == "archive" or variant_of(name)[0] != name:
                yield f"studies.{name}", f"results/{name} is not for a study; give another name"
            parent = given if isinstance(given, str) else given.parent
            if parent not in known:
                said = f"no study {parent!r} above it; {suggestion(parent, known)}"
                yield f"studies.{name}", said
            known.append(name)


class StudyNamed(NamedTuple):
    """A study as commands name it: with its seed."""

    description: str
    lineage: list[str]  # its name, that of its parent, ...: the first that a choice names decides
    seed: int  # that all its random numbers follow from
    engine: bool  # whether LAMMPS makes it


def studies() -> dict[str, Study]:
    """All studies by name, as config/config.yaml has them."""
    check_repository()
    given = read_section(Config, read_yaml(CONFIG / "config.yaml"), WHERE).studies
    return {
        name: Study(description=f"As {each}, with values of its own.", parent=each)
        if isinstance(each, str) else each for name, each in given.items()
    }  # fmt: skip


def as_studied(value: Any, names: list[str], known: Collection[str], key: str) -> Any:
    """Plain data with what a study takes of each choice, as ``{paper: 4000, quick: 400}``.

    Where a choice has none of the ``names`` of its lineage, or nothing behind it, its key, or place
    in a list, goes. `UserError` if some of its keys are names of ``known`` studies, and others not.
    """
    if isinstance(value, list):
        found = [as_studied(each, names, known, f"{key}{n}.") for n, each in enumerate(value)]
        return [each for each, given in zip(found, value) if each is not None or given is None]
    if not isinstance(value, dict):
        return value
    if named := [each for each in value if each in known]:
        for each in value:
            if each not in named:
                raise UserError(
                    f"{key.rstrip('.: ')}: {each!r} stands beside {named[0]!r}, the name of a "
                    f"study, and is none; {suggestion(each, known)}"
                )
        taken = next((name for name in names if name in value), None)
        return None if taken is None else as_studied(value[taken], names, known, key)
    inside = {k: as_studied(each, names, known, f"{key}{k}.") for k, each in value.items()}
    return {k: each for k, each in inside.items() if each is not None or value[k] is None}


def read_config(overrides: dict[str, Any] | None = None) -> dict[str, Any]:
    """The `Config` of config/config.yaml and the command line; its study's name says the seed."""
    check_repository()
    config = read_yaml(CONFIG / "config.yaml") | (overrides or {})
    if overrides and "papers_dir" in overrides:  # the Snakefile has heeded it
        del config["papers_dir"]
    config = read_section(Config, config, WHERE).model_dump()
    if engine := config.pop("engine"):
        config["study"] += f"-{engine}"
    if (seed := config.pop("seed")) != 1:
        config["study"] += f"-seed{seed}"
    read_study(config["study"])
    for name in config["papers"]:
        file_of_paper("papers", name)
    return config


def read_study(name: str, key: str = "study") -> StudyNamed:
    """What a study's name says, as ``quick-seed2``; refused with the ``key`` it stands under."""
    file, engine, seed = variant_of(name)
    known = studies()
    if file not in known:
        raise UserError(
            f"{key}: {shown(file)} is none of the studies in {WHERE}; {suggestion(file, known)}"
        )
    lineage = [file]
    while lineage[-1] != ROOT_STUDY:
        lineage.append(known[lineage[-1]].parent)
    said = known[file].description
    said = said if seed == 1 else f"With the seed {seed}: {said}"
    if engine:
        said = f"By LAMMPS, as far as it can be: {said}"
    return StudyNamed(said, lineage, seed, engine)


def variant_of(study: object) -> tuple[str, bool, int]:
    """Of a study's name that of its values, whether LAMMPS makes it, and its seed."""
    found = VARIANT.fullmatch(str(study))
    name, engine, seed = found.groups() if found else (str(study), None, None)
    return name, bool(engine), int(seed or 1)


def check_repository() -> None:
    """Refuse to go on without the project's repository, where its papers and studies are."""
    if not (CONFIG / "config.yaml").is_file():
        raise UserError(
            f"{CONFIG}: there is no config.yaml, and papers and studies are wanted, which only the "
            "project's repository holds; change to the folder of a clone and try again there"
        )


def file_of_paper(key: str, paper: str) -> Path:
    """The file of a paper, refused if there is none, or two."""
    check_repository()
    check_name(key, paper)
    folders = [CONFIG / "papers", *([PAPERS_DIR] if PAPERS_DIR else [])]
    if not folders[-1].is_dir():
        raise UserError(f"papers_dir: {folders[-1]}: there is no such folder; name that of papers")
    there = [path for folder in folders for path in sorted(folder.glob("*.yaml"))]
    found, names = [path for path in there if path.stem == paper], [path.stem for path in there]
    if len(found) > 1:
        raise UserError(f"{key}: {paper!r} is there twice, {found[0]} and {found[1]}; rename one")
    if not found:
        places = " or ".join(shortened(folder) for folder in folders)
        raise UserError(f"{key}: {shown(paper)} is not in {places}; {suggestion(paper, names)}")
    return found[0]


def check_name(key: str, name: object) -> None:
    """Refuse a name that would not do for a folder, or would mean something in a shell."""
    if not NAME.fullmatch(str(name)):  # YAML has numbers as keys
        raise UserError(f"{key}: {shown(name)} cannot be a name here; allowed: {NAMES[FILE]}")


# --- papers


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


class Figure(Section):
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
    figures: dict[Key, Figure] = setting(
        "What each figure is made from, by the name of its file in paper_figures.", {}
    )

    def conflicts(self) -> Refusals:
        """What is wrong with a sweep, and names of what the paper has not, or has twice."""
        users: dict[str, str] = {}
        for name, sweep in self.sweeps.items():
            yield from inside(f"sweeps.{name}", sweep.conflicts())
            yield from inside(f"sweeps.{name}.derive", self._derived(name))
            seeds = sweep.seeds or name
            if seeds in users:  # their noise would be the same
                text = (
                    f"{seeds!r} gives it the noise of the sweep {users[seeds]!r}; allowed: the "
                    "former name of a sweep that was renamed"
                )
                yield f"sweeps.{name}.seeds", text
            users[seeds] = name
        for figure, given in self.figures.items():
            for kind, there in (("sweeps", self.sweeps), ("measurements", self.measurements)):
                for name in getattr(given, kind):
                    if name not in there:
                        said = f"no {kind[:-1]} {name!r}; {suggestion(name, there)}"
                        yield f"figures.{figure}.{kind}", said
        for number, sampling in enumerate(self.sampling):
            yield from inside(f"sampling.{number}", sampling.conflicts())
            yield from inside(f"sampling.{number}", self._sampled(sampling))

    def _sampled(self, said):
        """What is said of the sampling of a sweep that the paper has not, or has no runs."""
        simulated = {name: each for name, each in self.sweeps.items() if each.theory is None}
        for name in said.sweeps:
            if name not in simulated:
                yield "sweeps", f"no sweep {name!r} with runs; {suggestion(name, simulated)}"
                continue
            axes = simulated[name].axes or {}
            for axis in said.at or {}:
                if axis not in axes:
                    yield "at", f"sweep {name} has no axis {axis!r}; {suggestion(axis, axes)}"

    def _derived(self, name):
        """Sources that are no sweep, are derived themselves, or have not the values it needs."""
        own = self.sweeps[name].axes or {}
        for key, rule in (self.sweeps[name].derive or {}).items():
            place: Any = self.sweeps[name].scene
            for part in key.split("."):
                place = place.get(part) if isinstance(place, dict) else None
            if place is None:
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
            axes = source.axes or {}
            if source.derive:
                text = f"{rule.from_!r} has derived values itself; name a sweep that has none"
                yield f"{key}.from", text
            for axis, described in axes.items():
                if axis not in own and len(described.taken) > 1:
                    text = f"{rule.from_!r} has several values on the axis {axis!r}; give it one"
                    yield f"{key}.from", text
                for value in own[axis].taken if axis in own else ():
                    if value not in described.taken:
                        text = f"{rule.from_!r} has no {axis} {value}, which this sweep needs"
                        yield f"{key}.from", f"{text}; add it there"


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
    theory: dict[str, Sweep] = field(default_factory=dict)  # those that are calculated
    runs: dict[str, int] = field(default_factory=dict)  # how many each simulated one has


def read_paper(
    name: str, study: str, only: Collection[str] | None = None, points: Collection[str] = ()
) -> Paper:
    """A paper under a study; ``only`` some of its sweeps, if not None, and ``points`` in each.

    Raises `UserError` if anything in the files is not allowed, or they do not fit together.
    """
    path = file_of_paper("papers", name)
    where, _, lineage, seed, engine = shortened(path), *read_study(study)
    given = as_studied(read_yaml(path), lineage, studies(), f"{where}: ")
    paper = read_section(PaperFile, given, where)
    for sweep in only or ():
        if sweep not in paper.sweeps:
            raise UserError(f"{where}: no sweep {sweep!r}; {suggestion(sweep, paper.sweeps)}")
    sweeps: dict[str, Sweep] = {}
    theory: dict[str, Sweep] = {}
    left: set[str] = set()  # what another engine cannot have
    for sweep, given in paper.sweeps.items():
        if only is None or sweep in only:
            key, kind = f"{where}: sweeps.{sweep}", sweeps if given.theory is None else theory
            kind[sweep] = unfold(name, sweep, given, key, path.parent, seed, points)
            if engine and given.scene is not None:
                scene = {"engine": {"name": "lammps"}} | given.scene
                there = given.model_copy(update={"scene": scene})
                try:
                    kind[sweep] = unfold(name, sweep, there, key, path.parent, seed, points)
                except UserError:
                    left.add(sweep)
    sampling = tuple(said.model_dump(exclude_unset=True) for said in paper.sampling)
    runs = {
        sweep: each.replicas * prod(len(axis.taken) for axis in (each.axes or {}).values())
        for sweep, each in paper.sweeps.items() if each.theory is None
    }  # fmt: skip
    left |= {n for n, s in sweeps.items() if any(r.from_ in left for r in s.derived.values())}
    sweeps = {n: each for n, each in sweeps.items() if n not in left}
    figures = {n: each for n, each in paper.figures.items() if not left & {*each.sweeps}}
    return Paper(
        name, paper.title, paper.reference, sweeps, tuple(paper.measurements), figures,
        sampling, theory, runs,
    )  # fmt: skip
