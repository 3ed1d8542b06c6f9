"""The folders of the repository, of papers, and of what can be had again."""

import os
from contextlib import suppress
from pathlib import Path

PACKAGE = Path(__file__).resolve().parent
# The repository of these sources; of installed ones, the folder that is worked in. It may be any:
# only papers and studies need the repository (`dpd.pipeline.paper`).
ROOT = PACKAGE.parent.parent
if not (ROOT / "config" / "config.yaml").is_file():
    with suppress(OSError):  # it was removed
        ROOT = Path.cwd()
# A folder of papers outside of the repository, each NAME.yaml with a folder NAME of its figures.
_GIVEN = os.environ.get("DPD_PAPERS_DIR")
PAPERS_DIR = Path(_GIVEN).absolute() if _GIVEN else None


def paper_folder(paper: str) -> Path:
    """Where figures, calculations and published numbers of a paper stand."""
    if PAPERS_DIR is not None and (PAPERS_DIR / f"{paper}.yaml").is_file():
        return PAPERS_DIR / paper
    return ROOT / "paper_figures" / paper


def shortened(path: str | Path) -> str:
    """A path as messages have it: below the repository without the way there."""
    path = Path(path)
    return str(path.relative_to(ROOT) if path.is_relative_to(ROOT) else path)


def cache_folder(name: str) -> Path:
    """Folder for what can be had again: ``~/.cache/dpd-papers/<name>``, if not elsewhere."""
    try:
        home = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    except RuntimeError:  # a user without a home, as in some containers
        home = Path(os.environ.get("TMPDIR", "/tmp")) / f"cache-{os.getuid()}"
    return Path(home) / "dpd-papers" / name
