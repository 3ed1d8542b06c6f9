"""``integrator: {scheme: auto}``: a first guess, from what was measured in two systems.

automatic.yaml, beside this file, holds what the benchmark found: for a fluid and for a melt of
stiff bonds, at two frictions, the scheme and step of least run time for each tolerance in pressure
and kT. Other scenes heat up at other steps: `dpd.runs.auto` tries the guess on the scene itself.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import yaml

from dpd.errors import UserError

TABLE = Path(__file__).with_name("automatic.yaml")
# Beads per r_c^3 of the systems measured. Two beads that meet alone are no softer than there.
DENSITY = {"fluid": 3.0, "melt": 1.0}
# Their friction is no force: kT 0.99, 1.00 and 1.02 at gamma 200, where other schemes blow up.
HOLDING = ("shardlow", "lowe-andersen", "aboba")


def choose(scene: Any, tolerance: float) -> dict[str, Any]:
    """A guess at ``scheme``, ``lambda`` and ``dt``, for a relative error in pressure and kT.

    The step is that of the measured system, shorter where this one is stiffer (as
    1 / sqrt(stiffness), the period of its fastest motion) or hotter; the lightest beads count, and
    the highest friction. A UserError says what was not measured (`dpd.page.Term.untried`).
    """
    thermostat = scene.terms["thermostat"]
    untried = [term.untried.format(key=key) for key, term in scene.terms.items() if term.untried]
    if thermostat.kind == "langevin":
        text = "schemes were measured with friction between pairs"
        untried.append(f"{text}; for Langevin take gw-vv or dpd-vv")
    elif not any(thermostat.frictions()):
        untried.append("schemes were measured with a thermostat; without friction take gw-vv")
    if untried:
        text = f"{scene.where}: integrator.scheme: 'auto' cannot choose here"
        raise UserError(f"{text}: {untried[0]}")
    system = "melt" if (bond := scene.bond_force) else "fluid"
    measured = yaml.safe_load(TABLE.read_text())[system]
    gamma = max(thermostat.frictions()) / min(1.0, scene.lightest)
    choice = _row(measured["choices"], gamma, tolerance, scene.where)
    # C and a rho in kT / r_c^2 over those of the measured system
    known = measured["stiffness"]
    steepest = max(scene.repulsions.values()) * max(scene.density, DENSITY[system])
    ratios = [scene.kT, steepest / known["repulsion"]]
    if bond:
        ratios.append(max(law.stiffness for law in bond.laws(scene).values()) / known["bond"])
    slower = max(1.0, max(ratios) / min(1.0, scene.lightest)) ** 0.5
    dt = float(f"{choice['dt'] / slower:.2g}")
    return {"scheme": choice["scheme"], "lambda": choice.get("lambda", 0.5), "dt": dt}


def _row(choices, gamma, tolerance, where):
    """The measured choice that is safe for a friction and a tolerance."""
    most = max(choice["gamma"] for choice in choices)
    if gamma > most:
        raise UserError(
            f"{where}: thermostat.gamma: {gamma:g}, over the least mass, is more than 'auto' was "
            f"measured for; allowed: <= {most:g}, or name scheme and dt: {', '.join(HOLDING)} hold "
            "gamma 200 at dt 0.04 in a fluid of density 3"
        )
    above = min(choice["gamma"] for choice in choices if choice["gamma"] >= gamma)
    known = {choice["tolerance"]: choice for choice in choices if choice["gamma"] == above}
    if tolerance < min(known):
        raise UserError(
            f"{where}: integrator.tolerance: {tolerance:g} is less than was measured; allowed: >= "
            f"{min(known):g}"
        )
    return known[max(each for each in known if each <= tolerance)]
