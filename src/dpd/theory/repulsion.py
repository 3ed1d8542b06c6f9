"""Repulsion between unlike beads from the parameter chi of Flory-Huggins theory.

Groot and Warren (1997) took chi from what was in each of two phases of A and B, beads or chains of
equal length N with a_AA = a_BB (Eq. 18), and found slope (a_AB - a_AA) / kT (Eqs. 24 and 27).
"""

from typing import NamedTuple

WATER = 75.0  # a rho / kT that gives the compressibility of water, kappa^-1 = 16 (Sec. IV)
SAME = 0.02  # relative difference of a density, or of a repulsion, that counts for none
LEAST = 3.0  # chi N from which mean-field theory holds; the critical point is at 2 (Sec. V)


class Relation(NamedTuple):
    """A measured relation chi = slope (a_AB - a_AA) / kT, and where it was measured."""

    density: float
    shortest: int  # molecules of A and B, in beads
    longest: int
    slope: float
    error: float
    # The largest chi: of chains from the paper's largest excess repulsion, 40 kT / r_c; of single
    # beads, for which it gives none, where our own runs of its Fig. 7 end.
    most: float
    equation: str  # of Groot and Warren 1997

    def chi_range(self, length: int) -> tuple[float, float]:
        """Lowest and highest chi for molecules of that many beads."""
        return LEAST / length, self.most

    @property
    def beads(self) -> str:
        """Of which molecules it was measured, in words."""
        return f"{self.shortest} to {self.longest} beads" if self.longest > 1 else "single beads"

    def __str__(self) -> str:
        return (
            f"chi = ({self.slope:g} +- {self.error:g}) (a_AB - a_AA) / kT: {self.beads} at density "
            f"{self.density:g} (Groot and Warren 1997, {self.equation})"
        )


RELATIONS = (
    Relation(3.0, 1, 1, 0.286, 0.002, 6.0, "Eq. 24"),
    Relation(5.0, 1, 1, 0.689, 0.002, 6.0, "Eq. 24"),
    Relation(3.0, 2, 10, 0.306, 0.003, 12.2, "Eq. 27"),
)


def like_repulsion(density: float, kT: float = 1.0) -> float:
    """a_AA = 75 kT / density, with which the fluid is as hard to compress as water."""
    return WATER * kT / density


def relation_at(density: float, length: int = 1) -> Relation:
    """The relation measured at a density, for molecules of some beads; `ValueError` if none was."""
    for relation in RELATIONS:
        near = abs(density / relation.density - 1) <= SAME
        if near and relation.shortest <= length <= relation.longest:
            return relation
    known = "; ".join(f"density {one.density:g} with {one.beads}" for one in RELATIONS)
    beads = f"molecules of {length} beads" if length > 1 else "single beads"
    raise ValueError(
        f"no relation of chi and repulsion was measured for {beads} at density {density:.4g}; "
        f"allowed, within {SAME:.0%} of the density: {known}"
    )


def unlike_repulsion(
    chi: float, density: float, length: int = 1, kT: float = 1.0, like: float | None = None
) -> float:
    """a_AB for which beads of A and B have that chi, in molecules of ``length`` beads.

    ``like``: a_AA = a_BB, `like_repulsion` if not given. Raises `ValueError` outside of the range
    in which the relation was measured.

    Examples
    --------
    >>> round(unlike_repulsion(4, density=3), 2)
    38.99
    """
    relation = relation_at(density, length)
    lowest, highest = relation.chi_range(length)
    if not lowest <= chi <= highest:
        raise ValueError(
            f"{chi:g} is outside of the range in which {relation.equation} of Groot and Warren "
            f"1997 was measured; allowed: {lowest:.3g} (chi N = {LEAST:g}) to {highest:g}"
        )
    usual = like_repulsion(density, kT)
    own = usual if like is None else like
    if abs(own / usual - 1) > SAME:
        raise ValueError(
            f"a repulsion of {own:g} between like beads is not that at which chi was measured; "
            f"allowed: 75 kT / density = {usual:.4g}, within {SAME:.0%}"
        )
    return own + chi * kT / relation.slope
