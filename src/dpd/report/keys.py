"""Keys of sections as rows of a table: what each may be, its unit, its default, what it means."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, NamedTuple, Union, get_args, get_origin

from pydantic import BaseModel

from dpd.errors import UserError, suggestion
from dpd.page import NEEDED, Observable, Page, Start, Term, find, names
from dpd.scene.sections import Basics
from dpd.scene.yaml import model_in, unit_of


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
    schema = Basics.model_json_schema()
    kinds = schema.setdefault("$defs", {})

    def of(page):
        found = page.model_json_schema()
        kinds.update(found.pop("$defs", {}))
        return found["properties"][page.bare] if page.bare else found

    schema["properties"] |= {key: of(page) for key, page in terms.items()}
    schema["required"] += [key for key in NEEDED if terms[key].has_required()]
    named = {key: of(page) for key, page in observables.items()}
    one = {"type": "object", "additionalProperties": False, "properties": named}
    items = [{"enum": list(named)}, one | {"minProperties": 1, "maxProperties": 1}]
    schema["properties"]["observe"]["items"] = {"anyOf": items}
    begins = of(Start)
    begins["properties"] |= {
        key: value for page in starts.values() for key, value in of(page)["properties"].items()
    } | {"method": begins["properties"]["method"] | {"enum": list(starts)}}
    schema["properties"]["start"] = begins
    return _closed(schema | {"title": "Scene of dpd-papers"})


def _closed(schema):
    """With tables that have the keys of their pattern alone, as pydantic reads them."""
    if isinstance(schema, list):
        return [_closed(each) for each in schema]
    if not isinstance(schema, dict):
        return schema
    found = {key: _closed(value) for key, value in schema.items()}
    return found | {"additionalProperties": False} if "patternProperties" in found else found


def scene_rows(own: Mapping[str, Any] | None = None) -> list[Row]:
    """All keys of a scene, with those of some pages of one's own."""
    found = [*rows_of(Basics, "")]
    terms, observables, starts = _pages(own)
    found += _start_rows(starts)
    for key, page in terms.items():
        found += section_rows(page, key, "")
    for key, page in observables.items():
        found += section_rows(page, key, "observe[].")
    return found


def _start_rows(starts):
    """Of the first configuration: what all methods have, then what each has of its own."""
    common = {row.key: row for row in section_rows(Start, "start", "")}
    told = " ".join(f"{key}: {text_of(page)}" for key, page in starts.items())
    changes = {
        "start": {"meaning": Start.summary()},
        "start.method": {"allowed": ", ".join(starts), "meaning": told},
    }
    yield from (row._replace(**changes.get(key, {})) for key, row in common.items())
    for key, page in starts.items():
        for row in rows_of(page, "start."):
            if row.key not in common:
                yield row._replace(meaning=f"For method {key}: {row.meaning}")


def rows_below(rows: list[Row], name: str) -> list[Row]:
    """Those of a section: of its key, and of the keys in it; `UserError` without such a section."""
    tops = [row.key.removeprefix("observe[].").split(".")[0].removesuffix("[]") for row in rows]
    if name not in tops:
        raise UserError(f"keys: no section {name!r}; {suggestion(name, sorted(set(tops)))}")
    return [row for row, top in zip(rows, tops) if top == name]


def text_of(model: Any) -> str:
    """A section's docstring, in one paragraph."""
    return " ".join((model.__doc__ or "").split())


def section_rows(model: Any, key: str, prefix: str) -> Iterator[Row]:
    """Rows of a section: its own, then those of its settings."""
    required = issubclass(model, Page) and model.has_required()
    bare = model.model_fields.get(getattr(model, "bare", ""))
    allowed = _allowed(bare.annotation, bare) if bare else "mapping"
    text = model.summary() if issubclass(model, Observable) else text_of(model)
    default = "required" if key in NEEDED and required else ""
    yield Row(f"{prefix}{key}", allowed, unit_of(bare) if bare else "", default, text)
    yield from rows_of(model_in(bare.annotation) if bare else model, f"{prefix}{key}.")


def rows_of(model: Any, prefix: str) -> Iterator[Row]:
    """Table rows of a section's settings, parents before children."""
    for name, field in (model.model_fields if model else {}).items():
        key = f"{prefix}{field.alias or name}"
        cells = _allowed(field.annotation, field), unit_of(field), _default(field)
        yield Row(key, *cells, field.description or "")
        inside = "[]" if get_origin(field.annotation) is list else ""
        kinds = [get_origin(each) for each in (field.annotation, *get_args(field.annotation))]
        named = ".NAME" if dict in kinds and not inside else ""
        yield from rows_of(model_in(field.annotation), f"{key}{inside}{named}.")


def _default(field):
    """Of a setting: nothing where the page or the scene decides."""
    if field.is_required():
        return "required"
    if field.default in (None, {}, []) or field.default_factory is not None:
        return ""
    if any(getattr(each, "ge", 0) == 1 for each in field.metadata) and not field.default:
        return ""  # the number of steps between samples
    return f"{field.default:g}" if isinstance(field.default, float) else str(field.default)


def _allowed(annotation, field=None):
    """What a value may be, in few words."""
    limits = _limits(field.metadata if field else ())
    origin, inside = get_origin(annotation), get_args(annotation)
    if origin is Annotated:
        return _allowed(inside[0]) + _limits(inside[1:])
    if origin is Literal:
        return ", ".join(map(str, inside))
    if origin in (Union, UnionType):
        kinds = (_allowed(each) for each in inside if each is not NoneType)
        return " or ".join(dict.fromkeys(kinds)) + limits
    if origin is list:
        return "list"
    if origin is dict or (isinstance(annotation, type) and issubclass(annotation, BaseModel)):
        return "mapping"
    words = {float: "number", int: "integer", str: "string", bool: "boolean"}
    return words.get(annotation, "value") + limits


def _limits(metadata):
    """Bounds as pydantic keeps them."""
    signs = (("ge", ">="), ("gt", ">"), ("le", "<="), ("lt", "<"))
    spread = [part for each in metadata for part in getattr(each, "metadata", [each])]
    found = (
        f" {sign} {getattr(each, name):.12g}"
        for name, sign in signs for each in spread if getattr(each, name, None) is not None
    )  # fmt: skip
    return ",".join(found)


def markdown_table(head: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """A table as Markdown."""
    lines = [head, ["---"] * len(head), *rows]
    # A "|" would end a cell.
    cells = [[str(cell).replace("|", "\\|") for cell in line] for line in lines]
    return "\n".join(f"| {' | '.join(line)} |" for line in cells)


def key_table(rows: Iterable[Row]) -> str:
    """A table of settings as Markdown."""
    head = "key", "allowed", "unit", "default", "meaning"
    return markdown_table(head, ((f"`{row.key}`", *row[1:]) for row in rows))
