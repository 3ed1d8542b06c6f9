from dataclasses import replace
from math import log10
from pathlib import Path
from typing import Any

import numpy as np

from dpd.page import Change, Observable, once, setting


class Trajectory(Observable, key="trajectory"):
    """Positions, images and velocities of beads, appended to ``run.gsd`` in single precision.

    Position plus image times the vectors of the box has every molecule in one piece. Each frame
    holds ``log/time``, in tau since the run began, ``log/dt`` and ``log/kT``, and the number of the
    molecule of each bead as its body, which MDAnalysis takes for that of its residue.

    With ``forces`` it holds, under ``log/particles/`` as HOOMD names them, the conservative
    ``forces`` on each bead but a body force, in kT / r_c, its ``energies`` and its ``virials`` xx,
    xy, xz, yy, yz, zz in kT: half of what acts between two beads, or along a bond of an angle. The
    sum of virials and m v v in a volume, over it, is the pressure tensor there.
    """

    stands = frozenset(Change)
    cost = 10.0
    suffix = ".gsd"

    species: list[str] | None = setting(
        "Names of the species that are written, as [H, T], with the bonds among them; if not "
        "given, all.", None, of="some species", min_length=1,
    )  # fmt: skip
    velocities: bool = setting("Whether frames have velocities.", True)
    forces: bool = setting("Whether frames have forces, energies and virials of beads.", False)
    per_decade: int | None = setting(
        "Frames of some samples alone, so many in each decade of time, evenly on its logarithm.",
        None, ge=1, le=1000,
    )  # fmt: skip
    equilibration: bool = setting(
        "Whether there are frames from the beginning of the run on, and not only where it samples.",
        False,
    )

    def watched(self, scene: Any) -> int:
        return sum(scene.steps) if self.equilibration else int(scene.steps.sample)

    def opened(self, path: Path) -> Any:
        from dpd.particles.gsd_files import TrajectoryFile

        return TrajectoryFile(path)

    def keeps(self, scene: Any) -> Any:
        digests = np.zeros(self.watched(scene) // self.every, np.int64)
        return {"frames": np.zeros(1, np.int64), "digests": digests}

    @once
    def written(self, scene: Any) -> tuple[np.ndarray, np.ndarray]:
        """(beads,) bool array: which beads are; the number of the molecule of each of those."""
        written = np.isin(scene.species, self.species or scene.species)[scene.kinds]
        molecule = np.repeat(np.arange(len(scene.lengths)), scene.lengths)[written]
        return written, np.unique(molecule, return_inverse=True)[1].astype(np.int32)

    def measure(self, now: Any) -> Any:
        from dpd.particles.gsd_files import frame_of
        from dpd.particles.particles import of_scene

        n, number = self.per_decade, now.sample + 1
        if now.file is None or (n and number != round(10 ** (round(n * log10(number)) / n))):
            return {}
        scene, state = now.scene, now.state
        velocity = state.by_identity(state.velocity) if self.velocities else None
        beads = of_scene(scene, now.lattice, now.coordinates, state.image, velocity, state.step)
        written, molecule = self.written(scene)
        frame = frame_of(beads.only(written), np.float32)
        frame.particles.body = molecule
        said = {"time": now.time, "dt": now.system.dt, "kT": now.system.kT}
        frame.log = {name: np.array([value]) for name, value in said.items()}
        if self.forces:
            from dpd.engine.stress import at_beads

            found = at_beads(replace(now.system, box=now.lattice), state)
            more = 0, 3 - now.dimension
            virials = np.pad(found.virial, ((0, 0), more, more))[:, *np.triu_indices(3)]
            named = np.pad(found.force, ((0, 0), more)), found.energy, virials
            for name, each in zip(("forces", "energies", "virials"), named):
                frame.log[f"particles/{name}"] = each[written].astype(np.float32)
        frames = now.kept["frames"]
        now.kept["digests"][frames[0]] = now.file.append(frame)
        frames += 1
        return {}
