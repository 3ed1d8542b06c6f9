"""From config to papers and their sweeps, as a study changes them."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from dpd.digest import PAPERS_DIR, ROOT, shortened
from dpd.errors import UserError, shown, suggestion
from dpd.pipeline.derived import check_derived
from dpd.pipeline.sections import Config, PaperFile, Study
from dpd.pipeline.sweep import described_axes, narrowed, unfold
from dpd.pipeline.theory import check_kind, unfold_theory
from dpd.scene.yaml import read_yaml
from dpd.sentences import read_section

if TYPE_CHECKING:
    from collections.abc import Collection

CONFIG = ROOT / "config"
WHERE, ROOT_STUDY = "config/config.yaml", "paper"  # whose values stand where no other is named
NAME = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_.-]*")
SEEDED = re.compile(r"(.*)-seed([0-9]+)")  # a study whose noise is not that of its file's name


@dataclass(frozen=True)
class Figure:
    """What feeds a figure: names of sweeps, and of measurements."""

    sweeps: tuple
    measurements: tuple


@dataclass(frozen=True)
class Paper:
    """A paper under a study.

    Attributes
    ----------
    name, title, reference : str
    sweeps : dict of str to Sweep
        Those that are simulated, by name.
    measurements : tuple of str
    figures : dict of str to Figure
    sampling : tuple of dict
        What the paper says of its own, see `dpd.pipeline.sections.Sampling`.
    theory : dict of str to TheorySweep
        Sweeps that are calculated, by name; no other has the same.
    """

    name: str
    title: str
    reference: str
    sweeps: dict
    measurements: tuple
    figures: dict
    sampling: tuple = ()
    theory: dict = field(default_factory=dict)


def studies() -> dict[str, Study]:
    """All studies by name, as config/config.yaml has them."""
    check_repository()
    config = read_section(Config, read_yaml(CONFIG / "config.yaml"), WHERE)
    if (CONFIG / "studies").exists():
        raise UserError(
            "config/studies: what a study changes stands beside the value in config/papers, as "
            "{paper: 4000, quick: 400}, and its name in config/config.yaml, as studies: {night: "
            "quick}; move it there and remove the folder"
        )
    found = {}
    for name, given in config.studies.items():
        key = f"{WHERE}: studies.{name}"
        _check_name(f"{WHERE}: studies", name)
        if name == "archive" or SEEDED.fullmatch(name):
            raise UserError(f"{key}: results/{name} is not for a study; give it another name")
        if isinstance(given, str):
            given = Study(description=f"As {given}, with values of its own.", parent=given)
        if name != ROOT_STUDY and given.parent not in config.studies:
            said = suggestion(given.parent, config.studies)
            raise UserError(f"{key}: no study {given.parent!r}; {said}")
        found[name] = given
    return found


def lineage(study: str) -> list[str]:
    """Names of a study, of its parent, and so on: the first one that a choice names decides.

    Raises
    ------
    UserError
        If a study is its own parent.
    """
    known, found = studies(), [file_and_seed("study", study)[0]]
    while found[-1] != ROOT_STUDY:
        parent = known[found[-1]].parent
        if parent in found:
            raise UserError(f"{WHERE}: studies.{parent}: its parents lead back to it")
        found.append(parent)
    return found


def as_studied(value: Any, names: list[str], known: Collection[str], key: str) -> Any:
    """Plain data with what a study takes of each choice.

    A choice has names of studies for keys, as ``{paper: 4000, quick: 400}``. Where it names none of
    ``names``, or nothing is behind the name, its key or its place in a list is left out.

    Parameters
    ----------
    value : object
    names : list of str
        Of `lineage`.
    known : collection of str
        Names of all studies.
    key : str
        File to name in messages, as "config/papers/liu_2008.yaml: ", and keys so far.

    Raises
    ------
    UserError
        If some keys are names of studies, and others are not.
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
    """Study and papers as config/config.yaml and the command line have them.

    Parameters
    ----------
    overrides : dict or None
        What stands on the command line.

    Returns
    -------
    dict
        ``study``: a name, which says the seed if that is not 1, ``papers``: names, and the others
        of `dpd.pipeline.sections.Config`.
    """
    check_repository()
    config = read_yaml(CONFIG / "config.yaml") | (overrides or {})
    if overrides and "papers_dir" in overrides:  # the Snakefile has heeded it
        del config["papers_dir"]
    config = read_section(Config, config, WHERE).model_dump()
    if (seed := config.pop("seed")) != 1:
        config["study"] = f"{config['study']}-seed{seed}"
    file_and_seed("study", config["study"])
    for name in config["papers"]:
        _known("papers", name)
    return config


def file_and_seed(key: str, study: str) -> tuple[str, int]:
    """Name of a study, and the seed that all its random numbers follow from.

    ``quick-seed2`` is the study ``quick`` with the seed 2. It is a study like any other, with
    results of its own, wherever a study is named.

    Raises
    ------
    UserError
        Naming ``key``, if there is no such study.
    """
    name, seed = study, 1
    if parts := SEEDED.fullmatch(str(study)):
        name, seed = parts[1], int(parts[2])
        if seed < 2 or study != f"{name}-seed{seed}":
            raise UserError(
                f"{key}: {study!r}: a seed after the name of a study is 2 or more, without zeros "
                f"before it; with the seed 1 it is {name!r}"
            )
    _check_name(key, name)
    if name not in studies():
        raise UserError(
            f"{key}: {shown(name)} is none of the studies in {WHERE}; {suggestion(name, studies())}"
        )
    return name, seed


def read_study(name: str) -> Study:
    """A study by name."""
    file, seed = file_and_seed("study", name)
    study = studies()[file]
    for number, said in enumerate(study.first or ()):
        _known(f"{WHERE}: studies.{file}.first.{number}", said.rpartition(".")[0])
    if seed != 1:
        return study.model_copy(
            update={"description": f"With the seed {seed}: {study.description}"}
        )
    return study


def read_paper(
    name: str, study: str, only: Collection[str] | None = None, points: Collection[str] = ()
) -> Paper:
    """A paper's sweeps and figures under a study.

    Parameters
    ----------
    name, study : str
    only : collection of str or None
        Unfold these sweeps alone.
    points : collection of str
        Unfold no more of each of them than has these points, with their replicas.

    Returns
    -------
    Paper

    Raises
    ------
    UserError
        If anything in the files is not allowed, or they do not fit together.
    """
    path = _known("papers", name)
    where = shortened(path)
    first, seed = read_study(study).first or (), file_and_seed("study", study)[1]
    names, given = lineage(study), read_yaml(path)
    paper = as_studied(given, names, studies(), f"{where}: ")
    read_section(PaperFile, paper, where)
    _check_first(first, name, paper["sweeps"], f"{WHERE}: studies.{names[0]}")
    for sweep, given in paper["sweeps"].items():
        check_kind(given, f"{where}: sweeps.{sweep}")
    _check_seeds(paper["sweeps"], f"{where}: sweeps")
    measurements = tuple(paper.get("measurements", ()))
    for measurement in measurements:
        if measurement in paper["sweeps"]:
            raise UserError(
                f"{where}: measurements: {measurement!r} is the name of a sweep as well, and a "
                "figure could not tell them apart; rename the sweep"
            )
    figures = {
        figure: _feeds(given, paper["sweeps"], measurements, f"{where}: figures.{figure}")
        for figure, given in paper.get("figures", {}).items()
    }
    for sweep in only or ():
        if sweep not in paper["sweeps"]:
            raise UserError(f"{where}: no sweep {sweep!r}; {suggestion(sweep, paper['sweeps'])}")
    axes = {
        sweep: described_axes(given, f"{where}: sweeps.{sweep}.axes")
        for sweep, given in paper["sweeps"].items()
    }
    for sweep in paper["sweeps"]:
        check_derived(sweep, paper["sweeps"], axes, f"{where}: sweeps.{sweep}.derive")
    sweeps, theory = {}, {}
    for sweep, given in paper["sweeps"].items():
        key = f"{where}: sweeps.{sweep}"
        if only is not None and sweep not in only:
            continue
        described = narrowed(axes[sweep], points) if points else axes[sweep]
        if "theory" in given:
            theory[sweep] = unfold_theory(name, sweep, given, key, described, seed)
        else:
            sweeps[sweep] = unfold(name, sweep, given, key, described, path.parent, seed)
    sampling = tuple(paper.get("sampling", ()))
    _check_sampling(sampling, paper["sweeps"], f"{where}: sampling")
    reference = paper.get("reference", "")
    return Paper(name, paper["title"], reference, sweeps, measurements, figures, sampling, theory)


def _check_first(first, name, sweeps, where):
    """Refuse an order of sweeps that names one which the paper has not."""
    for number, said in enumerate(first):
        paper, _, sweep = said.rpartition(".")
        if paper == name and sweep not in sweeps:
            raise UserError(
                f"{where}.first.{number}: {name} has no sweep {sweep!r}; "
                f"{suggestion(sweep, sweeps)}"
            )
        if paper == name and "theory" in sweeps[sweep]:
            raise UserError(f"{where}.first.{number}: {sweep!r} is calculated and has no runs")


def _check_seeds(sweeps, key):
    """Refuse two sweeps with the same seeds: their noise would be the same."""
    users = {}
    for sweep, given in sweeps.items():
        seeds = given.get("seeds", sweep)
        if seeds in users:
            raise UserError(
                f"{key}.{sweep}.seeds: {seeds!r} gives it the noise of the sweep {users[seeds]!r}, "
                "and what comes of both would not be independent; allowed: the former name of a "
                "sweep that was renamed"
            )
        users[seeds] = sweep


def _check_sampling(sampling, sweeps, key):
    """Refuse what is said of a sweep that the paper has not."""
    for number, said in enumerate(sampling):
        for sweep in said["sweeps"]:
            if sweep not in sweeps:
                raise UserError(
                    f"{key}.{number}.sweeps: no sweep {sweep!r}; {suggestion(sweep, sweeps)}"
                )
            if "theory" in sweeps[sweep]:
                raise UserError(f"{key}.{number}.sweeps: {sweep!r} is calculated and has no runs")
            axes = sweeps[sweep].get("axes", {})
            for axis in said.get("at", {}):
                if axis not in axes:
                    raise UserError(
                        f"{key}.{number}.at: sweep {sweep} has no axis {axis!r}; "
                        f"{suggestion(axis, axes)}"
                    )


def _feeds(given, sweeps, measurements, key):
    """A `Figure`, refused if it names what the paper has not."""
    named = {}
    for kind, there in (("sweeps", sweeps), ("measurements", measurements)):
        named[kind] = tuple(given.get(kind, ()))
        for name in named[kind]:
            if name not in there:
                raise UserError(f"{key}.{kind}: no {kind[:-1]} {name!r}; {suggestion(name, there)}")
    return Figure(**named)


def check_paper_name(name: str) -> None:
    """Refuse a name that a paper of one's own could not have, or no repository to put it in."""
    check_repository()
    _check_name("papers", name)


def check_repository() -> None:
    """Refuse to go on without the project's repository, where its papers and studies are.

    Raises
    ------
    UserError
    """
    if not (CONFIG / "config.yaml").is_file():
        raise UserError(
            f"{CONFIG}: there is no config.yaml, and papers and studies are wanted, which only the "
            "project's repository holds; change to the folder of a clone and try again there"
        )


def _known(key, paper):
    """The file of a paper, refused if there is none, or two."""
    check_repository()
    _check_name(key, paper)
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


def _check_name(key, name):
    """Refuse a name that would not do for a folder, or would mean something in a shell."""
    if not NAME.fullmatch(str(name)):  # YAML has numbers as keys
        raise UserError(
            f"{key}: {shown(name)} cannot be a name here; allowed: letters, digits and _ . -, the "
            "first one no . or -"
        )
