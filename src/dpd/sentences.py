"""One sentence for each error of pydantic: file, key, value, what is allowed, what to do."""

from __future__ import annotations

import math
import re
from typing import TYPE_CHECKING, Any, get_args

from pydantic import BaseModel, ValidationError

from dpd.errors import UserError, shown, suggestion
from dpd.page import NAMES, Section, inside

if TYPE_CHECKING:
    from collections.abc import Iterable

    from pydantic.fields import FieldInfo

SIGNS = {
    "greater_than": ">", "greater_than_equal": ">=", "less_than": "<", "less_than_equal": "<=",
}  # fmt: skip
KINDS = {
    "float_type": "a number", "int_type": "a whole number", "int_from_float": "a whole number",
    "string_type": "text", "bool_type": "true or false", "list_type": "a list",
    "dict_type": "keys and values", "model_type": "keys and values",
    "model_attributes_type": "keys and values",
}  # fmt: skip
UNKNOWN = ("extra_forbidden", "invalid_key")
EXACT = 2**53  # up to which every whole number is one with a decimal point


def read_section(model: type[Section], value: Any, where: str, key: str = "") -> Any:
    """Settings from plain data; a UserError has a line for each mistake.

    ``where`` is the file (and part) to name in messages, ``key`` that of the section in it.
    """
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
        return None, _sentences(problem, model, key, more)
    problems = inside(key, found.conflicts())
    return found, [f"{place}: {text}" if place else text for place, text in problems]


def _sentences(problem, model, key, more):
    """In the order of what to mend first.

    A key that is unknown and one that is missing may be one mistake: then only the first is told.
    """
    errors = problem.errors(include_url=False)
    errors.sort(key=lambda e: (e["type"] not in UNKNOWN, "[key]" not in e["loc"], len(e["loc"])))
    found, guessed, names = [], [], set()
    for error in errors:
        if error["loc"][-1:] == ("[key]",):
            names.add(error["loc"][:-1])
        elif any(error["loc"][: len(name)] == name for name in names):
            continue  # what is wrong with a name is told already
        loc = [shown(each, str) for each in error["loc"]]
        loc = [each for each in loc if not each.startswith(("=", "["))]
        if loc and loc[0] == getattr(model, "bare", ""):  # the section is this setting
            loc = loc[1:]
        field, siblings = _setting(model, error)
        if error["type"] == "missing" and loc[:-1] in guessed:
            continue
        text = _text(error, [*siblings, *(more if len(loc) == 1 else [])])
        if error["type"] in UNKNOWN:
            guessed.append(loc[:-1])
        elif error["type"] != "value_error":
            text += meaning_of(field)
        if error["type"] in (*UNKNOWN, "missing"):
            loc = loc[:-1]
        place = ".".join(filter(None, (key, *loc)))
        place = place or ("" if error["type"] in UNKNOWN else "the file")
        found.append(f"{place}: {text}" if place else text)
    return found


def _text(error, siblings):
    """What is wrong, without file and key."""
    kind, value, ctx = error["type"], error["input"], error.get("ctx") or {}
    if kind in UNKNOWN:
        name = error["loc"][-1] if kind == "extra_forbidden" else value
        return f"unknown key {shown(name)}; {suggestion(name, siblings)}"
    if kind == "missing":
        return f"the key {error['loc'][-1]!r} is missing"
    if kind == "value_error":
        return str(ctx["error"])
    if kind in ("too_short", "too_long"):
        limit = f">= {ctx['min_length']}" if "min_length" in ctx else f"<= {ctx['max_length']}"
        return f"{ctx['actual_length']} entries; allowed: {limit}"
    if value is None:
        return "None (nothing after the colon) where a value is needed"
    if kind in SIGNS:
        limit = next(v for v in ctx.values() if isinstance(v, int | float))
        limit = limit if isinstance(limit, int) else f"{limit:.10g}"
        said = f" is out of range; allowed: {SIGNS[kind]} {limit}"
    elif kind == "literal_error":
        allowed = re.findall(r"'([^']*)'|(-?\d+)", ctx["expected"])
        said = f" is not known; {suggestion(value, [word or number for word, number in allowed])}"
    elif kind in KINDS:
        said = _number(value, kind) or f" is not {KINDS[kind]}"
    elif kind == "string_pattern_mismatch":
        name = NAMES.get(ctx["pattern"])
        said = f" is no name here; allowed: {name}" if name else " is not allowed"
    else:
        said = " is not a finite number" if kind == "finite_number" else f": {error['msg']}"
    return f"{shown(value)}{said}"


def _number(value, kind):
    """Of a value that looks like the number that is meant, what to write."""
    if kind not in ("float_type", "int_type", "int_from_float"):
        return ""
    if isinstance(value, bool):
        return " is true or false, not a number"
    try:
        number = float(value)
    except OverflowError:
        return " is out of range"
    except (TypeError, ValueError):
        return ""
    if not math.isfinite(number) or (kind != "float_type" and not number.is_integer()):
        return ""
    if kind != "float_type" and abs(number) > EXACT:
        return " is out of range for a whole number"
    if isinstance(value, float):
        return f" has a decimal point; a whole number is meant: write {value:.0f}"
    return f" is text where a number is meant; write {number:.15g} without quotes"


def _setting(model: Any, error: Any) -> tuple[FieldInfo | None, list[str]]:
    """The setting that an error is about (None for an unknown key), and the keys beside it."""
    inside = error["type"] in (*UNKNOWN, "missing")  # of what comes before the last of its place
    field: FieldInfo | None = None
    for each in error["loc"][:-1] if inside else error["loc"]:
        fields = _fields(model)
        if each in fields:  # if not, it is a key of a table
            field = fields[each]
            model = model_in(field.annotation)
    beside = _fields(model)
    if inside:
        field = beside.get(error["loc"][-1])
    return field, list(beside)


def _fields(model):
    """Settings of a section by their keys."""
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
    unit = unit_of(field)
    return f" ({field.description}{f' In {unit}.' if unit else ''})"


def unit_of(field: FieldInfo) -> str:
    """The unit of a setting; nothing if it has none."""
    extra = field.json_schema_extra
    return str(extra.get("unit", "")) if isinstance(extra, dict) else ""
