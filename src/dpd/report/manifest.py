"""The manifest of an archive: what made its figures, and which sweeps are whole."""

from __future__ import annotations

import hashlib
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

import yaml

from dpd.analysis.collect import reading
from dpd.digest import value_digest
from dpd.errors import UserError
from dpd.files import attribute, attributes
from dpd.report.archive import ARCHIVE
from dpd.report.provenance import commit, library_versions

if TYPE_CHECKING:
    from dpd.pipeline.paths import Results
    from dpd.pipeline.sweep import Sweep
    from dpd.pipeline.theory import TheorySweep
    from dpd.scene.scene import Scene

MANIFEST = "manifest.yaml"
DECIMALS = 3  # of core-hours
HEAD = """\
# Written by `python -m dpd archive`: what made the files beside this one. An archive may have been
# made in parts, on several days and machines: `parts` says what made each, `figures` and `sweeps`
# name their part. core_hours is the time of the runs alone. `scenes` is a digest of what the runs
# of a sweep simulate, `runs` one of seed, scene and sources of those that were made. `calculated`
# has the sweeps of theory, with a digest of the arguments of their points.
"""


@dataclass(frozen=True)
class Machine:
    """Where a part of an archive was made: model of the processor, and cores."""

    processor: str
    cores: int


def read_manifest(study: str) -> dict[str, Any]:
    """The manifest of an archived study.

    Raises
    ------
    UserError
        If there is none.
    """
    if not (found := manifest_of(study)):
        path = ARCHIVE / study / MANIFEST
        raise UserError(f"{path}: there is no such file; 'python -m dpd archive {study}' writes it")
    return found


def manifest_of(study: str) -> dict[str, Any]:
    """The same; an empty one where there is none."""
    path = ARCHIVE / study / MANIFEST
    return yaml.safe_load(path.read_text()) if path.is_file() else {}


def manifest_text(manifest: dict[str, Any]) -> str:
    """A manifest as it is written."""
    return HEAD + yaml.safe_dump(manifest, sort_keys=False, allow_unicode=True, width=100)


def new_part(machine: Machine) -> tuple[str, dict[str, Any]]:
    """Name of a part of an archive that is made now, and what makes it."""
    day, sources = datetime.now(UTC).strftime("%Y-%m-%d"), commit()
    made = {
        "commit": sources, "date": day, "machine": asdict(machine), "versions": library_versions()
    }  # fmt: skip
    return f"{day} {sources}", made


def sweep_record(paper: str, sweep: Sweep, results: Results) -> dict[str, Any]:
    """What the runs of a sweep say of themselves, of those that are there."""
    runs, hours = [], 0.0
    for point in sweep.points:
        path = Path(results.run(paper, sweep.name, point.name))
        if not path.is_file():
            continue
        with reading(path):
            scene, sources = (str(attribute(path, key)) for key in ("scene_digest", "sources"))
            # A run of another scene is left from before the sweep was edited. What a scene
            # derives from other runs is not known here.
            if sweep.derived or scene == point.scene.digest:
                runs.append([point.name, int(attribute(path, "seed")), scene, sources])
                hours += hours_of(path, point.scene)
    scenes = [point.scene for point in sweep.points]
    return {
        "whole": len(runs) == len(scenes),
        "runs_made": len(runs),
        "runs_planned": len(scenes),
        "core_hours": round(hours, DECIMALS),
        "beads": _span([scene.beads for scene in scenes]),
        "steps_equilibrate": _span([scene.steps.equilibrate for scene in scenes]),
        "steps_sample": _span([scene.steps.sample for scene in scenes]),
        "scenes": value_digest([[p.name, sweep.planned_digest(p)] for p in sweep.points]),
        "runs": value_digest(runs) if runs else "none",
    }


def hours_of(path: Path, scene: Scene) -> float:
    """How long a run took; of one that was stopped and went on, all its steps at its last rate."""
    said = attributes(path)
    since_it_went_on = float(said["seconds"])
    if int(said["lost_step"]) >= 0:
        return since_it_went_on / 3600
    return max(since_it_went_on, scene.work / float(said["bead_steps_per_second"])) / 3600


def theory_record(paper: str, sweep: TheorySweep, results: Results) -> dict[str, Any]:
    """What the file of a sweep of theory says of itself, if it is there and not of other points."""
    path = Path(results.sweep(paper, sweep.name))
    said = attributes(path) if path.is_file() else {}
    whole = said.get("points") == sweep.digest
    return {
        "whole": whole,
        "calculation": sweep.calculation,
        "points": len(sweep.points),
        "sources": str(said["sources"]) if whole else "none",
        "arguments": sweep.digest,
    }


def asks_for(record: dict[str, Any]) -> str | None:
    """Digest of what a sweep asks for, from its record; None where that does not say it."""
    return record.get("scenes", record.get("arguments"))


def runs_made(record: dict[str, Any]) -> int:
    """How many runs of a sweep were made, from its record; a sweep of theory is one."""
    return int(record.get("runs_made", record["whole"]))


def _span(numbers):
    """A number, or the least and the largest."""
    low, high = int(min(numbers)), int(max(numbers))
    return low if low == high else [low, high]


def checksum(data: bytes) -> dict[str, Any]:
    """Size and sum of a file."""
    return {"bytes": len(data), "sha256": hashlib.sha256(data).hexdigest()}
