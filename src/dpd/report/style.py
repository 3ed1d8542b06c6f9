"""One look for all figures: column width, readable type, colours that all can tell apart."""

from pathlib import Path
from typing import Any, NamedTuple

import matplotlib as mpl
import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.container import ErrorbarContainer
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from dpd.analysis.statistics import COVERAGE

SINGLE, DOUBLE = 8.6 / 2.54, 17.8 / 2.54  # inches, a journal's one and two columns
MARKERS = ("o", "s", "^", "D", "v", "P", "X")
# Okabe and Ito's palette.
BLUE, ORANGE, GREEN, RED, PURPLE, SKY, BLACK = (
    "#0072B2", "#E69F00", "#009E73", "#D55E00", "#CC79A7", "#56B4E9", "#000000",
)  # fmt: skip
# For what comes in any number: Petroff's ten colours (arXiv:2107.02270) without the two grays.
MANY = (
    "#3f90da", "#ffa90e", "#bd1f01", "#832db6", "#a96b59", "#e76300", "#b9ac70", "#92dadd",
)  # fmt: skip
OF_SPECIES = (BLUE, ORANGE, GREEN, RED, PURPLE, SKY, *MANY)
# Whoever draws or writes a figure does it in `rc_context(LOOK)`.
LOOK: Any = mpl.rc_params_from_file(
    Path(__file__).with_name("look.mplstyle"), use_default_template=False
)


class Look(NamedTuple):
    """How a series is drawn, and what the legend calls it."""

    label: str
    color: str
    marker: str = "o"


def panels(
    columns: int = 1, rows: int = 1, height: float = 2.6, width: float | None = None,
    **options: Any,
) -> tuple[Figure, Axes | np.ndarray]:  # fmt: skip
    """A figure of panels, as wide as one column of a journal, or as two for panels side by side.

    Several are lettered (a), (b), ... in reading order. ``height`` of a row and ``width`` of the
    figure are in inches; ``options`` are for `matplotlib.pyplot.subplots`.
    """
    from matplotlib import pyplot as plt

    width = width or (DOUBLE if columns > 1 else SINGLE)
    figure, axes = plt.subplots(rows, columns, figsize=(width, height * rows), **options)
    if rows * columns > 1:
        for letter, panel in zip("abcdefghijklmnopqrstuvwxyz", np.ravel(axes)):
            panel.set_title(f"({letter})", loc="left")
    return figure, axes


def points(
    axes: Axes, x: npt.ArrayLike, y: npt.ArrayLike, error: npt.ArrayLike, label: str | None = None,
    color: str = BLUE, marker: str = "o", filled: bool = True, **options: Any,
) -> ErrorbarContainer:  # fmt: skip
    """Points with 95 % intervals from standard errors, which may have two rows: below, above.

    Points without a value are left out; those whose error is NaN are hollow and have no bar.
    """
    x, y, error = (np.asarray(part, dtype=float) for part in (x, y, error))
    seen, known = np.isfinite(y), np.isfinite(y) & np.isfinite(np.atleast_2d(error)).all(axis=0)
    face = color if filled else "white"
    drawn = axes.errorbar(
        x[seen], y[seen], COVERAGE * error[..., seen], label=label, color=color, marker=marker,
        linestyle=options.pop("linestyle", "none"), elinewidth=0.7, capsize=1.5, capthick=0.7,
        markerfacecolor=face if known.any() or not seen.any() else "white", markeredgewidth=0.8,
        **options,
    )  # fmt: skip
    if filled and known.any() and (seen & ~known).any():
        unsure = seen & ~known
        axes.plot(
            x[unsure], y[unsure], color=color, marker=marker, linestyle="none",
            markerfacecolor="white", markeredgewidth=0.8, zorder=drawn.lines[0].get_zorder() + 0.01,
            **{key: options[key] for key in ("clip_on", "markersize") if key in options},
        )  # fmt: skip
    return drawn


def published_line(
    axes: Axes, x: npt.ArrayLike, y: npt.ArrayLike, label: str | None
) -> list[Line2D]:
    """What the paper prints, always drawn alike."""
    return axes.plot(x, y, color=BLACK, linestyle=(0, (4, 2)), linewidth=0.9, label=label, zorder=1)
