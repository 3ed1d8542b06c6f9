"""``pressure``: what a scene at constant pressure leaves to us, and what cannot be."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from dpd.errors import UserError

if TYPE_CHECKING:
    from dpd.scene.scene import Scene

AXES = ("x", "y", "z")
TRIALS = 5  # in a relaxation time, unless the scene says how many steps lie between them
MOST_TIMES = 10  # by which the volume may grow, as dpd.engine.barostat has it
# Excess pressure over a rho^2 of beads that do not see each other, g(r) = 1: the integral of
# r F(r) over the soft repulsion. In three dimensions Groot and Warren (1997) measured 0.101.
MEAN_FIELD = {2: math.pi / 24, 3: math.pi / 30}
FIXED_BOX = ("walls", "shear", "body_force")  # keys of scenes whose box cannot be stretched


def with_pressure(scene: Scene) -> dict[str, Any]:
    """What a scene says of its pressure, with what it leaves to us.

    Parameters
    ----------
    scene : Scene
        Otherwise checked, with the key ``pressure``.

    Returns
    -------
    dict
        With ``compressibility``, and ``every`` unless the time step is yet to be chosen.

    Raises
    ------
    UserError
    """
    given = scene.data["pressure"]
    filled = {"compressibility": estimated_compressibility(scene)} | given
    dt = scene.data["integrator"]["dt"]
    if not scene.is_auto:
        filled.setdefault("every", max(1, round(filled["time"] / (TRIALS * dt))))
        _check_every(scene, filled, dt)
    _check_axes(scene, filled)
    _check_target(scene, filled)
    for key in FIXED_BOX:
        if key in scene.data:
            _refuse(scene, "", f"cannot be held in a scene with {key!r}; remove one of the two")
    return filled


def estimated_compressibility(scene: Scene) -> float:
    """1 / (rho dp/drho) of molecules with the soft repulsion alone, in r_c^dimension / kT.

    From p = rho_m kT + alpha <a> rho^2, with the density rho_m of molecules, the mean repulsion
    <a> of two beads, and alpha of `MEAN_FIELD`.
    """
    share = np.bincount(scene.kinds, minlength=len(scene.species)) / scene.beads
    repulsion = float(share @ scene.repulsion @ share)
    ideal = len(scene.lengths) / scene.volume * scene.data["thermostat"]["kT"]
    stiffness = ideal + 2 * MEAN_FIELD[scene.dimension] * repulsion * scene.density**2
    return float(f"{1 / stiffness:.4g}")


def _refuse(scene, key, problem):
    raise UserError(f"{scene.where}: pressure{key and '.'}{key}: {problem}")


def _check_every(scene, filled, dt):
    """No trial over more than the relaxation time: hardly one would count."""
    most = math.floor(filled["time"] / dt * (1 + 1e-9))
    if most < 1:
        _refuse(scene, "time", f"{filled['time']:g} is less than a step; allowed: >= {dt:g}")
    if filled["every"] > most:
        _refuse(
            scene, "every",
            f"{filled['every']} steps are longer than the relaxation time; allowed: <= {most}",
        )  # fmt: skip


def _check_axes(scene, filled):
    allowed = AXES[: scene.dimension]
    if filled["axes"] != "all" and filled["axes"] not in allowed:
        _refuse(
            scene, "axes",
            f"there is no {filled['axes']} in {scene.dimension} dimensions; allowed: all, "
            f"{', '.join(allowed)}",
        )  # fmt: skip


def _check_target(scene, filled):
    """Repulsion only adds to the pressure of an ideal gas of the molecules."""
    ideal = len(scene.lengths) * scene.data["thermostat"]["kT"]
    least = ideal / (MOST_TIMES * scene.volume)
    if filled["target"] < least:
        _refuse(
            scene, "target",
            f"{filled['target']:g} empties the box: {len(scene.lengths)} molecules would fill at "
            f"least {ideal / filled['target'] / scene.volume:.3g} times its volume of "
            f"{scene.volume:g}, and it may come to {MOST_TIMES} times that; "
            f"allowed: >= {least:.3g}",
        )  # fmt: skip
