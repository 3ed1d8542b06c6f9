"""What a study makes before its runs: kernels, and first configurations that runs share."""

from __future__ import annotations

from typing import TYPE_CHECKING

from dpd.scene.start import start_digest, start_is_shared
from dpd.stages import kernels_name, start_terms, terms_of

if TYPE_CHECKING:
    from dpd.pipeline.study import Paper
    from dpd.pipeline.sweep import Point


def waiting_for_starts(paper: Paper) -> dict[str, list[tuple[str, Point]]]:
    """Digest of each start to the (name of a sweep, point) pairs that need it, in order."""
    waiting: dict[str, list[tuple[str, Point]]] = {}
    for sweep in paper.sweeps.values():
        for point in sweep.points:
            if start_is_shared(point.scene):
                waiting.setdefault(start_digest(point.scene), []).append((sweep.name, point))
    return waiting


def kernels_for(paper: Paper) -> dict[str, frozenset[str]]:
    """Digest of kernels to the terms of the physics that they are for."""
    scenes = [point.scene for sweep in paper.sweeps.values() for point in sweep.points]
    terms = {terms_of(scene) for scene in scenes}
    terms |= {start_terms(scene) for scene in scenes if start_is_shared(scene)}
    return {kernels_name(each): each for each in terms}
