"""Which study of which papers, and what a study takes of the values beside each other."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import Field, Tag

from dpd.digest import PAPERS_DIR, ROOT, shortened
from dpd.errors import UserError, shown, suggestion
from dpd.page import OR_TABLE, Refusals, Section, setting
from dpd.scene.yaml import read_yaml
from dpd.sentences import read_section

if TYPE_CHECKING:
    from collections.abc import Collection
    from pathlib import Path

CONFIG = ROOT / "config"
WHERE, ROOT_STUDY = "config/config.yaml", "paper"  # whose values stand where no other is named
NAME = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_.-]*")
SEEDED = re.compile(r"(.*)-seed([0-9]+)")  # a study whose noise is not that of its file's name


class Study(Section):
    """How long and how large the simulations are; see `as_studied`."""

    description: str = setting("One line for the report.")
    parent: str = setting("The study whose values it has where it has none of its own.", "paper")
    first: list[Annotated[str, Field(pattern="[.]")]] | None = setting(
        "Sweeps whose runs begin before those of all others, as paper.sweep, the one of the "
        "greatest worth in front, so that a study that is stopped has made what matters most. Of "
        "each of them the shortest run is first. If not given, the longest run of all is first.",
        None,
    )


class Config(Section):
    """Which study of which papers."""

    study: str = setting("Name of one of the studies.")
    studies: dict[
        str,
        Annotated[Annotated[str, Tag("=one")] | Annotated[Study, Tag("=table")], OR_TABLE],
    ] = setting("Studies by name; a name alone is that of the parent, as `night: quick`.")
    seed: int = setting(
        "That all random numbers of the study follow from. With another than 1 its results are "
        "results/STUDY-seedN, and STUDY-seedN is its name in all commands.", 1, ge=1, le=10**9,
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
        """Studies without the one whose values the papers' files have first, and theirs."""
        if "paper" not in self.studies:
            yield "studies", "the study 'paper' is missing, of which all others are children"


def studies() -> dict[str, Study]:
    """All studies by name, as config/config.yaml has them."""
    check_repository()
    config = read_section(Config, read_yaml(CONFIG / "config.yaml"), WHERE)
    found = {}
    for name, given in config.studies.items():
        key = f"{WHERE}: studies.{name}"
        check_name(f"{WHERE}: studies", name)
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

    Raises `UserError` if a study is its own parent.
    """
    known, found = studies(), [file_and_seed("study", study)[0]]
    while found[-1] != ROOT_STUDY:
        parent = known[found[-1]].parent
        if parent in found:
            raise UserError(f"{WHERE}: studies.{parent}: its parents lead back to it")
        found.append(parent)
    return found


def as_studied(value: Any, names: list[str], known: Collection[str], key: str) -> Any:
    """Plain data with what a study takes of each choice, as ``{paper: 4000, quick: 400}``.

    Where a choice names none of ``names``, or nothing is behind the name, its key or its place in a
    list is left out. Raises `UserError` if only some of its keys are names of studies.

    ``names``: of `lineage`. ``known``: of all studies. ``key``: file and keys so far, for messages.
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
    if (seed := config.pop("seed")) != 1:
        config["study"] = f"{config['study']}-seed{seed}"
    file_and_seed("study", config["study"])
    for name in config["papers"]:
        file_of_paper("papers", name)
    return config


def file_and_seed(key: str, study: str) -> tuple[str, int]:
    """Name of a study, and the seed that all its random numbers follow from.

    ``quick-seed2`` is the study ``quick`` with the seed 2. It is a study like any other, with
    results of its own, wherever a study is named. Raises `UserError` that names ``key``.
    """
    name, seed = study, 1
    if parts := SEEDED.fullmatch(str(study)):
        name, seed = parts[1], int(parts[2])
        if seed < 2 or study != f"{name}-seed{seed}":
            raise UserError(
                f"{key}: {study!r}: a seed after the name of a study is 2 or more, without zeros "
                f"before it; with the seed 1 it is {name!r}"
            )
    check_name(key, name)
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
        file_of_paper(f"{WHERE}: studies.{file}.first.{number}", said.rpartition(".")[0])
    if seed != 1:
        return study.model_copy(
            update={"description": f"With the seed {seed}: {study.description}"}
        )
    return study


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
        raise UserError(
            f"{key}: {shown(name)} cannot be a name here; allowed: letters, digits and _ . -, the "
            "first one no . or -"
        )
