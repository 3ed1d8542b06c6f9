"""How long chains remember where they point."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from dpd.observe.common.multitau import MultipleTau
from dpd.page import Change, Observable, Refusals, interval_setting

if TYPE_CHECKING:
    from dpd.engine.simulation import Simulation
    from dpd.observe import BondedSystem, Variables
    from dpd.scene.molecules import Molecule
    from dpd.scene.scene import Scene


class EndToEnd(Observable, key="end_to_end"):
    """Autocorrelation of the end-to-end vector, <R(t) . R(0)> (Nikunen et al. 2007, Fig. 4b).

    By multiple-tau correlation (`dpd.observe.common.multitau`), for each linear molecule of two
    beads or more. Branched molecules have no such vector and are left out.
    """

    stands = frozenset(Change) - {Change.PACE}
    needs_bonds = True

    every: int = interval_setting("Steps between samples, the shortest time.")

    def _start(self, scene: Scene, system: BondedSystem) -> None:
        self._system = system
        chains = [kind for kind in scene.molecules if len(kind.beads) > 1 and kind.is_linear]
        self._members = _bonds_of(scene)
        self._sign = np.concatenate([np.tile(along_chain(kind), kind.count) for kind in chains])
        lengths = np.repeat([len(kind.beads) for kind in chains], [kind.count for kind in chains])
        self._bonds_first = np.cumsum(lengths - 1) - (lengths - 1)
        samples = scene.steps.sample // self.every
        self.averages = MultipleTau(samples, (system.dimension, len(lengths)), 1)
        self.arrays = self.averages.arrays | {"square": np.zeros(len(lengths))}

    def refuses(self, scene: Scene) -> Refusals:
        """No linear molecule."""
        if not any(len(kind.beads) > 1 and kind.is_linear for kind in scene.molecules):
            yield "", "'end_to_end' has nothing to measure: no molecule is linear"

    def sample(self, simulation: Simulation) -> None:
        """Take one sample."""
        from dpd.engine.space import nearest

        state, members = simulation.state, self._members
        position = state.by_identity(state.position)
        bonds = nearest(position[:, members[:, 1]] - position[:, members[:, 0]], simulation.box)
        vector = np.add.reduceat(self._sign * bonds, self._bonds_first, axis=1)
        self.arrays["square"] += (vector**2).sum(axis=0)
        self.averages.add(vector, product)

    def variables(self) -> Variables:
        """Correlations of each molecule, and sums in parts of the run, by increasing lag."""
        lag, means, counts, sums = self.averages.results()
        taken = max(1, int(self.arrays["taken"][0]))
        return {
            "end_lag_time": (("end_lag",), lag * self.every * self._system.dt, "tau", "time apart"),
            "end_correlation": (
                ("end_lag", "chain"), means[:, 0], "r_c^2", "<R(t) . R(0)> of each chain",
            ),
            "end_square": (
                ("chain",), self.arrays["square"] / taken, "r_c^2", "<R^2> of each chain",
            ),
            "end_samples": (
                ("part", "end_lag"), counts, "1", "pairs of samples ending in each part of the run",
            ),
            "end_sums": (
                ("part", "end_lag"), sums[..., 0], "r_c^2",
                "their products, mean over molecules, summed",
            ),
        }  # fmt: skip


def _bonds_of(scene):
    """(bonds, 2) array: the bonds of linear molecules alone."""
    linear = [np.full(k.count * (len(k.beads) - 1), k.is_linear) for k in scene.molecules]
    return scene.bonded[np.concatenate(linear)]


def along_chain(kind: Molecule) -> np.ndarray:
    """(bonds,) array: which way each bond of a linear molecule counts, from one end to the other.

    A bond goes from a bead to one with a higher number. It is 1 for those that do so on the way
    from the first end to the last, which are all if the beads are numbered along the molecule.
    """
    parents, sign, bead = kind.parents, np.ones(len(kind.beads) - 1), int(kind.ends[0])
    while bead > 0:
        sign[bead - 1] = -1
        bead = parents[bead]
    return sign


def product(now: np.ndarray, then: np.ndarray) -> np.ndarray:
    """Scalar products of vectors."""
    return (now * then).sum(axis=1)[:, None]
