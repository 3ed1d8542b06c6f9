"""Friction and noise between pairs, the thermostat of dissipative particle dynamics.

Along the line e between two beads that approach each other with e . v_ij (Groot and Warren 1997,
Eqs. 4 to 6 and 8), with w = 1 - r and random numbers theta of zero mean and unit variance:

    F_D = -gamma w^2 (e . v_ij)
    F_R =  sigma w theta dt^(-1/2),     sigma^2 = 2 gamma kT

Where pairs of species differ in their friction, gamma and sigma are those of the pair.

Langevin friction and noise act on each bead on its own, along each axis:

    F = -gamma v + sigma zeta dt^(-1/2),     sigma^2 = 2 gamma kT
"""

from collections.abc import Iterator
from typing import Annotated, Any, Literal, NamedTuple

import numpy as np
from pydantic import Field

from dpd.page import NotNegative, OneOr, Refusals, Table, Term, check_table, inside, setting

OneOrTwo = Annotated[str, Field(pattern=r"^\S+( \S+)?$")]  # species; for langevin one


class Thermostat(Term, key="thermostat"):
    """The thermostat; sigma^2 = 2 gamma kT."""

    caption = None
    kind: Literal["dpd", "langevin"] = setting(
        "Friction and noise between pairs (dpd), or on each bead on its own (langevin), which does "
        "not conserve momentum.", "dpd",
    )  # fmt: skip
    kT: float = setting("Temperature.", 1.0, ge=1e-6, le=1e6)
    gamma: OneOr[NotNegative, Table[OneOrTwo, NotNegative]] = setting(
        "Friction; 0 for none, and then no noise either. One number, or one for each pair of "
        "species, as {A A: 4.5, A B: 9, B B: 4.5}; for langevin one for each species, as {A: 4.5, "
        "B: 9}. In lowe-andersen it is the rate at which a pair takes a new velocity.", 4.5,
    )  # fmt: skip
    noise: Literal["uniform", "gaussian"] = setting("Distribution of the noise.", "uniform")

    def unknown(self, scene: Any) -> Refusals:
        if isinstance(self.gamma, dict):
            there = scene.pairs if self.kind == "dpd" else zip(scene.species)
            yield from inside("gamma", check_table(self.gamma, scene, there, 4.5))

    def frictions(self) -> list[float]:
        return list(self.gamma.values()) if isinstance(self.gamma, dict) else [self.gamma]

    def brakes(self, scene: Any) -> bool:
        return self.kind == "langevin" and any(self.frictions())

    def notes(self, scene: Any) -> Iterator[str]:
        there = "gaussian" if self.kind == "dpd" else "uniform"
        if "engine" in scene.data and self.noise != there and any(self.frictions()):
            yield f"thermostat.noise: it is {there} in LAMMPS"

    def lammps(self, scene: Any) -> list[str] | str:
        size, each = len(scene.species), self.kind == "langevin"
        gamma = np.broadcast_to(0.0 if each else scene.friction, (size, size))
        lines = [f"pair_style dpd {self.kT} 1.0 ${{seed}}"]
        for i, j in zip(*np.triu_indices(size)):
            lines.append(f"pair_coeff {i + 1} {j + 1} dpd {scene.repulsion[i, j]} {gamma[i, j]}")
        if each and any(self.frictions()):  # fix langevin takes the time in which a bead stops
            friction = np.broadcast_to(scene.friction, size)
            mass = np.ones(size) if scene.masses is None else scene.masses
            rubbed = friction.nonzero()[0]
            scaled = " ".join(f"scale {n + 1} {mass[n] / friction[n]}" for n in rubbed)
            lines.append(f"group rubbed type {' '.join(str(n + 1) for n in rubbed)}")
            lines.append(f"fix friction rubbed langevin {self.kT} {self.kT} 1.0 ${{seed}} {scaled}")
        return lines


class Friction(NamedTuple):
    """Friction and noise, between pairs, on each bead, or between beads and walls."""

    gamma: float  # friction in kT tau / r_c^2
    amplitude: float  # sigma dt^(-1/2), in kT / r_c
    gaussian: bool  # random numbers, or uniform ones
    # (species, species), or (species,) on each bead: gamma_ij / gamma where species differ. The
    # approach, or the velocity, then comes multiplied by its share, and noise by the root of that.
    shares: np.ndarray | None = None

    def force(self, approach: float, inverse: float, w: float, theta: float) -> float:
        """Force F_D + F_R on a pair with r . v_ij = approach and 1 / r = inverse."""
        drag = self.gamma * w * approach * inverse
        return w * (self.amplitude * theta - drag)

    def random(self, zeta: float, w: float) -> float:
        """Noise on a bead along an axis; w is 1 where no wall makes it."""
        return self.amplitude * w * zeta

    def drag(self, velocity: float, w: float) -> float:
        """Friction along an axis, which the force takes off, at a velocity relative to a wall."""
        return self.gamma * w * w * velocity
