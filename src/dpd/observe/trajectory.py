"""Configurations one after the other, in a file of their own."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from dpd.page import Change, Observable, Refusals, interval_setting, setting

if TYPE_CHECKING:
    from pathlib import Path

    from dpd.engine.simulation import Simulation
    from dpd.engine.state import System
    from dpd.scene.scene import Scene


class Trajectory(Observable, key="trajectory"):
    """Positions, images and velocities of beads, appended to ``run.gsd`` in single precision.

    Position plus image times the vectors of the box goes on where a bead leaves the box, and has
    every molecule in one piece. Each frame holds the time in tau since the run began, dt and the kT
    of the thermostat as ``log/time``, ``log/dt`` and ``log/kT``, and the number of the molecule of
    each bead as its body, which MDAnalysis takes for that of its residue.
    """

    stands = frozenset(Change)
    is_series, suffix = True, ".gsd"

    every: int = interval_setting("Steps between frames.")
    species: list[str] | None = setting(
        "Names of the species that are written, as [H, T], with the bonds among them; if not "
        "given, all.",
        None,
        of="some species",
        min_length=1,
    )
    velocities: bool = setting("Whether frames have velocities.", True)
    equilibration: bool = setting(
        "Whether there are frames from the beginning of the run on, and not only where it samples.",
        False,
    )

    def _start(self, scene: Scene, system: System, path: Path | None = None) -> None:
        # Imported here: the library of GSD takes a tenth of a second, which other runs do without.
        from dpd.particles.trajectory_file import DIGEST, TrajectoryFile, bytes_of

        self._scene = scene
        written = np.isin(scene.species, scene.species if self.species is None else self.species)
        self._written = written[scene.kinds]
        molecule = np.repeat(np.arange(len(scene.lengths)), scene.lengths)
        self._molecule = np.unique(molecule[self._written], return_inverse=True)[1]
        steps = self.watched(scene)
        self.arrays: dict[str, np.ndarray] = {
            "taken": np.zeros(1, np.int64),
            "digests": np.zeros((steps // self.every, DIGEST), np.uint8),
        }
        self.file = None if path is None else TrajectoryFile(path)
        joined = len(scene.bonded), len(scene.angled)
        self.file_bytes = bytes_of(
            steps // self.every, self._written.sum(), *joined, self.velocities
        )

    def conflicts(self) -> Refusals:
        """A species that is there twice."""
        if self.species and len(set(self.species)) < len(self.species):
            yield "species", "names a species twice; keep one"

    def watched(self, scene: Scene) -> int:
        """All steps, if it looks at the equilibration as well."""
        return sum(scene.steps) if self.equilibration else int(scene.steps.sample)

    def sample(self, simulation: Simulation) -> None:
        """Append a frame."""
        from dpd.particles.gsd_files import frame_of
        from dpd.particles.particles import of_scene, only

        state, arrays = simulation.state, self.arrays
        if self.file is not None:
            position = state.by_identity(state.position)
            velocity = state.by_identity(state.velocity) if self.velocities else None
            box, image = simulation.box, state.image
            all_beads = of_scene(self._scene, box, position, image, velocity, state.step)
            frame = frame_of(only(all_beads, self._written), np.float32)
            frame.particles.body = self._molecule.astype(np.int32)
            dt, kT = simulation.system.dt, simulation.system.kT
            said = {"time": self._scene.tau(state.step), "dt": dt, "kT": kT}
            frame.log = {name: np.array([value]) for name, value in said.items()}
            arrays["digests"][arrays["taken"][0]] = self.file.append(frame)
        arrays["taken"][0] += 1

    def variables(self) -> dict[str, Any]:
        """Nothing: the frames are in their own file."""
        return {}
