"""Digests of values, and the folders that belong to the repository or can be had again."""

import hashlib
import json
import os
from pathlib import Path

PACKAGE = Path(__file__).resolve().parent


def _repository() -> Path:
    """The repository of these sources; of installed ones, the folder that is worked in."""
    own = PACKAGE.parent.parent
    if (own / "config" / "config.yaml").is_file():
        return own
    try:
        return Path.cwd()
    except OSError:  # it was removed
        return own


# It may be any folder: only papers and studies need the repository (`dpd.pipeline.study`).
ROOT = _repository()


def cache_folder(name: str) -> Path:
    """Folder for what can be had again: ``~/.cache/dpd-papers/<name>``, if not elsewhere."""
    try:
        home = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    except RuntimeError:  # a user without a home, as in some containers
        home = Path(os.environ.get("TMPDIR", "/tmp")) / f"cache-{os.getuid()}"
    return Path(home) / "dpd-papers" / name


def value_digest(value: object) -> str:
    """Digest of a value made of plain dicts, lists, strings and numbers."""
    return text_digest(json.dumps(value, sort_keys=True))


def text_digest(text: str) -> str:
    """Twelve hexadecimal digits that differ where texts differ."""
    return hashlib.sha256(text.encode()).hexdigest()[:12]
