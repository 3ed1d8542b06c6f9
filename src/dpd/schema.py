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
from dpd.errors import UserError, reason

SCHEMAS = ROOT / "config" / "schema"
# libyaml reads a paper in a tenth of the time; PyYAML may come without it.
MOST_VALUES = 100_000  # in a file
MOST_MARKS = 8000  # in the cache
LONGEST = 160  # characters of a value in a message
LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)


@cache
def _rules(name):
    return (SCHEMAS / f"{name}.yaml").read_text()


@cache
def _checks():
    """What decides whether data is valid, besides the rules."""
    return Path(__file__).read_text()


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
    try:
        if not path.is_file():
            there = path.exists() and str(path) != "."
            problem = "is not a file" if there else "there is no such file"
            raise UserError(f"{path}: {problem}")
        data = yaml.load(path.read_text(), LOADER)
        _refuse_endless(data, path)
    except OSError as problem:
        raise UserError(f"{path}: cannot be read ({reason(problem)})") from None
    except RecursionError:
        raise UserError(f"{path}: nested too deep, or contains itself") from None
    except (yaml.YAMLError, ValueError, ArithmeticError, AttributeError, TypeError) as problem:
        # PyYAML has them for dates and numbers that are none.
        where = getattr(problem, "problem_mark", None)
        line = f" (line {where.line + 1})" if where else ""
        raise UserError(f"{path}: this is not YAML{line}: {_first_line(problem)}") from None
    if not isinstance(data, dict):
        raise UserError(f"{path}: expected keys and values, found {type(data).__name__}")
    return data


def _refuse_endless(data, path):
    """Refuse data that refers to itself, or to its parts so often that it would fill the memory."""
    left = MOST_VALUES
    for _ in _leaves(data):
        left -= 1
        if not left:
            raise UserError(f"{path}: more than {MOST_VALUES} values; nothing here needs as many")


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
    text = f"{_checks()}\0{_rules(name)}\0{data!r}"
    mark = cache_folder("valid") / hashlib.sha256(text.encode()).hexdigest()
    if os.path.exists(mark):  # false as well where we may not look
        return
    for key, value in _leaves(data):
        if isinstance(value, float | int) and not _is_finite(value):
            raise UserError(f"{where}: {key}: {_shown(value)} is not a finite number")
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


def _is_finite(value):
    try:
        return math.isfinite(value)
    except OverflowError:  # an integer beyond all floating-point numbers
        return False


def _shown(value):
    """A value as a message has it: not longer than a line."""
    if isinstance(value, int) and abs(value) > 2**400:
        return f"{'-' * (value < 0)}10^{int(math.log10(abs(value)))}"
    return _cut(repr(value))


def _cut(text):
    return text if len(text) <= LONGEST else f"{text[:LONGEST]}..."


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
    key = _cut(".".join(str(part) for part in error.absolute_path)) or "the file"
    value, rule = error.instance, error.schema
    meaning = f" ({rule['description']})" if "description" in rule else ""
    if error.validator == "additionalProperties" and isinstance(value, dict):
        known = list(rule.get("properties", {}))
        unknown = [k for k in value if k not in known]
        inside = "" if key == "the file" else f"{key}: "
        return f"{inside}unknown key {_shown(unknown[0])}; {suggestion(unknown[0], known)}"
    if error.validator == "required":
        missing = [k for k in error.validator_value if k not in value]
        return f"{key}: the key {missing[0]!r} is missing{meaning}"
    if error.validator == "enum":
        allowed = suggestion(value, error.validator_value)
        return f"{key}: {_shown(value)} is not known; {allowed}{meaning}"
    if error.validator == "type":
        kinds = error.validator_value
        kinds = kinds if isinstance(kinds, str) else " or ".join(kinds)
        return f"{key}: {_shown(value)} is not of type {kinds}{meaning}"
    if error.validator in ("minimum", "exclusiveMinimum", "maximum", "exclusiveMaximum"):
        sign = {"minimum": ">=", "exclusiveMinimum": ">", "maximum": "<=", "exclusiveMaximum": "<"}
        limit = f"{sign[error.validator]} {error.validator_value}"
        return f"{key}: {_shown(value)} is out of range; allowed: {limit}{meaning}"
    if error.validator == "oneOf":
        allowed = _alternatives(error.validator_value)
        return f"{key}: {_shown(value)} is not allowed; {allowed}{meaning}"
    return f"{key}: {_shown(value)} is not allowed: {_cut(error.message)}{meaning}"


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
    return _cut(next(iter(str(problem).splitlines()), type(problem).__name__))
