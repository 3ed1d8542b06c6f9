"""Digests: of the sources of each stage, and of the parameters of a run.

Snakemake compares rules, not the code that they call. A digest of the sources in a
rule's ``params`` makes an edited kernel rerun simulations and an edited plot rerun
plots only.
"""

import hashlib
import json
import os
from functools import cache
from pathlib import Path

PACKAGE = Path(__file__).resolve().parent
ROOT = PACKAGE.parent.parent

_ENGINE = ("jit.py", "numba_settings.py", "physics", "engine")
_START = ("errors.py", "files.py", "scene/scene.py", *_ENGINE, "start")
_SIMULATION = (*_START, "pipeline/simulate.py", "observe")
_STAGES = {
    "engine": _ENGINE,
    "start": _START,
    "simulate": _SIMULATION,
    "collect": ("analysis/collect.py", "analysis/statistics.py", "files.py"),
    "derive": ("analysis/derive.py", "analysis/structure.py", "pipeline/derived.py"),
    "figure": (
        "analysis",
        "theory",
        "report/style.py",
        "report/text.py",
        "report/figure_file.py",
        "report/figures.py",
        "report/captions.py",
        "report/notation.py",
    ),
    "report": ("report", "analysis/verdicts.py"),
    "measure": (*_SIMULATION, "benchmark"),
}


def cache_folder(name):
    """Folder for what can be had again: ``~/.cache/dpd-papers/<name>``, if not elsewhere."""
    try:
        home = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    except RuntimeError:  # a user without a home, as in some containers
        home = Path(os.environ.get("TMPDIR", "/tmp")) / f"cache-{os.getuid()}"
    return Path(home) / "dpd-papers" / name


@cache
def stage_digest(stage):
    """Digest of the sources that decide what a stage computes.

    Parameters
    ----------
    stage : str
        One of ``engine``, ``start``, ``simulate``, ``collect``, ``derive``, ``figure``,
        ``report``, ``measure``.

    Returns
    -------
    str
        Twelve hexadecimal digits.
    """
    return files_digest(*(PACKAGE / name for name in _STAGES[stage]))


def files_digest(*paths):
    """Digest of the contents of files and, for folders, of the sources below them."""
    total = hashlib.sha256()
    for path in paths:
        sources = sorted(path.rglob("*")) if path.is_dir() else [path]
        for source in sources:
            if source.suffix in {".py", ".html", ".css", ".yaml", ".txt"}:
                total.update(source.name.encode())
                total.update(source.read_bytes())
    return total.hexdigest()[:12]


def value_digest(value):
    """Digest of a value made of plain dicts, lists, strings and numbers."""
    return hashlib.sha256(json.dumps(value, sort_keys=True).encode()).hexdigest()[:12]
