"""Chains that grow from monomers."""

from typing import Any, Literal

from dpd.page import Refusals, Section, Start, setting

CHAINS = 32  # of each kind in a melt that is grown to compile growth
BOX = 8  # r_c, of that melt


class Growth(Section):
    """How chains grow."""

    radius: float = setting("Reaction radius.", 1.0, unit="r_c", gt=0, le=2)
    partner: Literal["random", "nearest"] = setting(
        "Which free monomer within the radius a growing end tries first.", "random"
    )
    initiators: float = setting(
        "Number of chains that begin to grow, divided by the number wanted; the first to finish "
        "are kept.", 1.05, ge=1, le=2,
    )  # fmt: skip
    spare: float = setting(
        "Monomers beyond those that the chains need, as a share of those; they are removed at the "
        "end.", 0.2, ge=0, le=2,
    )  # fmt: skip
    interval: float = setting(
        "Time between two tries of a growing end.", 0.05, unit="tau", ge=1e-6, le=1e6
    )
    mixing: float = setting(
        "Mean time after which a free monomer is moved to a random place; otherwise bonds would "
        "wall it in.", 0.5, unit="tau", ge=1e-6, le=1e6,
    )  # fmt: skip
    dt: float = setting("Time step of the growth.", 0.002, unit="tau", ge=1e-9, le=10)


class Polymerize(Start, key="polymerize"):
    """Chains that grow in two dimensions from monomers without crossing bonds (Liu et al. 2008).

    20 000 beads in chains of 100 take half a minute, in chains of 200 a minute.
    """

    work = 10_000  # more than any melt has taken so far
    joins = 2

    polymerize: Growth = setting("How chains grow.", Growth)

    def refuses(self, scene: Any) -> Refusals:
        if scene.dimension != 2:
            yield "method", "'polymerize' grows chains in two dimensions only"
        if not scene.has_bonds:
            yield "method", "'polymerize' has nothing to grow: no chains, no bond"
        if scene.types:
            yield "method", "'polymerize' grows bonds whose laws are those of species, not of types"
        for kind, given in zip(scene.molecules, scene.data["molecules"]):
            if not (kind.is_chain and kind.is_linear):
                yield "method", f"'polymerize' grows chains; {given['architecture']!r} has branches"

    def decides(self, scene: Any) -> dict[str, Any]:
        return self.own()

    def make(self, scene: Any, progress: Any, say: Any) -> Any:
        """Grow them, and relax them without letting them cross."""
        from dpd.start.common.growth import grown

        return grown(self, scene, progress)

    def tiny(self, scene: Any) -> dict[str, Any]:
        """A melt in which bonds of any study fit."""
        kinds = [
            {"architecture": " ".join(sorted(set(kind.beads)) * 2), "count": CHAINS}
            for kind in scene.molecules
        ]
        return {"box": BOX, "molecules": kinds, "observe": []}
