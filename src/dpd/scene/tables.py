"""Values that a scene gives for each species, or for each pair of species, as arrays."""

from __future__ import annotations

from itertools import combinations_with_replacement
from typing import TYPE_CHECKING, Any

import numpy as np

from dpd.errors import UserError

if TYPE_CHECKING:
    from collections.abc import Mapping

    from dpd.scene.scene import Scene


def no_species(scene: Scene, name: str) -> str:
    """In words that no molecule has a species, and what may be meant."""
    found = f"no molecule has the species {name!r}; allowed: {', '.join(scene.species)}"
    for other in scene.species:
        if other.startswith(name) and other[len(name) :].isdigit():
            return f"{found}; did you mean '{name} {other[len(name) :]}', several beads of {name}?"
    return found


def pair_table(scene: Scene, values: Mapping[str, float]) -> np.ndarray:
    """(species, species) array of values by pairs as "A B"; NaN for pairs without one."""
    table = np.full((len(scene.species),) * 2, np.nan)
    for pair, value in values.items():
        i, j = (scene.species.index(name) for name in pair.split())
        table[i, j] = table[j, i] = value
    return table


def check_pairs(scene: Scene, key: str, values: Mapping[str, float], example: float) -> None:
    """Refuse a table that does not have each pair of species once, or twice with one value.

    Parameters
    ----------
    scene : Scene
    key : str
        Of the table in the scene, for messages.
    values : dict
        By pairs, as "A B".
    example : float
        A usual value, for messages.

    Raises
    ------
    UserError
    """

    def refuse(where, problem):
        raise UserError(f"{scene.where}: {where}: {problem}")

    for pair, value in values.items():
        names = pair.split()
        if len(names) != 2:
            refuse(f"{key}.{pair}", f"one value for each pair of species: write '{pair} {pair}'")
        other = values.get(f"{names[1]} {names[0]}", value)
        if other != value:
            refuse(f"{key}.{pair}", f"{value:g}, but {other:g} in the other order")
        for name in names:
            if name not in scene.species:
                refuse(f"{key}.{pair}", no_species(scene, name))
    table = pair_table(scene, values)
    for i, j in combinations_with_replacement(range(len(scene.species)), 2):
        if np.isnan(table[i, j]):
            pair = f"{scene.species[i]} {scene.species[j]}"
            refuse(key, f"no value for the pair {pair!r}; add '{pair}: {example:g}'")


def friction_table(scene: Scene, gamma: float | Mapping[str, float]) -> float | np.ndarray:
    """Friction as the engine takes it: a number, or an array by pairs of species or by species.

    Parameters
    ----------
    scene : Scene
    gamma : float or dict
        As ``thermostat.gamma``, checked.
    """
    if not isinstance(gamma, dict):
        return float(gamma)  # type: ignore[arg-type]
    if scene.data["thermostat"]["kind"] == "langevin":
        return np.array([float(gamma[name]) for name in scene.species])
    return pair_table(scene, gamma)


def mass_table(scene: Scene) -> np.ndarray | None:
    """(species,) array of masses; None where the scene names none, and all are 1."""
    if "mass" not in scene.data:
        return None
    return np.array([float(scene.data["mass"].get(name, 1)) for name in scene.species])


def check_tables(scene: Scene) -> None:
    """Refuse tables of repulsion, friction or mass that do not fit the species of a scene.

    Raises
    ------
    UserError
    """
    check_pairs(scene, "repulsion", scene.repulsions, 25)
    gamma = scene.data["thermostat"]["gamma"]
    if isinstance(gamma, dict):
        if scene.data["thermostat"]["kind"] == "langevin":
            _check_species(scene, "thermostat.gamma", gamma)
            for name in scene.species:
                if name not in gamma:
                    raise UserError(
                        f"{scene.where}: thermostat.gamma: no value for {name!r}; add '{name}: 4.5'"
                    )
        else:
            check_pairs(scene, "thermostat.gamma", gamma, 4.5)
    _check_species(scene, "mass", scene.data.get("mass", {}))


def _check_species(scene: Scene, key: str, values: Mapping[str, Any]) -> None:
    """Refuse names of species that are not in the scene, or of pairs."""
    for name in values:
        if name not in scene.species:
            pair = "one value for each species, not for pairs" if " " in name else ""
            raise UserError(f"{scene.where}: {key}.{name}: {pair or no_species(scene, name)}")
