"""Integrators as rows of one table.

Every scheme here evaluates the force once a step. Those that take friction and noise as
forces are the predictor-corrector

    r  += dt v + c dt^2 f
    v~  = v + lambda dt f          (the velocity that the friction sees)
    f'  = f(r, v~)
    v  += dt [ (1 - b) f + b f' ]

with their own acceleration term c, prediction lambda and correction b. DPD-VV then takes
the friction in f' once more, with the velocity v that it has led to.

The others split friction and noise off: pairs exchange momentum (see
`dpd.physics.common.exchange`) after a step of the conservative forces alone, or in its middle.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal, NamedTuple

from pydantic import Field, PrivateAttr

from dpd.page import Change, Refusals, Term, setting
from dpd.physics.common.exchange import EXACT, LOWE, SHARDLOW

if TYPE_CHECKING:
    from collections.abc import Iterator
    from typing import Self


class Scheme(NamedTuple):
    """One scheme."""

    # c and b
    acceleration: float
    # lambda. None where what is predicted is the velocity with the first share of its kick, 1 - b,
    # or nothing.
    prediction: float | None
    correction: float
    renewal: bool | None = None  # whether friction is taken once more at the end of a step
    exchange: int | None = None  # kind of the exchange of momentum
    # whether force and exchange come after half a drift, the other half at the end
    middle: bool | None = None


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
    if chosen.prediction == 1.0 - chosen.correction:
        return chosen._replace(prediction=None)
    return chosen


class Integrator(Term, key="integrator"):
    """How beads move."""

    caption = None
    scheme: Literal[
        "auto", "euler", "euler-acceleration", "gw-vv", "verlet-no-acceleration", "dpd-vv",
        "shardlow", "lowe-andersen", "aboba",
    ] = setting(
        "Name of the scheme, or auto, for a run of your own: scheme and dt are tried on the scene "
        "itself, beginning with those of src/dpd/physics/common/automatic.yaml, until kT and "
        "pressure are within the tolerance. (Groot and Warren 1997, Sec. III; dpd-vv takes "
        "friction once more at the end of the step, Nikunen et al. 2007; shardlow, lowe-andersen "
        "and aboba let pairs exchange momentum one after the other)."
    )  # fmt: skip
    lambda_: float = Field(
        0.5, alias="lambda", description="Prediction of the velocity in the Verlet schemes.",
        ge=0, le=1,
    )  # fmt: skip
    dt: float | None = setting("Time step in tau.", None, ge=1e-9, le=10)
    tolerance: float | None = setting(
        "For auto: relative error in pressure and kT that is allowed; 0.01 if not given.", None,
        gt=0, le=0.1,
    )  # fmt: skip

    _guess: Integrator | None = PrivateAttr(None)

    def conflicts(self) -> Refusals:
        """A time step or a tolerance, as the scheme is named or not."""
        if self.scheme != "auto" and self.tolerance is not None:
            yield "tolerance", "only scheme 'auto' has one"
        if self.scheme != "auto" and self.dt is None:
            yield "", "the key 'dt' is missing (Time step in tau.)"
        if self.scheme == "auto" and self.dt is not None:
            yield "dt", "scheme 'auto' comes with its own; remove the key"

    @property
    def is_auto(self) -> bool:
        """Whether scheme and step are left to us."""
        return self.scheme == "auto"

    @property
    def named(self) -> Integrator:
        """Itself; for auto the first guess, until `dpd.runs.auto.settle` has tried it."""
        return self._guess or self

    def completed(self, scene: Any) -> Self:
        if not self.is_auto:
            return self
        from dpd.physics.common.automatic import TOLERANCE, choose

        tolerance = self.tolerance or TOLERANCE
        found = self.model_copy(update={"tolerance": tolerance})
        found._guess = type(self).model_validate(choose(scene, tolerance))
        return found

    def notes(self, scene: Any) -> Iterator[str]:
        if self.is_auto:
            yield (
                f"integrator.scheme: auto begins with {self.named.scheme}, dt {scene.dt:g}, a "
                "first guess, which a run tries"
            )

    @property
    def exchanges(self) -> bool:
        """Whether pairs exchange momentum, in the place of friction as a force."""
        return scheme_named(self.named.scheme).exchange is not None

    def modules(self, scene: Any) -> tuple[str, ...]:
        return ("dpd.physics.common.exchange",) if self.exchanges else ()

    def refuses(self, scene: Any) -> Refusals:
        """Exchanges of momentum where pairs are not alone."""
        if not self.exchanges:
            return
        for term in scene.terms.values():
            if term.is_no_pair(scene):
                yield (
                    "scheme",
                    f"{self.scheme!r} lets pairs exchange momentum, and the friction of "
                    f"{term.key!r} is a force on beads; allowed: {WITHOUT_EXCHANGE}",
                )
            if Change.SLIDES in term.changes(scene):
                yield (
                    "scheme",
                    f"{self.scheme!r} lets pairs exchange momentum by their direction alone, and "
                    "how the flow moves them apart depends on their distance; allowed with "
                    f"{term.key!r}: {WITHOUT_EXCHANGE}",
                )
