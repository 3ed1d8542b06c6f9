"""Integrators as rows of one table.

Each takes the force once a step. Those with friction and noise as forces predict and correct:

    r  += dt v + c dt^2 f
    v~  = v + lambda dt f          (the velocity that the friction sees)
    f'  = f(r, v~)
    v  += dt [ (1 - b) f + b f' ]

DPD-VV then takes the friction in f' once more, with the velocity v that it has led to.

The others split friction and noise off: pairs exchange momentum after a step of the conservative
forces alone, or in its middle. With g = gamma w^2 dt and a random number theta of unit variance,
each pair's relative velocity u = e . v_ij along its line becomes

    Shardlow (2003), half explicit and half implicit:
        u' = (u - g u + 2 sqrt(2 kT g) theta) / (1 + g)
    exact, as the Ornstein-Uhlenbeck process that it is (Serrano, De Fabritiis, Espanol and
    Coveney 2006):
        u' = u exp(-2 g) + sqrt(2 kT (1 - exp(-4 g))) theta
    Lowe (1999), with probability gamma dt:
        u' = sqrt(2 kT) theta

and half of the change goes to each bead. At rest u has the variance 2 kT.

This is for masses of 1. Two beads with the reduced mass mu exchange the momentum mu (u' - u), and
u / s, with s = 1 / sqrt(2 mu), follows the same equations with g / (2 mu) in the place of g.
"""

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Literal, NamedTuple, Self

import numpy as np
import yaml
from pydantic import Field, PrivateAttr

from dpd.errors import UserError
from dpd.page import Change, Refusals, Term, setting

# What the benchmark found for a fluid and for a melt of stiff bonds, at two frictions: the scheme
# and step of least run time for each tolerance in pressure and kT.
TABLE = Path(__file__).parent / "common" / "automatic.yaml"
# Beads per r_c^3 of the systems measured. Two beads that meet alone are no softer than there.
DENSITY = {"fluid": 3.0, "melt": 1.0}
SHARDLOW, EXACT, LOWE = 0, 1, 2


class Scheme(NamedTuple):
    acceleration: float  # c
    prediction: float | None  # lambda; None for 1 - b, the first share of the kick, or for nothing
    correction: float  # b
    renewal: bool | None = None  # whether friction is taken once more at the end of a step
    exchange: int | None = None  # `SHARDLOW`, `EXACT` or `LOWE`
    middle: bool | None = None  # whether force and exchange come between two halves of the drift


# The schemes of Groot and Warren 1997, Sec. III: Eq. 7, without and with dt^2 f / 2, and Eq. 9,
# with and without; that of Nikunen et al. 2007 (Besold et al. 2000); velocity Verlet followed by
# Shardlow's exchange, or by that of Lowe; and drift, kick, exact exchange, kick, drift in halves.
SCHEMES = {
    "euler": lambda prediction: Scheme(0.0, 1.0, 0.0),
    "euler-acceleration": lambda prediction: Scheme(0.5, 1.0, 0.0),
    "gw-vv": lambda prediction: Scheme(0.5, prediction, 0.5),
    "verlet-no-acceleration": lambda prediction: Scheme(0.0, prediction, 0.5),
    "dpd-vv": lambda prediction: Scheme(0.5, 0.5, 0.5, renewal=True),
    "shardlow": lambda prediction: Scheme(0.5, None, 0.5, exchange=SHARDLOW),
    "lowe-andersen": lambda prediction: Scheme(0.5, None, 0.5, exchange=LOWE),
    "aboba": lambda prediction: Scheme(0.0, None, 1.0, exchange=EXACT, middle=True),
}
WITHOUT_EXCHANGE = ", ".join(name for name, of in SCHEMES.items() if of(0.5).exchange is None)


def scheme_named(name: str, prediction: float = 0.5) -> Scheme:
    """A scheme of `SCHEMES`, with the lambda of those that have none of their own."""
    chosen = SCHEMES[name](prediction)
    is_share = chosen.prediction == 1.0 - chosen.correction
    return chosen._replace(prediction=None) if is_share else chosen


class Exchange(NamedTuple):
    """Exchange of momentum between pairs."""

    kind: int  # `SHARDLOW`, `EXACT` or `LOWE`
    gamma: float  # friction, or for Lowe's the rate of exchanges in 1 / tau
    kT: float
    gaussian: bool  # random numbers for Shardlow's; the others are exact with Gaussian ones alone
    shares: np.ndarray | None = None  # (species, species): gamma_ij / gamma where pairs differ

    def change(self, u: float, g: float, theta: float, drawn: bool) -> float:
        """Change of a relative velocity u; ``drawn`` says whether Lowe's pair is due."""
        if self.kind == SHARDLOW:
            push = math.sqrt(2.0 * self.kT * g) * theta
            return (u - g * u + 2.0 * push) / (1.0 + g) - u
        if self.kind == EXACT:
            decay = math.exp(-2.0 * g)
            return u * decay + math.sqrt(2.0 * self.kT * (1.0 - decay * decay)) * theta - u
        return math.sqrt(2.0 * self.kT) * theta - u if drawn else 0.0


class Integrator(Term, key="integrator"):
    """How beads move."""

    caption = None
    scheme: Literal["auto", *SCHEMES] = setting(  # type: ignore[valid-type]
        "Name of the scheme, or auto, for a run of your own: scheme and dt are tried on the scene "
        "itself, beginning with those of src/dpd/physics/common/automatic.yaml, until kT and "
        "pressure are within the tolerance. (Groot and Warren 1997, Sec. III; dpd-vv takes "
        "friction once more at the end of the step, Nikunen et al. 2007; shardlow, lowe-andersen "
        "and aboba let pairs exchange momentum one after the other)."
    )
    lambda_: float = Field(
        0.5, alias="lambda", description="Prediction of the velocity in the Verlet schemes.",
        ge=0, le=1,
    )  # fmt: skip
    dt: float | None = setting("Time step in tau.", None, ge=1e-9, le=10)
    tolerance: float | None = setting(
        "For auto: relative error in pressure and kT that is allowed; 0.01 if not given.", None,
        gt=0, le=0.1,
    )  # fmt: skip

    _guess: Self | None = PrivateAttr(None)

    def conflicts(self) -> Refusals:
        if self.scheme != "auto" and self.tolerance is not None:
            yield "tolerance", "only scheme 'auto' has one"
        if self.scheme != "auto" and self.dt is None:
            yield "", "the key 'dt' is missing (Time step in tau.)"
        if self.scheme == "auto" and self.dt is not None:
            yield "dt", "scheme 'auto' comes with its own; remove the key"

    @property
    def is_auto(self) -> bool:
        return self.scheme == "auto"

    @property
    def named(self) -> Self:
        """Itself; for auto the first guess, until `dpd.runs.auto.settle` has tried it."""
        return self._guess or self

    def completed(self, scene: Any) -> Self:
        if not self.is_auto:
            return self
        tolerance = self.tolerance or 0.01
        found = self.model_copy(update={"tolerance": tolerance})
        found._guess = type(self).model_validate(choose(scene, tolerance))
        return found

    def notes(self, scene: Any) -> Iterator[str]:
        if self.is_auto:
            found = f"{self.named.scheme}, dt {scene.dt:g}, a first guess, which a run tries"
            yield f"integrator.scheme: auto begins with {found}"

    def lammps(self, scene: Any) -> list[str] | str:
        if (self.scheme, self.lambda_) != ("gw-vv", 0.5):
            return "is in LAMMPS its velocity Verlet alone, which is 'gw-vv' with lambda 0.5"
        return ["fix move all nve", f"timestep {self.dt}"]

    def refuses(self, scene: Any) -> Refusals:
        """Exchanges of momentum where pairs are not alone."""
        if scheme_named(self.named.scheme).exchange is None:
            return
        for term in scene.terms.values():
            why = "whose friction is a force on beads" if term.brakes(scene) else ""
            if Change.SLIDES in term.changes(scene):
                why = "whose flow moves pairs apart by their distance"
            if why:
                text = f"{self.scheme!r} lets pairs exchange momentum, and there is {term.key!r}, "
                yield "scheme", f"{text}{why}; allowed: {WITHOUT_EXCHANGE}"


def choose(scene: Any, tolerance: float) -> dict[str, Any]:
    """A guess at ``scheme``, ``lambda`` and ``dt``, which `dpd.runs.auto` tries on the scene.

    The step is that of the measured system, shorter where this one is stiffer, as the period of its
    fastest motion, or hotter. A UserError says what was not measured (`dpd.page.Term.untried`).
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
            f"measured for; allowed: <= {most:g}, or name scheme and dt: shardlow, lowe-andersen, "
            "aboba hold gamma 200 at dt 0.04 in a fluid of density 3"  # kT 0.99, 1.00 and 1.02
        )
    above = min(choice["gamma"] for choice in choices if choice["gamma"] >= gamma)
    known = {choice["tolerance"]: choice for choice in choices if choice["gamma"] == above}
    if tolerance < min(known):
        raise UserError(
            f"{where}: integrator.tolerance: {tolerance:g} is less than was measured; allowed: >= "
            f"{min(known):g}"
        )
    return known[max(each for each in known if each <= tolerance)]
