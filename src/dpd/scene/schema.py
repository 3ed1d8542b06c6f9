"""Read YAML, check it against a schema, and say what is wrong in one sentence."""

from __future__ import annotations

import difflib
import hashlib
import math
import os
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import yaml

from dpd.digest import PACKAGE, cache_folder
from dpd.errors import UserError, reason, shown
from dpd.scene.plain_yaml import LOADER, Problem, load_plain

if TYPE_CHECKING:
    from collections.abc import Collection

SCHEMAS = PACKAGE / "schemas"
PAGES = PACKAGE / "physics"  # of the terms, each with its part of the scene's schema
LARGEST = 2**20  # bytes of a file; the largest paper has 20 thousand
LARGEST_NUMBER = 2**63  # of a whole number
EXACT = 2**53  # up to which every whole number is one with a decimal point
MOST_MARKS = 8000  # in the cache
NEAR = 0.65  # likeness of names, above which one may be meant: charge is no core, owm is own


@cache
def _rules(name):
    """A schema, and the pages that it may take parts from, as text."""
    pages = sorted(PAGES.glob("*.yaml")) if name == "scene" else []
    return "\0".join(path.read_text() for path in (SCHEMAS / f"{name}.yaml", *pages))


@cache
def _checks():
    """What decides whether data is valid, besides the rules."""
    return Path(__file__).read_text()


@cache
def schema(name: str) -> dict[str, Any]:
    """A schema by name: ``config``, ``study``, ``paper`` or ``scene``."""
    rules = _loaded(SCHEMAS / f"{name}.yaml")
    for key, rule in rules.get("properties", {}).items():
        if "$page" in rule:
            rules["properties"][key] = _loaded(PAGES / f"{rule['$page']}.yaml")
    return rules


def _loaded(path):
    return yaml.load(path.read_text(), LOADER)


@cache
def _validator(name):
    from jsonschema import Draft202012Validator  # see `validate`
    from jsonschema.validators import extend

    # The standard counts 3.0 among the whole numbers, with which one cannot count.
    kinds = Draft202012Validator.TYPE_CHECKER.redefine(
        "integer", lambda _, value: isinstance(value, int) and not isinstance(value, bool)
    )
    return extend(Draft202012Validator, type_checker=kinds)(schema(name))


def read_yaml(path: str | Path) -> dict[str, Any]:
    """Read a YAML file that holds a mapping.

    Raises
    ------
    UserError
        If the file is missing, is not YAML, holds something else, or could be misunderstood
        (see `dpd.scene.plain_yaml`).
    """
    path = Path(path)
    try:
        data = load_plain(_text(path))
    except Problem as problem:
        raise UserError(f"{path}: line {problem.line}: {problem}") from None
    except (yaml.YAMLError, ValueError, ArithmeticError, LookupError, TypeError) as problem:
        # PyYAML has them for values that are not of the kind that their tag says.
        where = getattr(problem, "problem_mark", None)
        line = f" (line {where.line + 1})" if where else ""
        raise UserError(f"{path}: this is not YAML{line}: {_first_line(problem)}") from None
    if data is None:
        raise UserError(f"{path}: the file is empty; expected keys and values")
    if not isinstance(data, dict):
        raise UserError(f"{path}: expected keys and values, found {type(data).__name__}")
    return data


def _text(path):
    """Contents of a file that is not too large."""
    try:
        if path.is_dir():
            raise UserError(f"{path}: is a folder; name a file in it")
        if not path.is_file():
            problem = "is not a file" if path.exists() else "there is no such file"
            raise UserError(f"{path}: {problem}")
        if path.stat().st_size > LARGEST:
            raise UserError(
                f"{path}: {path.stat().st_size} bytes are too many for YAML; allowed: <= {LARGEST}"
            )
        return path.read_text(encoding="utf-8")
    except OSError as problem:
        raise UserError(f"{path}: cannot be read ({reason(problem)})") from None


def validate(data: dict[str, Any], name: str, where: str) -> None:
    """Check data against a schema, unless it was found valid before.

    Every job of a study reads what Snakemake has read. To import the library that checks, and
    to check again, would be a fifth of the time that a job takes to begin.

    Parameters
    ----------
    data : dict
    name : str
        See `schema`.
    where : str
        File (and part) to name in a message.

    Raises
    ------
    UserError
        Naming file, key, value and what is allowed.
    """
    text = f"{_checks()}\0{_rules(name)}\0{data!r}"
    mark = cache_folder("valid") / hashlib.sha256(text.encode()).hexdigest()
    if os.path.exists(mark):  # false as well where we may not look
        return
    for key, value in _leaves(data):
        key = shown(key, str)
        if isinstance(value, float) and not math.isfinite(value):
            raise UserError(f"{where}: {key}: {value!r} is not a finite number")
        if isinstance(value, int) and abs(value) > LARGEST_NUMBER:
            raise UserError(f"{where}: {key}: a whole number of this size is out of range")
    errors = list(_validator(name).iter_errors(data))
    if errors:
        raise UserError(f"{where}: {_sentence(_deepest(min(errors, key=_depth)))}")
    with suppress(OSError):  # where nothing can be kept, it is checked each time
        mark.parent.mkdir(parents=True, exist_ok=True)
        mark.touch()
        _drop_oldest(mark.parent)


def _drop_oldest(folder):
    """Keep half of the marks where there are too many."""
    if len(os.listdir(folder)) <= MOST_MARKS:
        return
    marks = sorted(folder.iterdir(), key=lambda mark: mark.stat().st_mtime_ns)
    for mark in marks[: -MOST_MARKS // 2]:
        mark.unlink(missing_ok=True)


def with_defaults(data: dict[str, Any], rules: dict[str, Any]) -> dict[str, Any]:
    """A copy of valid data with the schema's defaults filled in.

    Where data is a table of entries that have defaults of their own, these go into each entry, and
    no other defaults are filled in.
    """
    filled = dict(data)
    entry = rules.get("additionalProperties")
    if isinstance(entry, dict) and "properties" in entry:
        named = {key: data[key] for key in data if key not in rules.get("properties", {})}
        if named:
            return filled | {key: with_defaults(value, entry) for key, value in named.items()}
    for key, rule in rules.get("properties", {}).items():
        if key not in filled and "default" in rule:
            filled[key] = rule["default"]
        if isinstance(filled.get(key), dict) and "properties" in rule:
            filled[key] = with_defaults(filled[key], rule)
    return filled


def suggestion(name: object, allowed: Collection[object]) -> str:
    """Allowed names, the nearest first, as the end of a message."""
    if not allowed:
        return "there are none"
    near = difflib.get_close_matches(str(name), [str(a) for a in allowed], 1, NEAR)
    guess = f"; did you mean {near[0]!r}?" if near else ""
    return f"allowed: {', '.join(map(str, allowed))}{guess}"


def _leaves(data, key=""):
    """Every value that is not a dict or list, with its dotted key."""
    if isinstance(data, dict | list):
        items = data.items() if isinstance(data, dict) else enumerate(data)
        for part, value in items:
            yield from _leaves(value, f"{key}.{part}" if key else str(part))
    else:
        yield key, data


def _depth(error):
    return len(error.absolute_path)


def _deepest(error):
    """Of the branches of a oneOf, the error of the branch that the value was meant for."""
    for branch in sorted(error.context or (), key=lambda e: -_depth(e)):
        if _depth(branch) > _depth(error):
            return _deepest(branch)
    return error


def _sentence(error):
    key = shown(".".join(map(str, error.absolute_path)), str) or "the file"
    value, rule = error.instance, error.schema
    meaning = f" ({rule['description']})" if "description" in rule else ""
    if error.validator == "additionalProperties" and isinstance(value, dict):
        known = list(rule.get("properties", {}))
        unknown = [k for k in value if k not in known]
        inside = "" if key == "the file" else f"{key}: "
        return f"{inside}unknown key {shown(unknown[0])}; {suggestion(unknown[0], known)}"
    if error.validator == "required":
        missing = [k for k in error.validator_value if k not in value]
        return f"{key}: the key {missing[0]!r} is missing{meaning}"
    if error.validator == "enum":
        numbers = all(isinstance(allowed, int) for allowed in error.validator_value)
        hint = _hint(value, ["integer"] if numbers else [])
        known = hint or f" is not known; {suggestion(value, error.validator_value)}"
        return f"{key}: {shown(value)}{known}{meaning}"
    if error.validator == "type":
        kinds = error.validator_value
        kinds = [kinds] if isinstance(kinds, str) else kinds
        hint = _hint(value, kinds) or f" is not of type {' or '.join(kinds)}"
        return f"{key}: {shown(value)}{hint}{meaning}"
    if error.validator in ("minimum", "exclusiveMinimum", "maximum", "exclusiveMaximum"):
        sign = {"minimum": ">=", "exclusiveMinimum": ">", "maximum": "<=", "exclusiveMaximum": "<"}
        limit = f"{sign[error.validator]} {error.validator_value}"
        return f"{key}: {shown(value)} is out of range; allowed: {limit}{meaning}"
    if error.validator == "oneOf":
        allowed = _alternatives(error.validator_value)
        kinds = [rule.get("type") for rule in error.validator_value]
        return (
            f"{key}: {shown(value)}{_hint(value, kinds) or ' is not allowed'}; {allowed}{meaning}"
        )
    if error.validator == "pattern":
        return f"{key}: {shown(value)} is not allowed{meaning}"
    return f"{key}: {shown(value)} is not allowed: {shown(error.message, str)}{meaning}"


def _hint(value, kinds):
    """What is wrong with a value that looks like the number or word that is meant; or nothing."""
    numbers = {"number", "integer"} & set(kinds)
    if value is None:
        return " (nothing after the colon) where a value is needed"
    if numbers and isinstance(value, bool):
        return " is true or false, not a number"
    number = _number(value) if numbers else None
    whole = numbers == {"integer"}
    if number is None or (whole and not number.is_integer()):
        return ""
    if whole and abs(number) > EXACT:
        return " is out of range for a whole number"
    if isinstance(value, float):
        hint = f" has a decimal point; a whole number is meant: write {value:.0f}"
        return hint if whole else ""
    if whole or value.strip().lstrip("+-").isdecimal():
        return f" is text where a number is meant; write {number:.0f} without quotes"
    plain = repr(number)
    plain = plain.replace("e", ".0e") if "e" in plain and "." not in plain else plain
    why = ", and 1e5 is text in YAML: a number has a point, and a sign after e" * (
        "e" in value.lower()
    )
    return f" is text where a number is meant; write {plain} without quotes{why}"


def _number(value):
    """The finite number that a value is, or is as text; None if it is none."""
    if not isinstance(value, float | str):
        return None
    try:
        number = float(value)
    except ValueError:
        return None
    return number if math.isfinite(number) else None


def _alternatives(rules):
    names = []
    for rule in rules:
        if "enum" in rule:
            names.append("one of " + ", ".join(map(str, rule["enum"])))
        elif "required" in rule:
            names.append(f"the key {rule['required'][0]!r}")
        else:
            low = f" > {rule['exclusiveMinimum']}" if "exclusiveMinimum" in rule else ""
            names.append(f"{rule.get('type')}{low}")
    return "allowed, exactly one of: " + "; ".join(names)


def _first_line(problem):
    return shown(next(iter(str(problem).splitlines()), type(problem).__name__), str)
