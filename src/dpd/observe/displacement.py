"""Mean-square displacements by multiple-tau correlation."""

import numpy as np

from dpd.errors import UserError

KEPT = 16  # positions kept at each level, and so the lags of the first
COARSER = 4  # steps of a level in those of the level below
PARTS = 10  # of the run, for errors that know about motion which all molecules share
FARTHEST = 1 / 3  # of an edge that a bead may move between samples and still be followed


class Displacement:
    """Mean-square displacement of innermost beads and of centres of mass.

    A level holds the last `KEPT` positions, each level at steps `COARSER` times as long, and
    adds up squared differences: every lag is exact, none is averaged over positions
    (Frenkel and Smit, Understanding Molecular Simulation, Sec. 4.4.2). Positions are
    unwrapped from sample to sample and taken relative to the centre of mass of all beads,
    so a drift of the box does not count. "Innermost" is the middle bead of a molecule, two
    of them for an even number.

    Parameters
    ----------
    scene : Scene
    system : System
    every : int
        Steps between samples: the shortest lag.
    """

    needs_forces = False

    def __init__(self, scene, system, every):
        self.every = every
        self._system = system
        lengths = np.repeat(
            [len(kind.beads) for kind in scene.molecules], [kind.count for kind in scene.molecules]
        )
        self._first = np.cumsum(lengths) - lengths
        self._lengths = lengths
        self._samples = scene.steps[1] // every
        self._inner = np.stack([self._first + (lengths - 1) // 2, self._first + lengths // 2])
        levels = 1  # up to the lag of one part of the run; beyond, no error is to be had
        while KEPT * COARSER ** (levels - 1) < self._samples / PARTS:
            levels += 1
        d, molecules = system.dimension, len(lengths)
        self.arrays = {
            "taken": np.zeros(1, np.int64),
            "last": np.zeros((d, scene.beads)),
            "moved": np.zeros((d, scene.beads)),
            "kept": np.zeros((levels, KEPT, d, 3, molecules)),
            "sums": np.zeros((levels, KEPT, 2, molecules)),
            "part_sums": np.zeros((PARTS, levels, KEPT, 2)),
            "part_counts": np.zeros((PARTS, levels, KEPT), np.int64),
        }

    def sample(self, simulation, sums):
        """Take one sample."""
        tracked = self._tracked(simulation.state)
        taken = int(self.arrays["taken"][0])
        for level in range(len(self.arrays["kept"])):
            if taken % COARSER**level:
                break
            self._correlate(level, taken // COARSER**level, tracked)
        self.arrays["taken"][0] += 1

    def _tracked(self, state):
        """(dimension, 3, molecules): two innermost beads and the centre of mass, unwrapped."""
        arrays, box = self.arrays, np.array(self._system.box)[:, None]
        position = state.by_identity(state.position)
        if arrays["taken"][0]:
            step = position - arrays["last"]
            step -= box * np.rint(step / box)
            if np.abs(step / box).max() > FARTHEST:
                raise UserError(
                    "observe.displacement.every: a bead moved more than a third of the box between "
                    f"samples {self.every} steps apart; sample more often"
                )
            arrays["moved"] += step
        arrays["last"][...] = position
        moved = arrays["moved"] - arrays["moved"].mean(axis=1, keepdims=True)
        centre = np.add.reduceat(moved, self._first, axis=1) / self._lengths
        return np.concatenate([moved[:, self._inner], centre[:, None]], axis=1)

    def _correlate(self, level, number, tracked):
        """Add the differences to the positions that a level holds, then hold this one."""
        arrays = self.arrays
        kept = arrays["kept"][level]
        part = int(arrays["taken"][0]) * PARTS // self._samples
        for lag in range(1 if level == 0 else KEPT // COARSER + 1, min(number, KEPT) + 1):
            apart = tracked - kept[(number - lag) % KEPT]
            squares = (apart**2).sum(axis=0)
            found = np.stack([0.5 * (squares[0] + squares[1]), squares[2]])
            arrays["sums"][level, lag - 1] += found
            arrays["part_sums"][part, level, lag - 1] += found.mean(axis=1)
            arrays["part_counts"][part, level, lag - 1] += 1
        kept[number % KEPT] = tracked

    def variables(self):
        """Displacements of each molecule, and sums in parts of the run, by increasing lag."""
        part_counts = self.arrays["part_counts"].reshape(PARTS, -1)
        part_sums = self.arrays["part_sums"].reshape(PARTS, -1, 2)
        counts = part_counts.sum(axis=0)
        seen = counts > 0
        levels = len(self.arrays["kept"])
        lag = np.arange(1, KEPT + 1) * COARSER ** np.arange(levels)[:, None]
        sums = self.arrays["sums"].reshape(len(counts), 2, -1)[seen]
        means = sums / counts[seen, None, None]
        along = ("lag", "molecule")
        return {
            "lag_time": (
                ("lag",), lag.ravel()[seen] * self.every * self._system.dt, "tau", "time apart",
            ),
            "msd_inner": (along, means[:, 0], "r_c^2", "displacement of innermost beads, squared"),
            "msd_centre": (along, means[:, 1], "r_c^2", "displacement of centres of mass, squared"),
            "lag_samples": (
                ("part", "lag"), part_counts[:, seen].astype(float), "1",
                "pairs of samples that end in each part of the run",
            ),
            "msd_inner_sums": (
                ("part", "lag"), part_sums[:, seen, 0], "r_c^2",
                "their squared displacements of innermost beads, mean over molecules, summed",
            ),
            "msd_centre_sums": (
                ("part", "lag"), part_sums[:, seen, 1], "r_c^2",
                "their squared displacements of centres of mass, mean over molecules, summed",
            ),
        }  # fmt: skip
