from typing import Any, Literal

import numpy as np

from dpd.page import Change, Observable, Refusals, Species, setting


class Clusters(Observable, key="clusters"):
    """Number and sizes of clusters: what touches, by way of others or itself, is one cluster.

    Two molecules touch if two of their beads of the chosen species are near enough; so the tails of
    amphiphiles make micelles, whose size is the aggregation number. With `count: beads` beads touch
    instead, whether they are bonded or not. Of clusters with n_i molecules or beads the
    number-averaged size is the mean of n_i, the weight-averaged one the sum of n_i^2 over that of
    n_i. Both are 0 where no cluster is as large as `least`. A sample takes as long as 25 steps of a
    melt; micelles live longer than the 20 tau between two of them.
    """

    stands = frozenset(Change) - {Change.SLIDES}
    interval, cost = 20.0, 30.0
    gives = {
        "clusters": (("sample",), "1", "number of clusters"),
        "cluster_mean": (("sample",), "1", "number-averaged size of clusters"),
        "cluster_weighted": (("sample",), "1", "weight-averaged size of clusters"),
        "cluster_largest": (("sample",), "1", "size of the largest cluster"),
        "cluster_density": (("block", "cluster_size"), "1 / r_c^dimension", "density by size"),
    }

    of: list[Species] = setting(
        "The species by which they touch, as [T]; if not given, those of molecules of several "
        "beads.", [], of="some species",
    )  # fmt: skip
    within: float = setting("Distance within which beads touch.", 1.0, unit="r_c", gt=0, le=100)
    count: Literal["molecules", "beads"] = setting("What the sizes count.", "molecules")
    least: int = setting(
        "Smallest size that is a cluster for the number, the averages and the largest; so 2 leaves "
        "out what is alone.", 1, ge=1, le=10**6,
    )  # fmt: skip
    largest: int = setting("Largest size whose density is kept.", 200, ge=1, le=10**5)

    def axes(self, scene: Any) -> Any:
        return {"cluster_size": (range(1, self.largest + 1), "1", "size of a cluster")}

    def refuses(self, scene: Any) -> Refusals:
        if not self.species_of(scene):
            yield "of", f"is missing; give species, as [{scene.species[0]}]"
        repeats = (edge for k, edge in enumerate(scene.box) if k not in scene.ended)
        half = min(repeats, default=2 * self.within) / 2
        if self.within > half:
            yield "within", f"{self.within:g} is more than half the box; allowed: <= {half:g}"

    def species_of(self, scene: Any) -> list[str]:
        chains = [kind.beads for kind in scene.molecules if len(kind.beads) > 1]
        return self.of or [name for name in scene.species if any(name in each for each in chains)]

    def measure(self, now: Any) -> Any:
        from scipy.sparse import coo_array
        from scipy.sparse.csgraph import connected_components

        near, chosen = now.pairs(self.within), now.of(*self.species_of(now.scene))
        node = now.molecules if self.count == "molecules" else np.arange(now.beads)
        touch = chosen[near.i] & chosen[near.j]
        ends = node[near.i[touch]], node[near.j[touch]]
        graph = coo_array((np.ones(len(ends[0]), bool), ends), (node[-1] + 1,) * 2)
        cluster = connected_components(graph, directed=False)[1]
        # What holds none of the species is alone, and is no cluster.
        sizes = np.bincount(cluster[np.unique(node[chosen])])
        sizes = sizes[sizes > 0]
        density = np.bincount(sizes, minlength=self.largest + 1)[1 : self.largest + 1] / now.volume
        counted = sizes[sizes >= self.least]
        total = counted.sum()
        return {
            "clusters": len(counted), "cluster_mean": total / max(len(counted), 1),
            "cluster_weighted": np.square(counted).sum() / max(total, 1),
            "cluster_largest": counted.max(initial=0), "cluster_density": density,
        }  # fmt: skip
