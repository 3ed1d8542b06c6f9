"""Harmonic bonds (Groot and Warren 1997, Eq. 25; with a rest length, Nikunen et al. 2007).

u(r)   =  C (r - l)^2 / 2
F(r)   = -C (r - l)
u''(r) =  C
"""

from typing import Any

from dpd.page import BondForce, OneOrTable, Pair, Section, setting


class BondLaw(Section):
    """A harmonic bond."""

    stiffness: float = setting("Spring constant C.", unit="kT / r_c^2", ge=0, le=1e7)
    length: float = setting("Rest length.", 0.0, unit="r_c", ge=0, le=1000)

    def force(self, r: float) -> Any:
        return -self.stiffness * (r - self.length)

    def energy(self, r: float) -> Any:
        return 0.5 * self.stiffness * (r - self.length) ** 2

    def curvature(self, r: float) -> Any:
        return self.stiffness

    def at_rest(self) -> float:
        return self.length


class HarmonicBonds(BondForce, key="bond"):
    """Harmonic bonds along the molecules, a pull of stiffness times (r - length).

    One law for all, {stiffness: 4, length: 0}, or a law for each pair of species that is bonded,
    {A A: {stiffness: 4}, A B: {stiffness: 10, length: 0.5}}.
    """

    bare = "law"
    untried = ""
    example = "{stiffness: 2, length: 0}"
    caption = "bonds of spring constant C = {stiffness} kT/r_c^2, rest length {length} r_c"
    law: OneOrTable[BondLaw, Pair] = setting("One law, or one for each pair of species.")

    def lammps(self, scene: Any) -> list[str] | str:
        laws = enumerate(self.laws(scene).values(), 1)  # the energy there is K (r - l)^2
        coefficients = [f"bond_coeff {n} {law.stiffness / 2} {law.length}" for n, law in laws]
        return ["bond_style harmonic", *coefficients]
