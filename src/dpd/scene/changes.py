"""Changes of plain data by keys that are joined by dots, as ``molecules.0.density``."""

from __future__ import annotations

from copy import copy
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


def merge(base: Any, change: Any, where: str = "scene", inside: str = "") -> Any:
    """``base`` with ``change`` put in: dicts key by key, list items by number; neither is altered.

    Raises
    ------
    UserError
        If keys are to be put into a list without such items, or into something that has none.
    """
    if not isinstance(change, dict):
        return change
    if not isinstance(base, dict | list):
        key = ".".join(filter(None, (inside, *map(str, list(change)[:1]))))
        raise UserError(f"{where}: {key} cannot be set: its place holds {shown(base)}, no keys")
    merged: Any = copy(base)
    for name, value in change.items():
        key = f"{inside}.{name}" if inside else str(name)
        if isinstance(merged, list) and (not str(name).isdigit() or int(name) >= len(merged)):
            problem = f"no item {name!r} in a list of {len(merged)}; they count from 0"
            raise UserError(f"{where}: {key}: {problem}")
        if isinstance(merged, list):
            name = int(name)
        before = merged[name] if isinstance(merged, list) else merged.get(name, {})
        merged[name] = merge(before, value, where, key)
    return merged
