"""A soft repulsion whose range is that of each pair of species.

F(r)  =  a (1 - r / R)   r < R
"""

from typing import Annotated

from pydantic import Field

from dpd.page import NotNegative, PairForce, PerPair, setting

Range = Annotated[float, Field(gt=0, le=1)]


class ShorterRepulsion(PairForce, key="soft"):
    """Soft repulsion that ends within the cutoff, beside `repulsion`, which may be 0 for a pair.

    As a cutoff by pair: what acts between A and B alone is {strength: {A A: 0, A B: 40, B B: 0},
    range: 0.8} where `repulsion` is 0 for A B. Friction and noise keep the range of 1.
    """

    caption = "soft repulsion of {strength} kT/r_c and range {range} r_c"
    strength: PerPair[NotNegative] = setting("Force a at no distance.", unit="kT / r_c")
    range: PerPair[Range] = setting("Distance R at which it ends.", unit="r_c")

    def force(self, r: float, w: float) -> float:
        inside = 1.0 if r < self.range else 0.0  # type: ignore[operator]
        return inside * self.strength * (1 - r / self.range)  # type: ignore[operator]

    def energy(self, r: float, w: float) -> float:
        inside = 1.0 if r < self.range else 0.0  # type: ignore[operator]
        return inside * self.strength * self.range / 2 * (1 - r / self.range) ** 2  # type: ignore[operator]
