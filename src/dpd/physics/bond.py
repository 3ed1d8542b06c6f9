"""Harmonic bonds (Groot and Warren 1997, Eq. 25; with a rest length, Nikunen et al. 2007, Eq. 5).

u(r)   =  C (r - l)^2 / 2
F(r)   = -C (r - l)
u''(r) =  C
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from dpd.page import OneOrTable, Pair, Refusals, Section, Term, check_laws, setting

if TYPE_CHECKING:
    from collections.abc import Sequence

# Of an edge: a bond that reaches further along an axis may soon be nearer to another image of its
# bead than to its own. It may so in this share of all bonds and steps, see
# dpd.observe.common.stretch.
STRETCHED = 0.48
MOST_STRETCHED = 1e-4


class BondLaw(Section):
    """A harmonic bond."""

    stiffness: float = setting("Spring constant C.", unit="kT / r_c^2", ge=0, le=1e7)
    length: float = setting("Rest length.", 0.0, unit="r_c", ge=0, le=1000)


class HarmonicBonds(Term, key="bond"):
    """Harmonic bonds along the molecules, a pull of stiffness times (r - length).

    One law for all, {stiffness: 4, length: 0}, or a law for each pair of species that is bonded,
    {A A: {stiffness: 4}, A B: {stiffness: 10, length: 0.5}}.
    """

    acts_on = "bonds"
    bare = "law"
    law: OneOrTable[BondLaw, Pair] = setting("One law, or one for each pair of species.")

    def refuses(self, scene: Any) -> Refusals:
        """Bonds that no molecule has, and bonded pairs without a law."""
        if not scene.has_bonds:
            yield (
                "",
                "every molecule is a single bead; remove the key, or give an architecture of "
                "several beads, as 'A 10'",
            )
        if isinstance(self.law, dict):
            pairs = scene.bonded_species
            unfit = list(check_laws(self.law, pairs))
            yield from unfit
            if unfit:
                return
            for pair in pairs:
                if not {" ".join(pair), " ".join(pair[::-1])}.intersection(self.law):
                    named = " ".join(pair)
                    yield "", f"no law for the pair {named!r}, which is bonded; add '{named}: ...'"
        for name, law in self.laws().items():
            share = stretched_share(law, scene.kT, scene.room)
            if share > MOST_STRETCHED:
                edges = " x ".join(f"{edge:g}" for edge in scene.box)
                yield (
                    name,
                    f"stiffness {law.stiffness:g}, length {law.length:g}: at this temperature "
                    f"{share:.2g} of such bonds reach over {STRETCHED:.0%} of an edge of the box "
                    f"of {edges} (estimated for bonds without other forces), and beyond half of it "
                    f"they would pull at other images; allowed: {MOST_STRETCHED:g}. Take a larger "
                    "box, or a stiffer or shorter bond",
                )

    def laws(self) -> dict[str, BondLaw]:
        """By pairs of species; one law for all by no name."""
        return self.law if isinstance(self.law, dict) else {"": self.law}


class Bond(NamedTuple):
    """A harmonic bond.

    Attributes
    ----------
    stiffness, length : float, or (laws,) arrays
        C in kT / r_c^2, and the rest length l in r_c; of all laws where there are several.
    number : None or (bonds,) uint16 array
        The place of each bond's law, where there are several.
    """

    stiffness: Any
    length: Any
    number: np.ndarray | None = None

    def force_over_r(self, r: float) -> Any:
        """Force over distance, F / r."""
        return -self.stiffness * (1.0 - self.length / r)

    def energy(self, r: float) -> Any:
        """Energy u."""
        return 0.5 * self.stiffness * (r - self.length) ** 2

    def curvature(self, r: float) -> Any:
        """Second derivative u''."""
        return self.stiffness


def stretched_share(bond: BondLaw, kT: float, box: Sequence[float]) -> float:
    """Share of harmonic bonds that reach over `STRETCHED` of an edge along an axis.

    From their Boltzmann weight r^(d-1) exp(-C (r - length)^2 / (2 kT)), in any direction, without
    other forces: where beads repel each other bonds are a little longer, which a run looks after
    itself (`dpd.observe.common.stretch`).

    Parameters
    ----------
    bond : BondLaw
    kT : float
    box : tuple of float

    Returns
    -------
    float
        Summed over axes, at most 1, which it is without stiffness.
    """
    dimension = len(box)
    width = (kT / bond.stiffness) ** 0.5 if bond.stiffness else np.inf
    if width > 100 * max(box):
        return 1.0
    r = np.linspace(max(0.0, bond.length - 12 * width), bond.length + 12 * width, 4001)[1:]
    weight = r ** (dimension - 1) * np.exp(-(((r - bond.length) / width) ** 2) / 2)
    weight /= weight.sum()
    share: Any = 0.0
    for edge in box:
        cosine = np.minimum(1.0, STRETCHED * edge / r)  # from which on a direction reaches over
        share += weight @ (1 - cosine if dimension == 3 else np.arccos(cosine) / (np.pi / 2))
    return float(min(share, 1.0))
