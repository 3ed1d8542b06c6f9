"""Bonds that reach so far that another image of a bead may soon be nearer than its own."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

# Of an edge: a bond that reaches further along an axis may soon be nearer to another image of its
# bead than to its own. It may so in this share of all bonds and steps, see
# dpd.observe.common.stretch.
STRETCHED = 0.48
MOST_STRETCHED = 1e-4


def stretched_share(bond: dict[str, Any], kT: float, box: Sequence[float]) -> float:
    """Share of harmonic bonds that reach over `STRETCHED` of an edge along an axis.

    From their Boltzmann weight r^(d-1) exp(-C (r - length)^2 / (2 kT)), in any direction, without
    other forces: where beads repel each other bonds are a little longer, which a run looks after
    itself (`dpd.observe.common.stretch`).

    Parameters
    ----------
    bond : dict
        ``stiffness`` and ``length``.
    kT : float
    box : tuple of float

    Returns
    -------
    float
        Summed over axes, at most 1, which it is without stiffness.
    """
    dimension = len(box)
    width = (kT / bond["stiffness"]) ** 0.5 if bond["stiffness"] else np.inf
    if width > 100 * max(box):
        return 1.0
    r = np.linspace(max(0.0, bond["length"] - 12 * width), bond["length"] + 12 * width, 4001)[1:]
    weight = r ** (dimension - 1) * np.exp(-(((r - bond["length"]) / width) ** 2) / 2)
    weight /= weight.sum()
    share = 0.0
    for edge in box:
        cosine = np.minimum(1.0, STRETCHED * edge / r)  # from which on a direction reaches over
        share += weight @ (1 - cosine if dimension == 3 else np.arccos(cosine) / (np.pi / 2))
    return float(min(share, 1.0))
