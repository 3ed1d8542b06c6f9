"""How long bonds are by their law alone, a page with the numbers of one pair of species."""

from typing import Any

import numpy as np

SHORTEST, LONGEST = 1e-3, 1e3  # r_c, between which the least energy is looked for
NEAR = 1e-5  # the nearest distance from rest at which an energy is taken
USUAL = 20.0  # kT above the least energy, up to which lengths of bonds are tried


def energies(law: Any, r: np.ndarray) -> np.ndarray:
    """At some lengths, in kT; infinite where the formula has no number."""
    found = []
    for length in r.tolist():
        try:
            with np.errstate(all="ignore"):
                found.append(law.energy(length))
        except (ValueError, ZeroDivisionError, OverflowError):  # of a logarithm, of a power
            found.append(np.inf)
    return np.where(np.isnan(found), np.inf, found)


def least_energy(law: Any) -> float:
    """Length of least energy in r_c; 0 where it falls down to the shortest."""
    r = np.geomspace(SHORTEST, LONGEST, 500)
    for _ in range(5):
        least = int(np.argmin(energies(law, r)))
        r = np.linspace(r[max(least - 1, 0)], r[min(least + 1, len(r) - 1)], 41)
    return round(float(r[20]), 6) if r[0] > SHORTEST else 0.0  # an energy tells it no better


def usual_lengths(law: Any, kT: float) -> list[float]:
    """Some 50 lengths that bonds often have, the closer the nearer they are to that at rest."""
    rest, offset = law.at_rest(), np.geomspace(NEAR, LONGEST, 200)
    r = np.concatenate([(rest - offset)[::-1], [rest], rest + offset])
    r = r[r > SHORTEST]
    energy = energies(law, r)
    usual = r[energy <= energy.min() + USUAL * kT]
    return usual[:: max(1, len(usual) // 50)].tolist()
