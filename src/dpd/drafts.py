"""Files that are no use to anybody once their process has ended: drafts, and locks."""

from __future__ import annotations

import os
import re
import threading
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

TEMPORARY: set[Path] = set()  # paths of this process's


@contextmanager
def draft_of(path: Path) -> Iterator[Path]:
    """A name beside a file for what is to take its place; removed in the end if still there.

    It is this thread's own, so that two that write the same file do not spoil each other's, and
    made anew: what is written does not follow a link that somebody has put there.
    """
    draft = path.with_name(f"{path.name}.{threading.get_native_id()}.writing")
    TEMPORARY.add(draft)
    try:
        draft.unlink(missing_ok=True)  # of a process of that number, which was killed
        os.close(os.open(draft, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o666))
        yield draft
    finally:
        with suppress(OSError):
            draft.unlink(missing_ok=True)
        TEMPORARY.discard(draft)


def remove_drafts(path: Path) -> None:
    """Remove what processes left that were killed while they wrote a file.

    For the one process that is at work on that file, see `dpd.pipeline.lock`.
    """
    left = re.compile(re.escape(path.name) + r"\.\d+\.writing")
    with suppress(OSError):
        for other in path.parent.iterdir():
            if left.fullmatch(other.name):
                other.unlink(missing_ok=True)


def remove_temporary() -> None:
    """Remove the drafts and locks of this process, which is about to end."""
    for path in list(TEMPORARY):
        with suppress(OSError):
            os.unlink(path)


def unfinished(path: Path) -> Path:
    """Where a file grows beside its place, with a suffix by which programs know it."""
    return path.with_name(f"{path.stem}.unfinished{path.suffix}")
