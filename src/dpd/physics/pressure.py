"""Constant pressure by stochastic cell rescaling (Bernetti and Bussi, JCP 153, 114107, 2020).

With the target P_0, the relaxation time tau, an estimate beta of the isothermal compressibility,
and the pressure P of the moment, lambda = sqrt(V) follows (the paper's Section II D)

    d lambda  =  (beta lambda / (2 tau)) (P - P_0 + kT/(2V)) dt + sqrt(kT beta / (2 tau)) dW

All positions are stretched with the box, and velocities are divided by the same factor, so P is
-dH/dV, with the virial of *conservative* forces: that of friction and noise would be a noise of the
volume that no term above balances. Where the box is stretched along one axis only, P is the normal
pressure along that.

A step over a time h is a trial of the Metropolis method: it counts with the probability
min(1, exp(-Delta)), where Delta is what the paper calls the change of the effective energy, in kT.
Volumes then have the distribution exp(-(H + P_0 V) / kT) for every h, tau and beta.

Of a membrane x and y are stretched alike, and z on its own, in turns, with the tension gamma of an
area A normal to z: exp(-(H + P_0 V - gamma A) / kT). At a constant L_z that is the former with the
pressure P_0 - gamma / L_z. (Two pressures that are given would be no such distribution: the work
P_xy L_z dA + P_z A dL_z depends on the way.)
"""

import math
from collections.abc import Mapping, Sequence
from typing import Any, Literal, NamedTuple, Self

import numpy as np

from dpd.page import Change, Positive, Refusals, Term, setting

TRIALS = 5  # in a relaxation time, unless the scene says how many steps lie between them


class ConstantPressure(Term, key="pressure"):
    """Constant pressure by stochastic cell rescaling (Bernetti and Bussi 2020).

    Without this key the box stays as it is. With it `box` is that of the start, and volumes may
    come to between a tenth and ten times that.
    """

    caption = "constant pressure {target} kT/r_c^{dimension}[, stretched along {axes}]"
    not_in_lammps = "is held by a box that our own steps rescale, which LAMMPS does not do"
    makes = frozenset({Change.STRETCHES})
    cannot = {
        Change.SLIDES: "cannot be held in a box whose images slide",
        Change.ENDS: "cannot be held in a box that ends",
        Change.FLOWS: "cannot be held in a fluid that flows",
        Change.STRETCHES: "stretches the box itself",
    }
    target: Positive = setting("Pressure that is held.", unit="kT / r_c^dimension")
    axes: Literal["all", "x", "y", "z", "xy-z"] = setting(
        "Along which the box is stretched, all alike, or one alone, whose normal pressure is then "
        "held; with xy-z x and y alike, and z on its own, as for a membrane.", "all", of="axis",
    )  # fmt: skip
    tension: float = setting(
        "With axes xy-z, tension L_z (p_zz - p_xx) of a membrane normal to z that is held.", 0.0,
        unit="kT / r_c^2", ge=-1e6, le=1e6,
    )  # fmt: skip
    time: float = setting("Relaxation time of the volume.", 2.0, unit="tau", ge=1e-3, le=1e6)
    compressibility: float | None = setting(
        "Estimate of the isothermal compressibility; it decides how fast the volume moves, not "
        "where to. If not given, that of the soft repulsion at the density of the start; needed "
        "where beads attract each other.", None,
        unit="r_c^dimension / kT", gt=0, le=1e18,
    )  # fmt: skip
    every: int | None = setting(
        "Steps from one change of the box to the next, at most the relaxation time; it decides the "
        "speed, not the result. If not given, a fifth of the relaxation time.", None, ge=1,
        le=10**15,
    )  # fmt: skip

    def completed(self, scene: Any) -> Self:
        """With a compressibility; and a time between trials, unless the step is yet to be tried."""
        given: dict[str, Any] = {}
        if self.compressibility is None and scene.repulsion.min() >= 0:
            given["compressibility"] = estimated_compressibility(scene)
        if self.every is None and not scene.is_auto:
            given["every"] = max(1, round(self.time / (TRIALS * scene.dt)))
        return self.model_copy(update=given)

    def controlled_pressure(self, values: Mapping[str, Any]) -> tuple[Any, float]:
        """The pressure, or its normal part along the one axis that is stretched alone."""
        if self.axes == "all" or "pressure_tensor" not in values:
            return None if self.tension else values.get("pressure"), self.target
        along = "xyz".index(self.axes[-1])
        return values["pressure_tensor"][:, along, along], self.target

    def refuses(self, scene: Any) -> Refusals:
        if self.axes == "xy-z" and scene.dimension == 2:
            yield "axes", "'xy-z' is for three dimensions; allowed: all, x, y"
        if self.tension and self.axes != "xy-z":
            yield "tension", "is held with axes xy-z; write that, or remove the key"
        if self.compressibility is None:
            text = "the key is missing: beads attract each other, and it cannot be estimated; give "
            yield "compressibility", f"{text}that of the liquid, as 0.003"
        if not scene.is_auto:
            most = max(1, math.floor(self.time / scene.dt * (1 + 1e-9)))
            if self.every is not None and self.every > most:
                text = f"{self.every} steps are longer than the relaxation time; allowed: <= {most}"
                yield "every", text

    @property
    def barostat_axes(self) -> str:  # type: ignore[override]
        return "all" if self.axes == "xy-z" else self.axes

    def records(self, scene: Any) -> dict[str, Any]:
        if self.every is None or self.compressibility is None:
            return {}
        every = "xyz"[: scene.dimension] if self.axes == "all" else self.axes
        parts = tuple(tuple(map("xyz".index, part)) for part in every.split("-"))
        numbers = self.target, self.time, self.compressibility, parts[0], self.every
        return {"pressure": Pressure(*numbers, parts, self.tension)}


def estimated_compressibility(scene: Any) -> float:
    """1 / (rho dp/drho) of p = rho_m kT + alpha <a> rho^2, in r_c^dimension / kT.

    With the density rho_m of molecules, the mean repulsion <a>, and alpha in mean field, g(r) = 1.
    """
    alpha = math.pi / {2: 24, 3: 30}[scene.dimension]
    share = np.bincount(scene.kinds, minlength=len(scene.species)) / scene.beads
    repulsion = float(share @ scene.repulsion @ share)
    ideal = len(scene.lengths) / scene.volume * scene.kT
    stiffness = ideal + 2 * alpha * repulsion * scene.density**2
    return float(f"{1 / stiffness:.4g}")


# Largest share of the volume that the mean of a trial moves. It matters where a start is far from
# its pressure; a trial as large as the equation wants would then leave what the forces know.
LARGEST = 0.1
STREAM = 0x70726573  # so that no other random numbers have the same key


class Look(NamedTuple):
    """What is known of a system at one volume."""

    volume: float  # in r_c^dimension
    pressure: float  # P, with the virial of conservative forces
    energy: float  # kinetic and potential energy in kT


class Pressure(NamedTuple):
    target: float  # P_0
    time: float  # tau
    compressibility: float  # beta
    axes: tuple[int, ...]  # along which the box is stretched
    every: int  # steps from trial to trial
    parts: tuple[tuple[int, ...], ...] = ()  # axes of each trial in turn, if they change
    tension: float = 0.0  # of an area normal to z

    def at(self, step: int, box: Sequence[float]) -> Self:
        """That of the trial at a step."""
        if len(self.parts) < 2:
            return self
        turn = step // self.every % 2
        less = (self.tension / box[2], 0.0)[turn]
        return self._replace(axes=self.parts[turn], target=self.target - less)

    def spread(self, kT: float, h: float) -> float:
        """Standard deviation of sqrt(V) in a trial over the time h."""
        return math.sqrt(kT * self.compressibility * h / (2 * self.time))

    def drift(self, look: Look, kT: float, h: float) -> float:
        """Mean change of sqrt(V) in a trial over the time h, `LARGEST` at most."""
        excess = look.pressure - self.target + kT / (2 * look.volume)
        share = self.compressibility * h / (2 * self.time) * excess
        return math.sqrt(look.volume) * min(max(share, -LARGEST / 2), LARGEST / 2)

    def trial(self, look: Look, kT: float, h: float, normal: float) -> float:
        """Volume to try next, a time h after the trial before; ``normal`` is a random number."""
        return (math.sqrt(look.volume) + self.drift(look, kT, h) + self.spread(kT, h) * normal) ** 2

    def change(self, here: Look, there: Look, kT: float, h: float) -> float:
        """Delta, the change of the effective energy in kT from one volume to another."""
        root, other = math.sqrt(here.volume), math.sqrt(there.volume)
        enthalpy = there.energy - here.energy + self.target * (there.volume - here.volume)
        forth = other - root - self.drift(here, kT, h)
        back = root - other - self.drift(there, kT, h)
        proposal = (back**2 - forth**2) / (2 * self.spread(kT, h) ** 2)
        # Of lambda, at the same scaled positions and momenta, the density is 2 lambda exp(-H/kT).
        return enthalpy / kT + proposal - math.log(other / root)


def draw(seed: int, step: int) -> tuple[float, float]:
    """Random numbers of the trial at a step: standard normal, and uniform in (0, 1]."""
    rng = np.random.Generator(np.random.Philox(key=[seed, STREAM], counter=[step, 0, 0, 0]))
    return float(rng.standard_normal()), 1.0 - float(rng.random())
