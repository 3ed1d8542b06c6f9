"""Configurations one after the other, in a file of their own."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from dpd.page import Change, Observable, Refusals

if TYPE_CHECKING:
    from collections.abc import Sequence
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

    Parameters
    ----------
    scene : Scene
    system : System
    every : int
        Steps between frames.
    species : list of str or None
        The species that are written; all if not given.
    velocities, equilibration : bool
        Whether frames have velocities; whether there are frames before sampling begins.
    path : path or None
        Of the file; without one, nothing is written.
    """

    stands = frozenset(Change)
    is_series, suffix = True, ".gsd"

    def __init__(
        self, scene: Scene, system: System, every: int, species: Sequence[str] | None = None,
        velocities: bool = True, equilibration: bool = False, path: Path | None = None,
    ) -> None:  # fmt: skip
        # Imported here: the library of GSD takes a tenth of a second, which other runs do without.
        from dpd.particles.trajectory_file import DIGEST, TrajectoryFile, bytes_of

        self.every, self.equilibration = every, equilibration
        self._scene, self._system, self._velocities = scene, system, velocities
        written = np.isin(scene.species, scene.species if species is None else species)
        self._written = written[scene.kinds]
        molecule = np.repeat(np.arange(len(scene.lengths)), scene.lengths)
        self._molecule = np.unique(molecule[self._written], return_inverse=True)[1]
        steps = sum(scene.steps) if equilibration else scene.steps.sample
        self.arrays: dict[str, np.ndarray] = {
            "taken": np.zeros(1, np.int64),
            "digests": np.zeros((steps // every, DIGEST), np.uint8),
        }
        self.file = None if path is None else TrajectoryFile(path)
        joined = len(scene.bonded), len(scene.angled)
        self.file_bytes = bytes_of(steps // every, self._written.sum(), *joined, velocities)

    @classmethod
    def refuses(cls, scene: Scene, settings: dict[str, Any]) -> Refusals:
        """Species that there are not."""
        for name in settings.get("species", ()):
            if name not in scene.species:
                allowed = ", ".join(scene.species)
                yield "species", f"there are no beads {name!r}; allowed: {allowed}"

    def sample(self, simulation: Simulation) -> None:
        """Append a frame."""
        from dpd.particles.gsd_files import frame_of
        from dpd.particles.particles import of_scene, only

        state, arrays = simulation.state, self.arrays
        if self.file is not None:
            position = state.by_identity(state.position)
            velocity = state.by_identity(state.velocity) if self._velocities else None
            box, image = simulation.box, state.image
            all_beads = of_scene(self._scene, box, position, image, velocity, state.step)
            frame = frame_of(only(all_beads, self._written), np.float32)
            frame.particles.body = self._molecule.astype(np.int32)
            dt, kT = self._system.dt, self._system.kT
            said = {"time": state.step * dt, "dt": dt, "kT": kT}
            frame.log = {name: np.array([value]) for name, value in said.items()}
            arrays["digests"][arrays["taken"][0]] = self.file.append(frame)
        arrays["taken"][0] += 1

    def variables(self) -> dict[str, Any]:
        """Nothing: the frames are in their own file."""
        return {}
