"""From config to papers and their sweeps, as a study changes them."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from dpd.digest import ROOT
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
    config = read_section(Config, config, "config/config.yaml").model_dump()
    if (seed := config.pop("seed")) != 1:
        config["study"] = f"{config['study']}-seed{seed}"
    file_and_seed("study", config["study"])
    for name in config["papers"]:
        _known("papers", name, "papers")
    return config


def file_and_seed(key: str, study: str) -> tuple[str, int]:
    """Name of a study's file, and the seed that all its random numbers follow from.

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
        if (CONFIG / "studies" / f"{study}.yaml").is_file():
            raise UserError(
                f"config/studies/{study}.yaml: {study} is the study {name!r} with the seed {seed}; "
                "give the file another name"
            )
        if seed < 2 or study != f"{name}-seed{seed}":
            raise UserError(
                f"{key}: {study!r}: a seed after the name of a study is 2 or more, without zeros "
                f"before it; with the seed 1 it is {name!r}"
            )
    _known(key, name, "studies")
    return name, seed


def read_study(name: str) -> dict[str, Any]:
    """A study by name."""
    file, seed = file_and_seed("study", name)
    where = f"config/studies/{file}.yaml"
    if file == "archive":
        raise UserError(f"{where}: results/archive is not for a study; give it another name")
    study = read_yaml(CONFIG / "studies" / f"{file}.yaml")
    read_section(Study, study, where)
    if seed != 1:
        study["description"] = f"With the seed {seed}: {study['description']}"
    for paper in study.get("papers", {}):
        _known(f"{where}: papers", paper, "papers")
    for number, said in enumerate(study.get("first", ())):
        _known(f"{where}: first.{number}", said.rpartition(".")[0], "papers")
    return study


def read_paper(
    name: str, study: str, only: Collection[str] | None = None, point: str | None = None
) -> Paper:
    """A paper's sweeps and figures under a study.

    Parameters
    ----------
    name, study : str
    only : collection of str or None
        Unfold these sweeps alone.
    point : str or None
        Unfold this point alone of each of them, with its replicas, if they have it.

    Returns
    -------
    Paper

    Raises
    ------
    UserError
        If anything in the files is not allowed, or they do not fit together.
    """
    _known("papers", name, "papers")
    where = f"config/papers/{name}.yaml"
    paper = read_yaml(CONFIG / "papers" / f"{name}.yaml")
    read_section(PaperFile, paper, where)
    studied = read_study(study)
    study, seed = file_and_seed("study", study)
    changes = studied.get("papers", {}).get(name, {})
    _check_first(studied.get("first", ()), name, paper["sweeps"], f"config/studies/{study}.yaml")
    for sweep in changes:
        if sweep not in paper["sweeps"]:
            raise UserError(
                f"config/studies/{study}.yaml: papers.{name}: no sweep {sweep!r}; "
                f"{suggestion(sweep, paper['sweeps'])}"
            )
    for sweep, given in paper["sweeps"].items():
        there = f"config/studies/{study}.yaml: papers.{name}.{sweep}"
        check_kind(given, changes.get(sweep, {}), f"{where}: sweeps.{sweep}", there)
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
        sweep: described_axes(given, changes.get(sweep, {}), f"papers.{name}.{sweep}", study)
        for sweep, given in paper["sweeps"].items()
    }
    for sweep in paper["sweeps"]:
        check_derived(sweep, paper["sweeps"], axes, f"{where}: sweeps.{sweep}.derive")
    sweeps, theory = {}, {}
    for sweep, given in paper["sweeps"].items():
        change, key = changes.get(sweep, {}), f"{where}: sweeps.{sweep}"
        if only is not None and sweep not in only:
            continue
        described = axes[sweep] if point is None else narrowed(axes[sweep], point)
        if "theory" in given:
            theory[sweep] = unfold_theory(sweep, given, change, key, described, study, seed)
        else:
            sweeps[sweep] = unfold(
                name, sweep, given, change, key, described, study, CONFIG / "papers", seed
            )
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
                f"{where}: first.{number}: {name} has no sweep {sweep!r}; "
                f"{suggestion(sweep, sweeps)}"
            )
        if paper == name and "theory" in sweeps[sweep]:
            raise UserError(f"{where}: first.{number}: {sweep!r} is calculated and has no runs")


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


def _known(key, name, folder):
    check_repository()
    _check_name(key, name)
    names = sorted(path.stem for path in (CONFIG / folder).glob("*.yaml"))
    if name not in names:
        raise UserError(
            f"{key}: {shown(name)} is not in config/{folder}; {suggestion(name, names)}"
        )


def _check_name(key, name):
    """Refuse a name that would not do for a folder, or would mean something in a shell."""
    if not NAME.fullmatch(str(name)):  # YAML has numbers as keys
        raise UserError(
            f"{key}: {shown(name)} cannot be a name here; allowed: letters, digits and _ . -, the "
            "first one no . or -"
        )
