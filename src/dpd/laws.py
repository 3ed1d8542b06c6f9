"""Laws of bonds, and what follows from their energies: how long bonds are, without other forces.

A law is a page, or a part of one, whose settings are the numbers of one pair of species; it has
``force(r)``, ``energy(r)`` and ``at_rest()``.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

# Of an edge: a bond that reaches further along an axis may soon be nearer to another image of its
# bead than to its own. It may so in this share of all bonds and steps, see
# dpd.observe.common.measured.
STRETCHED = 0.48
MOST_STRETCHED = 1e-4
SHORTEST, LONGEST = 1e-3, 1e3  # r_c, between which the least energy is looked for
NEAR, POINTS = 1e-5, 1000  # distances from rest at which energies are taken, on either side
FAR = 10  # edges of the box: bonds without a pull are taken to get so long
USUAL = 20.0  # kT above the least energy, up to which lengths of bonds are tried


def energies(law: Any, r: np.ndarray) -> np.ndarray:
    """At some lengths, in kT; infinite where the formula has no number.

    A formula without `math` takes all at once, which is a hundred times as fast.
    """
    with np.errstate(all="ignore"):
        try:
            found = np.broadcast_to(np.asarray(law.energy(r), float), r.shape)
        except (TypeError, ValueError):
            found = np.array([_energy(law, length) for length in r.tolist()])
    return np.where(np.isnan(found), np.inf, found)


def _energy(law, r):
    try:
        return law.energy(r)
    except (ValueError, ZeroDivisionError, OverflowError):  # of a logarithm, of a power
        return np.inf


def least_energy(law: Any) -> float:
    """Length of least energy in r_c; 0 where it falls down to the shortest."""
    r = np.geomspace(SHORTEST, LONGEST, 500)
    for _ in range(5):
        least = int(np.argmin(energies(law, r)))
        r = np.linspace(r[max(least - 1, 0)], r[min(least + 1, len(r) - 1)], 41)
    return round(float(r[20]), 6) if r[0] > SHORTEST else 0.0  # an energy tells it no better


def around_rest(law: Any, farthest: float, points: int) -> tuple[np.ndarray, np.ndarray]:
    """Lengths, the closer the nearer they are to that at rest, and energies there.

    So any bond is resolved, stiff or weak.
    """
    rest, offset = law.at_rest(), np.geomspace(NEAR, farthest, points)
    r = np.concatenate([(rest - offset)[::-1], [rest], rest + offset])
    r = r[r >= NEAR]
    return r, energies(law, r)


def usual_lengths(law: Any, kT: float) -> list[float]:
    """Some 50 lengths that bonds often have."""
    r, energy = around_rest(law, LONGEST, 200)
    usual = r[(energy <= energy.min() + USUAL * kT) & (r > SHORTEST)]
    return usual[:: max(1, len(usual) // 50)].tolist()


def stretched_share(law: Any, kT: float, box: Sequence[float]) -> float:
    """Share of bonds that reach over `STRETCHED` of an edge along an axis.

    From their weight r^(d-1) exp(-u / kT), in any direction, without other forces: where beads
    repel each other bonds are a little longer, which a run looks after itself
    (`dpd.observe.common.measured`). Summed over axes; at most 1, as where no length has an energy.
    """
    r, energy = around_rest(law, FAR * max(box), POINTS)
    if not np.isfinite(energy.min()):
        return 1.0
    weight = r ** (len(box) - 1) * np.exp((energy.min() - energy) / kT) * np.gradient(r)
    weight /= weight.sum()
    share: Any = 0.0
    for edge in box:
        cosine = np.minimum(1.0, STRETCHED * edge / r)  # from which on a direction reaches over
        share += weight @ (1 - cosine if len(box) == 3 else np.arccos(cosine) / (np.pi / 2))
    return float(min(share, 1.0))


def too_long(laws: Mapping[str, Any], scene: Any) -> Iterator[tuple[str, str]]:
    """Bonds of which too many would reach across half the box."""
    for name, law in laws.items():
        share = stretched_share(law, scene.kT, scene.room)
        if share > MOST_STRETCHED:
            edges = " x ".join(f"{edge:g}" for edge in scene.box)
            numbers = ", ".join(f"{key} {value:g}" for key, value in numbers_of(law).items())
            yield (
                name,
                f"{numbers}: at this temperature {share:.2g} of such bonds reach over "
                f"{STRETCHED:.0%} of an edge of the box of {edges} (estimated for bonds without "
                "other forces), and beyond half of it they would pull at other images; allowed: "
                f"{MOST_STRETCHED:g}. Take a larger box, or a stiffer or shorter bond",
            )


def numbers_of(law: Any) -> dict[str, float]:
    """The settings of a law that are numbers."""
    fields = {name: getattr(law, name) for name in type(law).model_fields}
    return {name: float(value) for name, value in fields.items() if isinstance(value, int | float)}
