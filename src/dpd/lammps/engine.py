"""A system that LAMMPS moves, for the run loop, observables and checkpoints as they are.

It moves by velocity Verlet with friction at the velocity of half a step, which is gw-vv with lambda
1/2 (Groot and Warren 1997, Eq. 9):

    LAMMPS:  v_h = v + dt f / 2,  r += dt v_h,                f' = f(r, v_h),  v = v_h + dt f' / 2
    gw-vv:   r += dt v + dt^2 f / 2,  v~ = v + dt f / 2,      f' = f(r, v~),   v += dt (f + f') / 2

Its ranks advance to where something is looked at, and hand over positions and velocities. Energies
and the virial of conservative forces are then evaluated by our own kernels, which cost less than a
step of LAMMPS; the virial of all forces is its own, with the noise that moved the beads.
"""

from __future__ import annotations

import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np

from dpd.engine.simulation import Simulation
from dpd.engine.space import wrapped
from dpd.engine.state import ALL_FORCES, State, Sums, System
from dpd.errors import UserError
from dpd.lammps.input import SKIN, input_of
from dpd.lammps.ranks import Ranks
from dpd.scene.scene import Scene

VIRIAL = np.array([(0, 3, 4), (3, 1, 5), (4, 5, 2)])  # where xx, xy ... stand in its vector
# It is known where thermo prints, which is at the end of each run.
MEASURED = [
    "compute virial all pressure NULL virial", "thermo_style custom step c_virial[1]",
    "thermo 1000000000", "run 0",
]  # fmt: skip


class Lammps(Simulation):
    """A `Simulation` whose steps LAMMPS makes; threads are those of our own kernels."""

    def __init__(
        self, scene: Scene, system: System, state: State, ranks: int = 1, threads: int = 1,
        skin: float = SKIN,
    ) -> None:  # fmt: skip
        super().__init__(system, state, threads)
        self.ranks, self._scene, self._skin = Ranks(ranks), scene, skin
        self._from: State | None = None  # what it goes on from

    @property
    def called(self) -> str:
        """What it is, for results."""
        name = f"LAMMPS {self.ranks('version')}, {self.ranks.number} rank(s)"
        return f"{name}; a run that was resumed has the same averages, not the same bits"

    def sample_in_box(self, steps: int, at: np.ndarray, measure: bool) -> Sums:
        end, parts = self.state.step + steps, []
        for step in sorted({*at.tolist(), end}):
            self.go(step - self.state.step)
            parts.append(self.gather(step, [step] if step in at else [], measure))
        return Sums.joined(parts)

    def go(self, steps: int) -> None:
        """Let LAMMPS make steps: on from where it is, or from our state where that is another."""
        if self._from is not self.state:
            self._set_up()
            self._from = self.state
        try:
            self.ranks("command", f"run {steps} pre no post no")
        except UserError as problem:
            self._from = None
            raise UserError(f"{problem}; if beads got too fast, lower integrator.dt") from None

    def _set_up(self):
        with tempfile.TemporaryDirectory(prefix="dpd-lammps-") as folder:
            lines, files = input_of(self._scene, self.state, skin=self._skin)
            for name, text in files.items():
                Path(folder, name).write_text(text)
            self.ranks("commands_list", ["clear", f'shell cd "{folder}"', *lines, *MEASURED])

    def gather(self, step: int, samples: list[int], measure: bool) -> Sums:
        """Take over the beads of all ranks at a step, and sums there."""
        box = self.box
        position, velocity, image = (
            self.ranks("gather_atoms", name, kind, 3).reshape(-1, 3).T[: len(box)]
            for name, kind in (("x", 1), ("v", 1), ("image", 0))
        )
        position, further = wrapped(position, box)
        self.state = replace(
            self.state, position=position, velocity=velocity, force=None, reference=None,
            identity=np.arange(position.shape[1], dtype=np.uint32),
            species=None if self.state.species is None else self._scene.kinds,
            image=(image + further).astype(np.int32), step=step,
        )  # fmt: skip
        sums = self.call(0, samples, measure)
        self._from = self.state
        if measure and samples:
            d, pressure = len(box), self.ranks("numpy.extract_compute", "virial", 0, 1)
            sums.virial[:, ALL_FORCES] = self.volume * pressure[VIRIAL][:d, :d]
        return sums
