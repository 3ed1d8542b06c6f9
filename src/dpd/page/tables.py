"""Tables of a scene by species, by pairs of species, or by species along bonds."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from dpd.errors import shown, suggestion
from dpd.page.base import Refusals

MOST_NAMED = 20  # pairs or triples in a message


def no_species(name: str, species: Sequence[str]) -> str:
    """In words that no molecule has a species, and what may be meant."""
    found = f"no molecule has the species {name!r}"
    for other in species:
        if other.startswith(name) and other[len(name) :].isdigit():
            meant = f"'{name} {other[len(name) :]}', several beads of {name}"
            return f"{found}; allowed: {', '.join(species)}; did you mean {meant}?"
    return f"{found}; {suggestion(name, species)}"


def check_species(
    table: Mapping[str, Any], species: Sequence[str], example: float | str = "..."
) -> Refusals:
    """Species that there are not, and those without a value; they may be left out if ''."""
    wrong = [name for name in table if name not in species]
    for name in wrong:
        pair = "one value for each species, not for pairs" if " " in name else ""
        yield name, pair or no_species(name, species)
    for name in () if wrong or example == "" else species:
        if name not in table:
            text = f"add '{name}: {example}', or give one number for all"
            yield "", f"no value for the species {name!r}; {text}"


def check_table(
    table: Mapping[str, Any], scene: Any, there: Sequence[tuple[str, ...]],
    example: float | str = "...",
) -> Refusals:  # fmt: skip
    """Names of pairs or triples that there are not, two values of one, and those without.

    Parameters
    ----------
    table : dict
        Values by names, which may be read from either end.
    there : sequence of tuple of str
        All that there are, each as its lesser direction.
    example : float or str
        A usual value, for messages; '' where values may be left out.
    """
    species, known, wrong = set(scene.species), set(there), False
    for name, value in table.items():
        along = tuple(name.split())
        back = " ".join(along[::-1])
        problems = [no_species(each, scene.species) for each in {*along} - species]
        if not problems and min(along, along[::-1]) not in known:
            allowed = ", ".join(repr(" ".join(each)) for each in there[:MOST_NAMED])
            problems.append(f"no molecule has these beads bonded; allowed: {allowed}")
        if name < back and (other := table.get(back, value)) != value:
            values = [shown(f"{x:g}" if isinstance(x, float) else x, str) for x in (value, other)]
            problems.append(f"{values[0]}, but {values[1]} in the other order; keep one")
        for problem in problems:
            yield name, problem
        wrong = wrong or bool(problems)
    for along in () if wrong or example == "" else there:
        name, back = " ".join(along), " ".join(along[::-1])
        if name not in table and back not in table:
            yield "", f"no value for the pair {name!r}; add '{name}: {example}'"
