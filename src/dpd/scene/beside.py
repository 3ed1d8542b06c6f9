"""Files that a run writes beside its result, because its scene asks for them."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from dpd.scene.scene import Scene


def files_beside(scene: Scene, path: str | Path) -> dict[str, Path]:
    """The file of each observable that has one.

    Parameters
    ----------
    scene : Scene
    path : path
        Of the result: ``run.nc`` makes ``run.gsd``.

    Returns
    -------
    dict of str to Path
        By the name of the observable.
    """
    suffixes = {name: page.suffix for name, page in scene.observe.items()}
    return {name: Path(path).with_suffix(suffix) for name, suffix in suffixes.items() if suffix}


def unfinished(path: Path) -> Path:
    """Where such a file grows: beside its place, with a suffix by which programs know it."""
    return path.with_name(f"{path.stem}.unfinished{path.suffix}")
