"""Changes of plain data by keys that are joined by dots, as ``molecules.0.density``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from dpd.errors import UserError, shown

if TYPE_CHECKING:
    from collections.abc import Mapping


def changed(base: Any, settings: Mapping[str, Any], where: str = "scene") -> Any:
    """``base`` with values put in by their keys, each of which is joined by dots; see `merge`."""
    for key, value in settings.items():
        for part in reversed(key.split(".")):
            value = {part: value}
        base = merge(base, value, where)
    return base


def merge(base: Any, change: Any, where: str = "scene", inside: tuple[str, ...] = ()) -> Any:
    """``base`` with ``change`` put in: dicts key by key, list items by number.

    Neither is altered; the result shares with them what it takes over whole.

    Raises
    ------
    UserError
        Naming ``where`` and the key (``inside`` are its parts so far), if keys are to be put into
        a list that has no such item, or into something that has no keys.
    """
    if not isinstance(change, dict):
        return change
    if isinstance(base, list):
        items = list(base)
        for place, value in change.items():
            if not str(place).isdigit() or int(place) >= len(items):
                raise UserError(
                    f"{where}: {'.'.join((*inside, str(place)))}: no item {place!r} in a list of "
                    f"{len(items)}; they count from 0"
                )
            items[int(place)] = merge(items[int(place)], value, where, (*inside, str(place)))
        return items
    if not isinstance(base, dict):
        key = ".".join((*inside, *map(str, list(change)[:1])))
        raise UserError(f"{where}: {key} cannot be set: its place holds {shown(base)}, no keys")
    merged = dict(base)
    for key, value in change.items():
        merged[key] = merge(merged.get(key, {}), value, where, (*inside, str(key)))
    return merged
