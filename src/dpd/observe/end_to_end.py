"""How long chains remember where they point."""

from typing import Any

import numpy as np

from dpd.page import Change, Observable, Refusals, once


class EndToEnd(Observable, key="end_to_end"):
    """Autocorrelation of the end-to-end vector, <R(t) . R(0)> (Nikunen et al. 2007, Fig. 4b).

    By multiple-tau correlation, for each linear molecule of two beads or more. Branched molecules
    have no such vector and are left out.
    """

    stands = frozenset(Change) - {Change.PACE}
    needs_bonds = True
    compared = "axis", "chain"
    over = {"lag": ("end_lag", "end_lag_time")}
    gives = {
        "end_correlation": (("lag", "chain"), "r_c^2", "<R(t) . R(0)> of each chain"),
        "end_square": (("run", "chain"), "r_c^2", "<R^2> of each chain"),
        "end_samples": (("part", "lag"), "1", "pairs of samples ending in each part of the run"),
        "end_sums": (("part", "lag"), "r_c^2", "their products, mean over molecules, summed"),
    }

    def refuses(self, scene: Any) -> Refusals:
        if not _chains(scene):
            yield "", "'end_to_end' has nothing to measure: no molecule is linear"

    def axes(self, scene: Any) -> Any:
        return {"chain": sum(kind.count for kind in _chains(scene))}

    @once
    def bonds(self, scene: Any) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Of linear molecules: which bonds, which way each counts, the first of each molecule."""
        linear = [np.full(k.count * (len(k.beads) - 1), k.is_linear) for k in scene.molecules]
        ways = [np.tile(along_chain(kind), kind.count) for kind in _chains(scene)]
        bonds = np.concatenate([[len(kind.beads) - 1] * kind.count for kind in _chains(scene)])
        first = np.cumsum(bonds) - bonds
        return np.flatnonzero(np.concatenate(linear)), np.concatenate(ways), first

    def measure(self, now: Any) -> Any:
        bonds, way, first = self.bonds(now.scene)
        vector = np.add.reduceat(way * now.bond_vectors.T[:, bonds], first, axis=1)
        return {"compared": vector, "end_square": (vector**2).sum(axis=0)}

    def compare(self, now: np.ndarray, then: np.ndarray) -> np.ndarray:
        return (now * then).sum(axis=1)[:, None]


def _chains(scene):
    """Kinds of molecules that have two ends."""
    return [kind for kind in scene.molecules if len(kind.beads) > 1 and kind.is_linear]


def along_chain(kind: Any) -> np.ndarray:
    """(bonds,) array: 1 for bonds from a bead to one further from the first end, -1 for others."""
    parents, sign, bead = kind.parents, np.ones(len(kind.beads) - 1), int(kind.ends[0])
    while bead > 0:
        sign[bead - 1] = -1
        bead = parents[bead]
    return sign
