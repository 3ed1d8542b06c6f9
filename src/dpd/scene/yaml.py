"""From YAML to settings: YAML 1.2, changes of what it holds, a sentence for each mistake in it.

PyYAML reads YAML 1.1, where `no` is false, 010 is 8, 1:30 is 90 and 1e5 is text, and takes the last
of two values of one key. Here `no` and 1:30 are text, 010 is 10 and 1e5 a number, as YAML 1.2 has
it (https://yaml.org/spec/1.2.2, Section 10.3), and a key stands once.
"""

import re
from collections.abc import Iterable, Mapping
from copy import copy
from pathlib import Path
from typing import Any, ClassVar, get_args

import yaml
from pydantic import BaseModel, ValidationError
from pydantic.fields import FieldInfo

from dpd.errors import UserError, reason, shown, suggestion
from dpd.page import NAMES, Section, inside

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


# --- settings from plain data

UNKNOWN = ("extra_forbidden", "invalid_key")


def read_section(model: type[Section], value: Any, where: str, key: str = "") -> Any:
    """Settings of the section ``key`` of a file; a UserError has a line for each mistake."""
    found, wrong = attempt(model, value, key)
    if wrong:
        raise UserError("\n".join(f"{where}: {text}" for text in wrong))
    return found


def attempt(
    model: type[Section], value: Any, key: str = "", more: Iterable[str] = ()
) -> tuple[Any, list[str]]:
    """Settings, or sentences on what is wrong with them; ``more`` keys are allowed beside them."""
    bare = getattr(model, "bare", "")
    try:
        found = model.model_validate({bare: value} if bare else value)
    except ValidationError as problem:
        errors = problem.errors(include_url=False)
        errors.sort(key=lambda error: error["type"] not in UNKNOWN)  # often that is the mistake
        return None, [_sentence(error, model, key, more) for error in errors]
    problems = inside(key, found.conflicts())
    return found, [f"{place}: {text}" if place else text for place, text in problems]


def _sentence(error, model, key, more):
    """Key and value of one error, and what is allowed there."""
    kind, value = error["type"], error["input"]
    # The setting, None for an unknown key, and those beside it.
    field, siblings, section = None, _fields(model), model
    for each in error["loc"]:
        siblings = _fields(section)
        field = siblings.get(each, field)
        if each in siblings:  # if not, it is a key of a table
            section = model_in(siblings[each].annotation)
    loc = [shown(each, str) for each in error["loc"]]
    loc = [each for each in loc if not each.startswith(("=", "["))]
    if loc and loc[0] == getattr(model, "bare", ""):  # the section is this setting
        loc = loc[1:]
    if kind in UNKNOWN:
        name = value if kind == "invalid_key" else error["loc"][-1]
        allowed = [*siblings, *(more if len(loc) == 1 else ())]
        text, loc = f"unknown key {shown(name)}; {suggestion(name, allowed)}", loc[:-1]
    elif kind == "missing":
        text, loc = f"the key {error['loc'][-1]!r} is missing{meaning_of(field)}", loc[:-1]
    elif kind == "value_error":
        text = str(error["ctx"]["error"])
    elif kind == "string_pattern_mismatch" and (name := NAMES.get(error["ctx"]["pattern"])):
        text = f"{shown(value)} is no name here; allowed: {name}"
    else:
        what, _, allowed = error["msg"].partition(" should ")
        colon = "" if what == "Input" else f": {what.lower()}"
        allowed = allowed.replace("a valid integer", "a whole number, as 10")
        text = f"{shown(value)}{colon} should {allowed}{meaning_of(field)}"
    place = ".".join(filter(None, (key, *loc))) or ("" if kind in UNKNOWN else "the file")
    return f"{place}: {text}" if place else text


def _fields(model):
    fields = model.model_fields if model is not None else {}
    return {field.alias or name: field for name, field in fields.items()}


def model_in(annotation: Any) -> type[BaseModel] | None:
    """The section inside of a type such as ``list[Molecule]``."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return annotation
    return next((m for each in get_args(annotation) if (m := model_in(each)) is not None), None)


def meaning_of(field: FieldInfo | None) -> str:
    """The description of a setting and its unit, in brackets."""
    if field is None or not field.description:
        return ""
    extra = field.json_schema_extra
    unit = extra.get("unit") if isinstance(extra, dict) else None
    return f" ({field.description}{f' In {unit}.' if unit else ''})"
