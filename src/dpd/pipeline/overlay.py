"""What a study puts in place of a paper's values, and whether somebody edited what is replaced."""

from __future__ import annotations

import subprocess
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import yaml

from dpd.digest import ROOT
from dpd.pipeline.study import file_and_seed, read_paper
from dpd.scene.yaml import Loader, read_yaml

if TYPE_CHECKING:
    from collections.abc import Iterable


BASES = ("scene", "theory")  # what the axes of a sweep change: it has one of these


@dataclass(frozen=True)
class Replaced:
    """A value of a paper's sweep that a study replaces.

    Attributes
    ----------
    sweep, key : str
        The key below the sweep: ``scene.box``, ``axes.density``, ``replicas``; of a sweep that is
        calculated, ``theory.second_virial.samples``.
    paper, study : object
        The values; None where the paper has none.
    """

    sweep: str
    key: str
    paper: object
    study: object


def paper_file(paper: str) -> str:
    """Of a paper, below the repository."""
    return f"config/papers/{paper}.yaml"


def study_file(study: str) -> str:
    """Of a study, below the repository."""
    return f"config/studies/{file_and_seed('study', study)[0]}.yaml"


def replaced_values(paper: dict[str, Any], changes: dict[str, Any]) -> list[Replaced]:
    """Every value of a paper's sweeps that a study replaces.

    Parameters
    ----------
    paper : dict
        As its file has it.
    changes : dict
        What the study's file has below ``papers`` and the paper's name.

    Returns
    -------
    list of Replaced
    """
    found = []
    for sweep, change in changes.items():
        given = paper["sweeps"].get(sweep, {})
        if "replicas" in change:
            found.append(Replaced(sweep, "replicas", given.get("replicas"), change["replicas"]))
        for base in BASES:
            for key, old, new in _leaves(change.get(base, {}), given.get(base), base):
                found.append(Replaced(sweep, key, old, new))
        for axis, new in change.get("axes", {}).items():
            old = given.get("axes", {}).get(axis, {}).get("values")
            if isinstance(old, dict) and isinstance(new, list):
                old = list(old)  # the study names some labels; what they mean is the paper's
            found.append(Replaced(sweep, f"axes.{axis}", old, new))
    return found


def _leaves(change, base, key):
    """Dotted key, old and new value of all that a change of a scene puts in."""
    if not isinstance(change, dict):
        yield key, base, change
        return
    for part, value in change.items():
        yield from _leaves(value, _item(base, part), f"{key}.{part}")


def _item(base, part):
    if isinstance(base, list):
        return base[int(part)] if str(part).isdigit() and int(part) < len(base) else None
    return base.get(part) if isinstance(base, dict) else None


def edited_in_vain(study: str, papers: Iterable[str]) -> list[str]:
    """Sentences on edits of a paper's file that do nothing, because the study has its own value.

    An edit is what differs from the last commit. Where the study's own value was edited as well,
    its author knows of it, and nothing is said. Without a commit to compare with, one sentence
    says that values are replaced at all.

    Parameters
    ----------
    study : str
    papers : collection of str

    Returns
    -------
    list of str
    """
    now, before = read_yaml(ROOT / study_file(study)), _committed(study_file(study))
    said = []
    for paper in papers:
        changes = now.get("papers", {}).get(paper, {})
        values = replaced_values(read_yaml(ROOT / paper_file(paper)), changes)
        committed = _committed(paper_file(paper))
        if before is None or committed is None:
            said += [_hint(study, paper)] if values else []
            continue
        old_changes = before.get("papers", {}).get(paper, {})
        known = {(r.sweep, r.key): r for r in replaced_values(committed, old_changes)}
        for value in values:
            was = known.get((value.sweep, value.key))
            if was and was.paper != value.paper and was.study == value.study:
                said.append(_in_vain(study, paper, value))
    return said


def _hint(study, paper):
    return (
        f"{study_file(study)} replaces values of {paper_file(paper)}; which: "
        f"python -m dpd show {study} {paper}"
    )


def _in_vain(study, paper, value):
    return (
        f"{paper_file(paper)}: sweeps.{value.sweep}.{value.key} was edited, which changes nothing "
        f"in the {study} study: {study_file(study)} has its own, papers.{paper}.{value.sweep}."
        f"{value.key}: {_plain(value.study)}. Edit that, or take it out to run the paper's"
    )


def _committed(path):
    """A YAML file as the last commit has it; None if there is none, or it is no YAML."""
    command = ["git", "show", f"HEAD:./{path}"]
    try:
        found = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    except OSError:  # no git here
        return None
    if found.returncode:
        return None
    try:
        data = yaml.load(found.stdout, Loader)
    except yaml.YAMLError:
        return None
    return data if isinstance(data, dict) else None


def overview(study: str, paper: str) -> str:
    """Every value of a paper that a study replaces, a line each.

    Parameters
    ----------
    study, paper : str

    Returns
    -------
    str
    """
    read_paper(paper, study, only=[])  # refuses what does not fit together
    changes = read_yaml(ROOT / study_file(study)).get("papers", {}).get(paper, {})
    lines = [
        f"  sweeps.{value.sweep}.{value.key}: {_plain(value.study)} in place of "
        f"{_plain(value.paper)}"
        for value in replaced_values(read_yaml(ROOT / paper_file(paper)), changes)
    ]
    lines += [
        f"  sweeps.{sweep}: {change['sampling']:g} times as long"
        for sweep, change in changes.items()
        if "sampling" in change
    ]
    head = (
        f"{paper}: {study_file(study)} replaces {len(lines) or 'no'} values of {paper_file(paper)}"
    )
    return "\n".join([head, *lines])


def sweep_in_force(study: str, paper: str, name: str) -> str:
    """A sweep as a study runs it: each value with the file that it comes from, and the points.

    Parameters
    ----------
    study, paper, name : str

    Returns
    -------
    str
    """
    read = read_paper(paper, study, only=[name])
    is_calculated = name in read.theory
    sweep = read.theory[name] if is_calculated else read.sweeps[name]
    given = read_yaml(ROOT / paper_file(paper))
    changes = read_yaml(ROOT / study_file(study)).get("papers", {}).get(paper, {})
    own = {v.key: v for v in replaced_values(given, changes) if v.sweep == name}
    axes = {f"axes.{a.name}": list(a.labels) for a in sweep.axes if a.name != "replica"}
    rows = [
        (key, _plain(value), _source(own.get(key), study, paper)) for key, value in axes.items()
    ]
    if not is_calculated:
        replicas = str(len(sweep.axes[-1].labels))
        rows.append(("replicas", replicas, _source(own.get("replicas"), study, paper)))
    base = "theory" if is_calculated else "scene"
    written = dict(_scalars(given["sweeps"][name][base], base))
    for key, value in own.items():
        if key.startswith(f"{base}."):
            written = {k: v for k, v in written.items() if not k.startswith(f"{key}.")}
            written[key] = value.study
    rows += [
        (key, _plain(value), _source(own.get(key), study, paper)) for key, value in written.items()
    ]
    factor = changes.get(name, {}).get("sampling", 1)
    if factor != 1:
        rows.append(("sampling", f"steps and duration times {factor:g}", study_file(study)))
    longest_key = max(len(key) for key, _, _ in rows)
    longest_value = max(len(value) for _, value, _ in rows)
    made = "points, calculated" if is_calculated else "runs"
    lines = [f"{name} of {paper} in the {study} study: {len(sweep.points)} {made}"]
    lines += [
        f"  {key:{longest_key}s}  {value:{longest_value}s}  {file}" for key, value, file in rows
    ]
    if axes:
        lines.append(f"What an axis sets counts more than the {base}. Points:")
    return "\n".join([*lines, *(f"  {point.name}" for point in sweep.points)])


def _source(value, study, paper):
    if value is None:
        return paper_file(paper)
    old = "nothing" if value.paper is None else _plain(value.paper)
    return f"{study_file(study)}, in place of {old} of {paper_file(paper)}"


def _scalars(scene, key):
    """Dotted key and value of all that a scene says; lists of plain values stay whole."""
    if isinstance(scene, dict):
        items = scene.items()
    elif isinstance(scene, list) and any(isinstance(item, dict) for item in scene):
        items = enumerate(scene)
    else:
        yield key, scene
        return
    for part, value in items:
        yield from _scalars(value, f"{key}.{part}")


def _plain(value):
    """A value as one would write it in YAML, on one line."""
    return yaml.safe_dump(value, default_flow_style=True, width=10**6).removesuffix("...\n").strip()
