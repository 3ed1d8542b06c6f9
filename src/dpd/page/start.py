"""Pages of first configurations."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

from pydantic import ConfigDict

from dpd.page.base import LARGEST_SEED, PACKAGE, Page, Refusals, Section, setting


class StartForces(Section):
    """Forces of growth and relaxation; terms have their key here, with the settings that differ."""

    model_config = ConfigDict(extra="allow")
    gamma: float | None = setting("Friction.", None, ge=0, le=1e6)


class Relax(Section):
    """Steps with gw-vv before the run, shared by all runs from the same start."""

    steps: int = setting("Steps of relaxation.", ge=1, le=10**9)
    dt: float = setting("Their time step.", unit="tau", ge=1e-9, le=10)


class Start(Page):
    """The first configuration."""

    folder = PACKAGE / "start"
    package = "dpd.start"
    _pages: ClassVar[dict[str, type[Page]]] = {}
    # Steps of the engine that take about as long as it does, beside those of ``relax``. Where it
    # takes any, forces act in it, and a job of its own makes it for all runs that share it.
    work: ClassVar[int] = 0
    joins: ClassVar[int] = 3  # beads that laws along bonds join at most which act in it
    # what it says of how it came about, by name: dimensions, units, long_name
    records: ClassVar[Mapping[str, tuple[tuple[str, ...], str, str]]] = {}

    method: str = setting("How beads are placed.", "random")
    kT: float | None = setting(
        "Temperature of the first velocities, if not the thermostat's.", None, ge=1e-6, le=1e6
    )
    seed: int | None = setting(
        "Seed of the start, if not that of the run.", None, ge=0, le=LARGEST_SEED
    )
    forces: StartForces = setting(
        "Forces of growth and relaxation, where they are not those of the run: gamma, and under "
        "their key settings of a rigid core, of bonds and of angles, as {bond: {stiffness: 100}}.",
        StartForces,
    )  # fmt: skip
    relax: Relax | None = setting(
        "Steps with gw-vv before the run, shared by all runs from the same start.", None
    )

    def conflicts(self) -> Refusals:
        """Forces that never act."""
        if self.forces != StartForces() and not self.acts:
            text = "has no effect: nothing is relaxed or grown; add start.relax, as {steps: 1000, "
            yield "forces", f"{text}dt: 0.01}}, or remove the key"

    @property
    def acts(self) -> bool:
        """Whether forces act while it is made."""
        return bool(self.work) or self.relax is not None

    def own(self) -> dict[str, Any]:
        """The settings that this page has and not every start, as plain data."""
        data = self.model_dump(exclude_none=True, by_alias=True)
        return {key: value for key, value in data.items() if key not in Start.model_fields}

    def decides(self, scene: Any) -> dict[str, Any]:
        """What decides the places of beads, beside box, molecules, seed and walls."""
        return {"settings": self.own()}

    def positions(self, scene: Any, rng: Any) -> Any:
        """(beads, dimension) array of places, molecule after molecule, each from 0 to the box.

        The random numbers, `numpy.random.Generator`, are of the start's seed.
        """
        raise NotImplementedError

    def velocities(self, scene: Any, rng: Any) -> Any:
        """(beads, dimension) array in r_c / tau, about a flow of shear; None for thermal ones."""
        return None

    def make(self, scene: Any, progress: Any, say: Any) -> Any:
        """A `dpd.engine.state.State` and its records, of one that does more than to place beads.

        ``progress``, or None, is called with the number of beads that are in their molecules, then
        of steps more; ``say`` with a sentence for what a person should know.
        """
        return None

    def stand_in(self) -> dict[str, Any]:
        """A start that takes no time, for what only compiles kernels or times them."""
        return {"seed": self.seed or 1} if self.work else self.plain()

    def tiny(self, scene: Any) -> dict[str, Any]:
        """What to change in a scene so that it compiles all kernels of the start in no time."""
        return {}
