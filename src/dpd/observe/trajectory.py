"""Configurations one after the other, in a file of their own."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from dpd.engine.slide import TiltedBox
from dpd.engine.space import along_axes
from dpd.observe.following import edges_between, flow_at, in_box_of, moved_between
from dpd.particles.tilt import box_at

if TYPE_CHECKING:
    from pathlib import Path

    from dpd.engine.simulation import Simulation
    from dpd.engine.state import Sums, System
    from dpd.scene.scene import Scene


class Trajectory:
    """Positions, images and velocities of all beads, appended to ``run.gsd`` in single precision.

    Images are counted from the first frame on: position plus image times edge goes on where a bead
    leaves the box.

    Parameters
    ----------
    scene : Scene
    system : System
    every : int
        Steps between frames.
    path : path or None
        Of the file; without one, nothing is written.
    """

    needs_forces = False

    def __init__(self, scene: Scene, system: System, every: int, path: Path | None = None) -> None:
        # Imported here: the library of GSD takes a tenth of a second, which other runs do without.
        from dpd.particles.trajectory_file import DIGEST, TrajectoryFile, bytes_of

        self.every = every
        self._scene = scene
        shape = (system.dimension, scene.beads)
        self.arrays: dict[str, np.ndarray] = {
            "taken": np.zeros(1, np.int64),
            "last": np.zeros(shape),
            "image": np.zeros(shape, np.int32),
            "digest": np.zeros(DIGEST, np.uint8),
        }
        self.file = None if path is None else TrajectoryFile(path)
        joined = len(scene.bonded), len(scene.angled)
        self.file_bytes = bytes_of(scene.steps.sample // every, scene.beads, *joined)

    def sample(self, simulation: Simulation, sums: Sums) -> None:
        """Append a frame."""
        from dpd.particles.particles import Particles

        state, arrays, scene = simulation.state, self.arrays, self._scene
        position = state.by_identity(state.position)
        followed = in_box_of(position, simulation.box, simulation.first_box)
        if arrays["taken"][0]:
            self._follow(followed, simulation)
        if self.file is not None:
            frame = Particles(
                box=simulation.box,
                position=position,
                image=arrays["image"],
                velocity=state.by_identity(state.velocity),
                species=scene.kinds,
                names=scene.species,
                bonds=scene.bonded,
                angles=scene.angled,
                step=state.step,
                masses=scene.masses,
            )
            arrays["digest"][...] = self.file.append(frame, arrays["digest"])
        arrays["last"][...] = followed
        arrays["taken"][0] += 1

    def _follow(self, position, simulation):
        """Count the faces that beads have gone through since the last frame."""
        arrays, box, step = self.arrays, simulation.first_box, simulation.state.step
        time = self.every * simulation.system.dt
        self._slide_images(simulation, box, time)
        begun = arrays["last"] + time * flow_at(arrays["last"], box)
        moved = moved_between(begun, position, box, step, "trajectory", self.every)
        further = along_axes(begun + moved - position, box) / np.array(box)[:, None]
        arrays["image"] += np.rint(further).astype(np.int32)

    def _slide_images(self, simulation, box, time):
        """Count the whole edges that images have slid by since the last frame."""
        if isinstance(box, TiltedBox):
            state = simulation.state
            former = box_at(self._scene, state.step - self.every, state.slid)
            edges = edges_between(former, box, time)
            self.arrays["image"][box.slide.flow] += edges * self.arrays["image"][box.slide.gradient]

    def variables(self) -> dict[str, Any]:
        """Nothing: the frames are in their own file."""
        return {}
