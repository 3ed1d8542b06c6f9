"""The keys of a scene, as they stand in the sources."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from argparse import Namespace

    from dpd.commands.main import Stages

WIDTH = 100  # of a line


def add_to(stages: Stages) -> None:
    """Declare the stages."""
    parser = stages.add("keys", _keys, "say what a scene may say: all sections, or the keys of one")
    parser.add_argument("section", nargs="?", help="such as walls, steps or rdf")
    schema = stages.add(
        "schema", _schema, "print the JSON schema of scenes, by which editors complete keys"
    )  # fmt: skip
    for each in (parser, schema):
        each.add_argument(
            "--page", type=Path, metavar="FILE", action="append", default=[],
            help="a Python file with pages of your own, whose sections are there too",
        )  # fmt: skip


def _own(options):
    """The pages of the files that are named."""
    from dpd.own import load

    found: dict[str, Any] = {}
    for page in options.page:
        found |= load(page.absolute(), "--page")[0]
    return found


def _schema(options: Namespace) -> None:
    import json

    from dpd.report.keys import scene_schema

    print(json.dumps(scene_schema(_own(options)), indent=1))


def _keys(options: Namespace) -> None:
    from textwrap import fill

    from dpd.report.keys import rows_below, scene_rows

    rows = scene_rows(_own(options))
    if options.section is None:
        for row in rows:
            if "." not in row.key.removeprefix("observe[]."):
                print(fill(f"{row.key}: {row.meaning}", WIDTH, subsequent_indent="    "))
        return
    for row in rows_below(rows, options.section):
        allowed = " ".join(filter(None, (row.allowed, row.unit and f"[{row.unit}]")))
        default = f"; {row.default}" if row.default == "required" else ""
        if row.default and not default:
            default = f"; if not given: {row.default}"
        print(f"{row.key}: {allowed}{default}")
        print(fill(row.meaning, WIDTH, initial_indent="    ", subsequent_indent="    "))
