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

from dpd.engine.simulation import CUTOFF, Simulation
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
LARGEST = 512  # boxes of an image flag
TOO_FAST = "Lost atoms", "Non-numeric", "atoms missing", "atom missing"
NOTHING = Sums(np.zeros(0, np.int64), np.zeros(0), np.zeros((0, 0)), np.zeros((0, 0, 0, 0)))


class Lammps(Simulation):
    """A `Simulation` whose steps LAMMPS makes; threads are those of our own kernels."""

    def __init__(
        self, scene: Scene, system: System, state: State, ranks: int = 1, threads: int = 1,
        skin: float = SKIN,
    ) -> None:  # fmt: skip
        super().__init__(system, state, threads)
        self.ranks, self.shares, self._scene, self._skin = Ranks(ranks), ranks, scene, skin
        self.called = f"LAMMPS {self.ranks('version')}, {ranks} rank(s)"
        self._from: State | None = None  # what it goes on from

    def close(self) -> None:
        self.ranks.close()

    def sample_in_box(self, steps: int, at: np.ndarray, measure: bool) -> Sums:
        end, parts = self.state.step + steps, []
        for step in sorted({*at.tolist(), end}):
            self.go(step - self.state.step)
            self.gather(step)
            if step in at:  # sums of our own kernels, with the virial that moved the beads
                sums, d = self.call(0, [step], measure), self.system.dimension
                self._from = self.state
                if measure:
                    pressure = self.ranks("numpy.extract_compute", "virial", 0, 1)
                    sums.virial[:, ALL_FORCES] = self.volume * pressure[VIRIAL][:d, :d]
                parts.append(sums)
        return Sums.joined(parts) if parts else NOTHING

    def go(self, steps: int) -> None:
        """Let LAMMPS make steps: on from where it is, or from our state where that is another."""
        if self._from is not self.state:
            with tempfile.TemporaryDirectory(prefix="dpd-lammps-") as folder:
                lines, files = input_of(self._scene, self.state, skin=self._skin)
                for name, text in files.items():
                    Path(folder, name).write_text(text)
                self.ranks("commands_list", ["clear", f'shell cd "{folder}"', *lines, *MEASURED])
            self._from, self._boxes = self.state, self._gathered("image")
            self._image = self.state.image
        try:
            self.ranks("command", f"run {steps} pre no post no")
        except UserError as problem:
            self._from, text = None, str(problem)
            hint = "; lower integrator.dt" if any(word in text for word in TOO_FAST) else ""
            raise UserError(f"{text}{hint}") from None

    def _gathered(self, name):
        kind = 0 if name == "image" else 1  # whole numbers, or not
        found = self.ranks("gather_atoms", name, kind, 3).reshape(-1, 3)
        return found.T[: self.system.dimension]

    def gather(self, step: int) -> None:
        """Take over the beads of all ranks at a step."""
        boxes, velocity = self._gathered("image"), self._gathered("v")
        fastest = np.abs(velocity).max() * self.system.dt
        if not fastest < CUTOFF:
            raise UserError(
                f"the run blew up: at step {step} a bead moves {fastest:.3g} r_c along an axis in "
                "one step (limit: 1 r_c); lower integrator.dt, or the repulsion or bond stiffness "
                "that asks for it"
            )
        # It counts boxes up to 512, and then from -512 on.
        self._image = self._image + (boxes - self._boxes + LARGEST) % (2 * LARGEST) - LARGEST
        position, further = wrapped(self._gathered("x"), self.box)
        self._boxes = boxes
        self.state = self._from = replace(
            self.state, position=position, velocity=velocity, force=None, reference=None,
            identity=np.arange(position.shape[1], dtype=np.uint32),
            species=None if self.state.species is None else self._scene.kinds,
            image=(self._image + further).astype(np.int32), step=step,
        )  # fmt: skip
