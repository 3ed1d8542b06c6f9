import math
from typing import Any

import numpy as np

from dpd.page import Change, Given, Observable, Refusals, setting

AXES = "field_x", "field_y", "field_z"
# Numbers over time, of 4 bytes. With copies for checkpoint and result they fit into the memory that
# a cluster is asked for, `dpd.pipeline.jobs`.
MOST_CELLS = 5 * 10**7


def grid_shape(box: tuple[float, ...], spacing: float) -> tuple[int, ...]:
    """Cells along each axis: equal ones, not wider than ``spacing``."""
    return tuple(math.ceil(edge / spacing - 1e-9) for edge in box)


class DensityField(Observable, key="density_field"):
    """Number density of each species in the cells of a grid, in frames one after the other.

    A frame is the average of ``average`` looks, ``every`` steps apart; the last one maybe of fewer.
    """

    stands = frozenset(Change) - {Change.SLIDES}
    over = {"frame": ("frame", "field_time")}
    single = frozenset({"density_field"})

    average: int = setting(
        "Looks in a frame, which covers every times average steps; the next one follows at once.",
        10, ge=1, le=1000000000,
    )  # fmt: skip
    spacing: float = setting(
        "Largest width of a cell, at most half the smallest edge.", 0.5, unit="r_c", ge=0.01
    )

    def given(self, scene: Any) -> dict[str, Given]:
        along = ("frame", "species", *AXES[: scene.dimension])
        density = "number density in cells, mean over the looks of a frame"
        return {
            "field_box": (("frame", "axis"), "r_c", "edges of the box, mean of a frame"),
            "density_field": (along, "1 / r_c^dimension", density),
        }

    def axes(self, scene: Any) -> Any:
        cells, text = grid_shape(scene.box, self.spacing), "middles of the cells along"
        return {
            name: ((np.arange(n) + 0.5) * (edge / n), "r_c", f"{text} {name[-1]}")
            for name, n, edge in zip(AXES, cells, scene.box)
        }

    def refuses(self, scene: Any) -> Refusals:
        smallest = min(scene.box)
        if self.spacing > smallest / 2:
            text = f"{self.spacing:g} makes fewer than two cells along an edge of {smallest:g}"
            yield "spacing", f"{text}; allowed: <= {smallest / 2:g}"
        cells = math.prod(grid_shape(scene.box, self.spacing)) * len(scene.species)
        frames = -(-(scene.steps.sample // self.every) // self.average)
        if (numbers := frames * cells) > MOST_CELLS:
            text = f"{frames} frames of {cells} cells (all species together) make {numbers:.3g}"
            more = f"allowed: <= {MOST_CELLS}. Take a larger every, average or spacing"
            yield "every", f"{text} numbers; {more}"

    def measure(self, now: Any) -> Any:
        shape, cell = grid_shape(now.whole.box, self.spacing), now.state.species
        box = now.system.extent if now.scene.ended else now.lattice
        cell = np.int64(0) if cell is None else cell.astype(np.int64)
        for k, cells in enumerate(shape):
            along = (now.state.position[k] - now.scene.origin[k]) * (cells / box[k])
            cell = cell * cells + np.minimum(np.maximum(along, 0.0), cells - 1).astype(np.int64)
        species, cells = len(now.scene.species), math.prod(shape)
        counts = np.bincount(cell, minlength=species * cells).reshape(species, *shape)
        return {"field_box": box, "density_field": counts * (cells / math.prod(box))}
