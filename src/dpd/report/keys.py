"""Keys of sections as rows of a table: what each may be, its unit, its default, what it means."""

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

from pydantic.json_schema import GenerateJsonSchema

from dpd.page import NEEDED, Observable, Page, Start, Term, find, names
from dpd.scene.sections import Basics, Ramp
from dpd.scene.yaml import model_in

WORDS = {"object": "mapping", "array": "list"}  # of JSON schema in those of YAML
SIGNS = {"minimum": ">=", "exclusiveMinimum": ">", "maximum": "<=", "exclusiveMaximum": "<"}


class Closed(GenerateJsonSchema):
    """Tables have the keys of their pattern alone, as pydantic reads them."""

    def dict_schema(self, schema: Any) -> dict[str, Any]:
        """As of pydantic, but for that."""
        found = super().dict_schema(schema)
        return found | {"additionalProperties": False} if "patternProperties" in found else found


class Row(NamedTuple):
    """A key, and what is to be said of it."""

    key: str
    allowed: str
    unit: str
    default: str
    meaning: str


def _pages(own):
    """Terms, observables and starts by key, with those of one's own."""
    found = []
    for kind in (Term, Observable, Start):
        mine = {key: page for key, page in (own or {}).items() if issubclass(page, kind)}
        found.append({key: find(kind, key) for key in names(kind)} | mine)
    return found


def scene_schema(own: Mapping[str, Any] | None = None) -> dict[str, Any]:
    """A scene as JSON schema, by which editors complete and check keys."""
    terms, observables, starts = _pages(own)
    schema = Basics.model_json_schema(schema_generator=Closed)
    kinds = schema.setdefault("$defs", {})

    def of(page, may_change=lambda schema: schema):
        found = may_change(page.model_json_schema(schema_generator=Closed))
        kinds.update(found.pop("$defs", {}))
        return found["properties"][page.bare] if page.bare else found

    kinds["Ramp"] = Ramp.model_json_schema()
    schema["properties"]["box"] = or_ramp(schema["properties"]["box"])
    schema["properties"] |= {key: of(page, or_ramp) for key, page in terms.items()}
    schema["required"] += [key for key in NEEDED if terms[key].has_required()]
    schema["required"] = [key for key in schema["required"] if key not in _given(starts)]
    named = {key: of(page) for key, page in observables.items()}
    one = {"type": "object", "additionalProperties": False, "properties": named}
    items = [{"enum": list(named)}, one | {"minProperties": 1, "maxProperties": 1}]
    schema["properties"]["observe"]["items"] = {"anyOf": items}
    begins = of(Start)
    begins["properties"] |= {
        key: value for page in starts.values() for key, value in of(page)["properties"].items()
    } | {"method": begins["properties"]["method"] | {"enum": list(starts)}}
    schema["properties"]["start"] = begins
    return schema | {"title": "Scene of dpd-papers"}


def _given(starts):
    """Keys of a scene that some start can give."""
    return {key for page in starts.values() for key in page.completes}


def or_ramp(schema: Any) -> Any:
    """A schema in which numbers may be ramps, not in lists, and keys of laws names of types."""
    if isinstance(schema, list):
        return [or_ramp(each) for each in schema]
    if not isinstance(schema, dict):
        return schema
    if schema.get("type") == "number":
        return {"anyOf": [schema, {"$ref": "#/$defs/Ramp"}]}
    found = {key: value if key == "items" else or_ramp(value) for key, value in schema.items()}
    return {key.replace(r" \S+", r"( \S+)?"): value for key, value in found.items()}


def scene_rows(own: Mapping[str, Any] | None = None) -> list[Row]:
    """All keys of a scene, with those of some pages of one's own."""
    terms, observables, starts = _pages(own)
    begin = {row.key: row for row in section_rows(Start, "start", "")}  # what all methods have
    said = " ".join(f"{key}: {text_of(page)}" for key, page in starts.items())
    begin["start"] = begin["start"]._replace(meaning=Start.summary())
    begin["start.method"] = begin["start.method"]._replace(allowed=", ".join(starts), meaning=said)
    basic = (
        row._replace(default="") if row.key in _given(starts) else row
        for row in rows_of(Basics, "")
    )  # fmt: skip
    found = [*basic, *begin.values()]
    for key, page in starts.items():
        more = [row for row in rows_of(page, "start.") if row.key not in begin]
        found += [row._replace(meaning=f"For method {key}: {row.meaning}") for row in more]
    for key, page in terms.items():
        found += section_rows(page, key, "")
    for key, page in observables.items():
        found += section_rows(page, key, "observe[].")
    return found


def text_of(model: Any) -> str:
    """A section's docstring, in one paragraph."""
    return " ".join((model.__doc__ or "").split())


def section_rows(model: Any, key: str, prefix: str) -> Iterator[Row]:
    """Rows of a section: its own, then those of its settings."""
    required = issubclass(model, Page) and model.has_required()
    bare = model.model_fields.get(getattr(model, "bare", ""))
    given = model.model_json_schema()["properties"][model.bare] if bare else {"type": "object"}
    text = model.summary() if issubclass(model, Observable) else text_of(model)
    default = "required" if key in NEEDED and required else ""
    yield Row(f"{prefix}{key}", _allowed(given), given.get("unit", ""), default, text)
    yield from rows_of(model_in(bare.annotation) if bare else model, f"{prefix}{key}.")


def rows_of(model: Any, prefix: str) -> Iterator[Row]:
    """Table rows of a section's settings, parents before children."""
    schema = model.model_json_schema()["properties"] if model else {}
    for name, field in model.model_fields.items() if model else ():
        name = field.alias or name
        given = schema[name]
        default = "required" if field.is_required() else given.get("default")
        # Nothing where the page or the scene decides. Steps between samples are at least 1.
        if default in (None, {}, []) or (not default and given.get("minimum") == 1):
            default = ""
        default = f"{default:g}" if isinstance(default, float) else str(default)
        cells = _allowed(given), given.get("unit", ""), default
        yield Row(f"{prefix}{name}", *cells, field.description or "")
        kinds = {each.get("type") for each in _kinds(given)}
        inside = "[]" if given.get("type") == "array" else ".NAME" if "object" in kinds else ""
        yield from rows_of(model_in(field.annotation), f"{prefix}{name}{inside}.")


def _kinds(given):
    """JSON schemas of all that a value may be."""
    return given.get("anyOf") or given.get("oneOf") or [given]


def _allowed(given):
    """What a value may be, in few words, by its JSON schema."""
    if (kinds := _kinds(given)) != [given]:
        found = (_allowed(each) for each in kinds if each != {"type": "null"})
        return " or ".join(dict.fromkeys(found))
    if "enum" in given or "const" in given:
        return ", ".join(map(str, given.get("enum") or [given["const"]]))
    kind = "object" if "$ref" in given else given.get("type", "value")
    limits = [f" {sign} {given[key]:.12g}" for key, sign in SIGNS.items() if key in given]
    return WORDS.get(kind, kind) + ",".join(limits)
