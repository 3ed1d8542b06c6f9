"""Example scenes to begin with, which the package holds."""

from __future__ import annotations

import json
from functools import partial
from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING

from dpd.commands.options import add_overwrite

if TYPE_CHECKING:
    from argparse import Namespace

    from dpd.commands.main import Stages

SCHEMA = "scene.schema.json"
WIDTH = 100  # of a line


def add_to(stages: Stages) -> None:
    """Declare the stage."""
    new = stages.add("new", _new, "write an example scene to begin with, or list all")
    new.add_argument("name", nargs="?", help="of the example; without it all are listed")
    new.add_argument(
        "-o", "--output", type=Path, metavar="FILE", help="where to, if not NAME.yaml here"
    )
    new.add_argument(
        "--schema", action="store_true",
        help=f"write {SCHEMA} beside it too, by which editors with a YAML language server, as VS "
        "Code, complete and check its keys",
    )  # fmt: skip
    add_overwrite(new)


def _new(options: Namespace) -> None:
    from dpd.commands.main import called
    from dpd.digest import PACKAGE
    from dpd.errors import UserError, suggestion
    from dpd.files import check_output, refuse_to_replace, replace_whole

    known = {path.stem: path.read_text() for path in sorted((PACKAGE / "scenes").glob("*.yaml"))}
    if options.name is None:
        for name, text in known.items():
            print(fill(f"{name}: {_sentence(text)}", WIDTH, subsequent_indent="    "))
        return
    if options.name not in known:
        raise UserError(f"new: no example {options.name!r}; {suggestion(options.name, known)}")
    path, text = options.output or Path(f"{options.name}.yaml"), known[options.name]
    written = {path: text}
    if options.schema:
        from dpd.report.keys import scene_schema

        written = {path: f"# yaml-language-server: $schema={SCHEMA}\n{text}"}
        written[path.with_name(SCHEMA)] = json.dumps(scene_schema(), indent=1) + "\n"
    check_output(path, ".yaml")
    new = {file: data for file, data in written.items() if not _holds(file, data)}
    for file in new if not options.overwrite else ():
        refuse_to_replace(file)
    for file, data in new.items():
        replace_whole(file, partial(Path.write_text, data=data))
    print(f"{path}: {_sentence(text)}")
    print(f"to run it: {called()} run {path} -o {path.stem}.nc")


def _sentence(text):
    """What an example is: the first line of its comment."""
    return text.splitlines()[0].removeprefix("# ")


def _holds(file, text):
    """Whether a file is there and has just this text, so that it need not be replaced."""
    return file.is_file() and file.read_bytes() == text.encode()
