"""Read YAML, check it against a schema, and say what is wrong in one sentence."""

import difflib
import hashlib
import math
import os
from contextlib import suppress
from functools import cache
from pathlib import Path

import yaml

from dpd.digest import ROOT, cache_folder
from dpd.errors import UserError

SCHEMAS = ROOT / "config" / "schema"
# libyaml reads a paper in a tenth of the time; PyYAML may come without it.
LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)


@cache
def _rules(name):
    return (SCHEMAS / f"{name}.yaml").read_text()


@cache
def schema(name):
    """A schema by name: ``config``, ``study``, ``paper`` or ``scene``."""
    return yaml.load(_rules(name), LOADER)


@cache
def _validator(name):
    from jsonschema import Draft202012Validator  # see `validate`

    return Draft202012Validator(schema(name))


def read_yaml(path):
    """Read a YAML file that holds a mapping.

    Raises
    ------
    UserError
        If the file is missing, is not YAML, or holds something else.
    """
    path = Path(path)
    if not path.is_file():
        raise UserError(f"{path}: there is no such file")
    try:
        data = yaml.load(path.read_text(), LOADER)
    except (yaml.YAMLError, UnicodeDecodeError) as problem:
        where = getattr(problem, "problem_mark", None)
        line = f" (line {where.line + 1})" if where else ""
        raise UserError(f"{path}: this is not YAML{line}: {_first_line(problem)}") from None
    if not isinstance(data, dict):
        raise UserError(f"{path}: expected keys and values, found {type(data).__name__}")
    return data


def validate(data, name, where):
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
    text = f"{_rules(name)}\0{data!r}"
    mark = cache_folder("valid") / hashlib.sha256(text.encode()).hexdigest()
    if os.path.exists(mark):  # false as well where we may not look
        return
    for key, value in _leaves(data):
        if isinstance(value, float) and not math.isfinite(value):
            raise UserError(f"{where}: {key}: {value!r} is not a finite number")
    errors = list(_validator(name).iter_errors(data))
    if errors:
        raise UserError(f"{where}: {_sentence(_deepest(min(errors, key=_depth)))}")
    with suppress(OSError):  # where nothing can be kept, it is checked each time
        mark.parent.mkdir(parents=True, exist_ok=True)
        mark.touch()


def with_defaults(data, rules):
    """A copy of valid data with the schema's defaults filled in."""
    filled = dict(data)
    for key, rule in rules.get("properties", {}).items():
        if key not in filled and "default" in rule:
            filled[key] = rule["default"]
        if isinstance(filled.get(key), dict) and "properties" in rule:
            filled[key] = with_defaults(filled[key], rule)
    return filled


def suggestion(name, allowed):
    """Allowed names, the nearest first, as the end of a message."""
    near = difflib.get_close_matches(str(name), [str(a) for a in allowed], 1)
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
    key = ".".join(str(part) for part in error.absolute_path) or "the file"
    value, rule = error.instance, error.schema
    meaning = f" ({rule['description']})" if "description" in rule else ""
    if error.validator == "additionalProperties" and isinstance(value, dict):
        known = list(rule.get("properties", {}))
        unknown = [k for k in value if k not in known]
        inside = "" if key == "the file" else f"{key}: "
        return f"{inside}unknown key {unknown[0]!r}; {suggestion(unknown[0], known)}"
    if error.validator == "required":
        missing = [k for k in error.validator_value if k not in value]
        return f"{key}: the key {missing[0]!r} is missing{meaning}"
    if error.validator == "enum":
        return f"{key}: {value!r} is not known; {suggestion(value, error.validator_value)}{meaning}"
    if error.validator == "type":
        kinds = error.validator_value
        kinds = kinds if isinstance(kinds, str) else " or ".join(kinds)
        return f"{key}: {value!r} is not of type {kinds}{meaning}"
    if error.validator in ("minimum", "exclusiveMinimum", "maximum", "exclusiveMaximum"):
        sign = {"minimum": ">=", "exclusiveMinimum": ">", "maximum": "<=", "exclusiveMaximum": "<"}
        limit = f"{sign[error.validator]} {error.validator_value}"
        return f"{key}: {value!r} is out of range; allowed: {limit}{meaning}"
    if error.validator == "oneOf":
        return f"{key}: {value!r} is not allowed; {_alternatives(error.validator_value)}{meaning}"
    return f"{key}: {value!r} is not allowed: {error.message}{meaning}"


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
    return str(problem).splitlines()[0]
