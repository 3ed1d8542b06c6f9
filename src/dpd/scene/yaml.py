"""YAML 1.2: numbers and words mean what they look like; and changes of what it holds.

PyYAML reads YAML 1.1, where `no` is false, 010 is 8, 1:30 is 90 and 1e5 is text, and takes the last
of two values of one key. Here `no` and 1:30 are text, 010 is 10 and 1e5 a number, as YAML 1.2 has
it (https://yaml.org/spec/1.2.2, Section 10.3), and a key stands once.
"""

from __future__ import annotations

import re
from copy import copy
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

import yaml

from dpd.errors import UserError, reason, shown

if TYPE_CHECKING:
    from collections.abc import Mapping

# Of the core schema: a tag, what it looks like, and with what it begins.
CORE = (
    ("bool", r"true|True|TRUE|false|False|FALSE", "tTfF"),
    ("null", r"~|null|Null|NULL|", ["~", "n", "N", ""]),
    ("int", r"[-+]?[0-9]+", "-+0123456789"),
    ("float", r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?", "-+.0123456789"),
    ("float", r"[-+]?\.(inf|Inf|INF)|\.(nan|NaN|NAN)", "-+."),
    ("merge", r"<<", "<"),
)
Quick = getattr(yaml, "CSafeLoader", yaml.SafeLoader)


class Loader(Quick):  # type: ignore[misc,valid-type]
    """Libyaml's, which reads a paper in a tenth of the time, with the rules of YAML 1.2."""

    yaml_implicit_resolvers: ClassVar[dict[str, Any]] = {}

    def flatten_mapping(self, node: Any) -> None:
        """Put in what is merged, if each of the node's own keys stands there once."""
        if not hasattr(node, "checked"):
            node.checked = True  # what is merged into it may be there already
            lines: dict[str, int] = {}
            for key, _ in node.value:
                name, mark = str(key.value), key.start_mark
                if name in lines:
                    text = f"the key {name} stands here twice, first on line {lines[name]}"
                    raise yaml.constructor.ConstructorError(problem=text, problem_mark=mark)
                lines[name] = mark.line + 1
        super().flatten_mapping(node)


for _tag, _form, _first in CORE:
    Loader.add_implicit_resolver(f"tag:yaml.org,2002:{_tag}", re.compile(f"^(?:{_form})$"), _first)
Loader.add_constructor("tag:yaml.org,2002:int", lambda loader, node: int(node.value))
Loader.add_constructor(
    "tag:yaml.org,2002:float",  # infinity and nan without their point
    lambda loader, node: float(re.sub(r"\.(?=[a-z])", "", node.value.lower())),
)


def read_yaml(path: str | Path) -> dict[str, Any]:
    """Read a YAML file that holds a mapping; a `UserError` says why it cannot be."""
    try:
        text = Path(path).read_bytes()
    except OSError as problem:
        raise UserError(f"{path}: cannot be read ({reason(problem)})") from None
    data = value_of(text, str(path))
    if not isinstance(data, dict):
        raise UserError(f"{path}: expected keys and values, found {shown(data)}")
    return data


def value_of(text: str | bytes, where: str) -> Any:
    """What a text in YAML stands for; a `UserError` names ``where``, if it is none."""
    try:
        return yaml.load(text, Loader)
    except (yaml.YAMLError, ValueError, LookupError, TypeError, RecursionError) as problem:
        # PyYAML has the others for values that are not of the kind that their tag says.
        mark = getattr(problem, "problem_mark", None)
        line = f"line {mark.line + 1}: " if mark else ""
        text = shown(getattr(problem, "problem", None) or problem, str)
        raise UserError(f"{where}: {line}this is not YAML: {text}") from None


def changed(base: Any, settings: Mapping[str, Any], where: str = "scene") -> Any:
    """``base`` with values put in by their keys, each of which is joined by dots; see `merge`."""
    for key, value in settings.items():
        for part in reversed(key.split(".")):
            value = {part: value}
        base = merge(base, value, where)
    return base


def merge(base: Any, change: Any, where: str = "scene", inside: str = "") -> Any:
    """``base`` with ``change`` put in: dicts key by key, list items by number; neither is altered.

    A `UserError` refuses keys of a list without such items, or of something that has none.
    """
    if not isinstance(change, dict):
        return change
    if not isinstance(base, dict | list):
        key = ".".join(filter(None, (inside, *map(str, list(change)[:1]))))
        raise UserError(f"{where}: {key} cannot be set: its place holds {shown(base)}, no keys")
    merged: Any = copy(base)
    for name, value in change.items():
        key = f"{inside}.{name}" if inside else str(name)
        if isinstance(merged, list):
            if not str(name).isdigit() or int(name) >= len(merged):
                problem = f"no item {name!r} in a list of {len(merged)}; they count from 0"
                raise UserError(f"{where}: {key}: {problem}")
            name = int(name)
        before = merged[name] if isinstance(merged, list) else merged.get(name, {})
        merged[name] = merge(before, value, where, key)
    return merged
