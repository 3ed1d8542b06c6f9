"""Density of each species on a grid, over time."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from dpd.page import Change, Observable, Refusals, interval_setting, setting

if TYPE_CHECKING:
    from dpd.engine.simulation import Simulation
    from dpd.engine.state import System
    from dpd.observe import Variables
    from dpd.scene.scene import Scene

AXES = "xyz"
# Numbers over time, of 4 bytes. With copies for checkpoint and result they fit into the memory that
# a cluster is asked for, `dpd.pipeline.resources`.
MOST_CELLS = 5 * 10**7


def grid_shape(box: tuple[float, ...], spacing: float) -> tuple[int, ...]:
    """Cells along each axis: equal ones, not wider than ``spacing``."""
    return tuple(math.ceil(edge / spacing - 1e-9) for edge in box)


def frames_of(scene: Scene) -> int:
    """Frames of ``density_field``; the last one may have fewer looks than the others."""
    page = scene.observe["density_field"]
    return -(-(scene.steps.sample // page.every) // page.average)


class DensityField(Observable, key="density_field"):
    """Number density of each species in the cells of a grid, in frames one after the other.

    The density of a cell is the number of beads in it over its volume. A frame is the average of
    ``average`` looks, ``every`` steps apart; so it covers ``every`` times ``average`` steps, and
    the next one follows at once. Where the run ends within a frame, that is the average of the
    looks that it has.
    """

    stands = frozenset(Change) - {Change.SLIDES}

    every: int = interval_setting("Steps between looks.")
    average: int = setting(
        "Looks in a frame, which covers every times average steps; the next one follows at once.",
        10,
        ge=1,
        le=1000000000,
    )
    spacing: float = setting(
        "Largest width of a cell, at most half the smallest edge.", 0.5, unit="r_c", ge=0.01
    )

    def _start(self, scene: Scene, system: System) -> None:
        self._system = system
        self._names = scene.species
        self._looks = scene.steps.sample // self.every
        self._shape = (len(scene.species), *grid_shape(system.extent, self.spacing))
        self.arrays: dict[str, np.ndarray] = {
            "taken": np.zeros(1, np.int64),
            "field": np.zeros((frames_of(scene), *self._shape), np.float32),
            "box": np.zeros((frames_of(scene), system.dimension)),
        }

    def refuses(self, scene: Scene) -> Refusals:
        """Cells that are too wide, or too many for all frames."""
        spacing, smallest = self.spacing, min(scene.box)
        if spacing > smallest / 2:
            yield (
                "spacing",
                f"{spacing:g} makes fewer than two cells along an edge of {smallest:g}; allowed: "
                f"<= {smallest / 2:g}",
            )
        cells = math.prod(grid_shape(scene.box, spacing)) * len(scene.species)
        frames = frames_of(scene)
        if frames * cells > MOST_CELLS:
            yield (
                "every",
                f"{frames} frames of {cells} cells (all species together) make "
                f"{frames * cells:.3g} numbers; allowed: <= {MOST_CELLS}. Take a larger every, "
                "average or spacing",
            )

    def sample(self, simulation: Simulation) -> None:
        """Add a look to its frame."""
        state, shape = simulation.state, self._shape
        box = self._system.extent if self._system.walls is not None else simulation.box
        position = state.position - np.array(self._system.origin)[:, None]
        cell = np.zeros(state.position.shape[1], np.int64)
        if state.species is not None:
            cell += state.species
        for along, edge, cells in zip(position, box, shape[1:]):
            cell = cell * cells + np.clip((along * (cells / edge)).astype(np.int64), 0, cells - 1)
        counts = np.bincount(cell, minlength=np.prod(shape)).reshape(shape)
        density = counts * (np.prod(shape[1:]) / np.prod(box))
        frame = int(self.arrays["taken"][0]) // self.average
        self.arrays["field"][frame] += density.astype(np.float32)
        self.arrays["box"][frame] += box
        self.arrays["taken"][0] += 1

    def variables(self) -> Variables:
        """Fields for the file; NaN where a run that was lost did not come to."""
        frames = len(self.arrays["field"])
        looks = self._looks_in_frames(int(self.arrays["taken"][0])).astype(np.float32)
        with np.errstate(invalid="ignore"):
            field = self.arrays["field"] / looks.reshape(-1, *[1] * len(self._shape))
            box = self.arrays["box"] / looks[:, None]
        first = 1 + self.average * np.arange(frames)
        middle = first + 0.5 * (self._looks_in_frames(self._looks) - 1)
        axes = [f"field_{axis}" for axis in AXES[: self._system.dimension]]
        middles = {
            name: (
                (name,), (np.arange(cells) + 0.5) * (edge / cells), "r_c",
                f"middles of the cells along {name[-1]}",
            )
            for name, cells, edge in zip(axes, self._shape[1:], self._system.extent)
        }  # fmt: skip
        return middles | {
            "field_time": (
                ("frame",), self.times(middle), "tau",
                "time since the end of equilibration, mean of the looks of a frame",
            ),
            "field_box": (("frame", "axis"), box, "r_c", "edges of the box, mean of a frame"),
            "species": (("species",), np.array(self._names), "1", "species"),
            "density_field": (
                ("frame", "species", *axes), field, "1 / r_c^dimension",
                "number density in cells, mean over the looks of a frame",
            ),
        }  # fmt: skip

    def _looks_in_frames(self, looks):
        """(frames,) array: how many of so many looks are in each frame."""
        first = self.average * np.arange(len(self.arrays["field"]))
        return np.clip(looks - first, 0, self.average)
