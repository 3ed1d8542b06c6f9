"""What the paper's sweeps calculate: how chains grow from monomers."""

from dpd.page import Calculation, Positive, Quantity, setting


class Polymerization(Calculation, key="polymerization"):
    """A melt of set (1) while it grows, by the rounds in which `start: polymerize` grows it.

    Growth ends when all chains that are wanted are whole, or at a limit.
    """

    beads: int = setting("Of a chain.", ge=2, le=1000)
    box: Positive = setting("Edge of the box in r_c; two beads in each r_c^2 are in chains.")
    limit: Positive = setting("Time in tau.")
    spare: float = setting("Monomers beyond those needed, as a share of those.", 0.2, ge=0, le=2)
    initiators: float = setting("Chains that begin, divided by those wanted.", 1.05, ge=1, le=2)
    seed: int | None = setting("If not given, that of the study.", None, ge=1, le=10**9)

    def scene(self):
        """The melt, as a scene of which kernels are compiled."""
        from dpd.scene.scene import Scene

        chains = max(1, round(2 * self.box**2 / self.beads))
        grown = {"spare": self.spare, "initiators": self.initiators}
        return Scene({
            "dimension": 2, "box": self.box, "repulsion": {"A A": 25},
            "molecules": [{"architecture": f"A {self.beads}", "count": chains}],
            "core": {"radius": 0.15, "force": 100}, "bond": {"stiffness": 300, "length": 0.25},
            "integrator": {"scheme": "gw-vv", "dt": 0.002}, "steps": {"sample": 1},
            "start": {"method": "polymerize", "polymerize": grown},
        })  # fmt: skip

    def calculate(self) -> dict[str, Quantity]:
        import numpy as np

        from dpd.start.common.growth import rounds

        scene = self.scene()
        interval = scene.start.polymerize.interval
        time, ended = np.arange(0.0, self.limit + 0.5), 0.0
        whole = np.zeros(len(time))
        for growth, _ in rounds(scene, self.seed or 1, 1.0, None):
            ended += interval
            done = len(growth.finished()) / growth.asked.sum()
            whole[time >= ended] = done
            if ended >= self.limit:
                break
        n, full = len(growth.chain), growth.length == growth.full
        in_whole, in_parts = growth.length[full].sum() / n, growth.length[~full].sum() / n
        return {
            "time": Quantity(time, "tau", "time in growth", ("time",)),
            "whole": Quantity(whole, "1", "whole chains over those wanted", ("time",)),
            "chains": Quantity(int(growth.asked.sum()), "1", "chains wanted"),
            "ended": Quantity(ended, "tau", "time at which growth ended"),
            "at_end": Quantity(done, "1", "whole chains over those wanted, at the end"),
            "in_whole": Quantity(in_whole, "1", "share of monomers in whole chains at the end"),
            "in_parts": Quantity(
                in_parts, "1", "share of monomers in unfinished chains at the end"
            ),
            "undone": Quantity(growth.undone / growth.made, "1", "bonds undone over bonds made"),
        }
