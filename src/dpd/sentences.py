"""One sentence for each error of pydantic: file, key, value, what is allowed, what to do."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, get_args

from pydantic import BaseModel, ValidationError

from dpd.errors import UserError, shown, suggestion
from dpd.page import NAMES, Section, inside

if TYPE_CHECKING:
    from collections.abc import Iterable

    from pydantic.fields import FieldInfo

UNKNOWN = ("extra_forbidden", "invalid_key")


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
        errors = problem.errors(include_url=False)
        errors.sort(key=lambda error: error["type"] not in UNKNOWN)  # often that is the mistake
        return None, [_sentence(error, model, key, more) for error in errors]
    problems = inside(key, found.conflicts())
    return found, [f"{place}: {text}" if place else text for place, text in problems]


def _sentence(error, model, key, more):
    """Key and value of one error, and what is allowed there."""
    kind, value = error["type"], error["input"]
    field, beside = _setting(model, error["loc"])
    loc = [shown(each, str) for each in error["loc"]]
    loc = [each for each in loc if not each.startswith(("=", "["))]
    if loc and loc[0] == getattr(model, "bare", ""):  # the section is this setting
        loc = loc[1:]
    if kind in UNKNOWN:
        name = value if kind == "invalid_key" else error["loc"][-1]
        allowed = [*beside, *(more if len(loc) == 1 else ())]
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


def _setting(model: Any, loc: Iterable[Any]) -> tuple[FieldInfo | None, list[str]]:
    """The setting at a place (None for an unknown key), and the keys beside it."""
    field, fields = None, _fields(model)
    for each in loc:
        fields = _fields(model)
        field = fields.get(each, field)
        if each in fields:  # if not, it is a key of a table
            model = model_in(fields[each].annotation)
    return field, list(fields)


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
