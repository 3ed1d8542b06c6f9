"""Example scenes to begin with, which the package holds; a paper to begin with, in a clone."""

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
    new.add_argument(
        "--paper", metavar="NAME",
        help="write a paper of your own into this clone instead: a sweep, a figure, a published "
        "number that it is held against, and what to say of that",
    )  # fmt: skip
    add_overwrite(new)


def _new(options: Namespace) -> None:
    from dpd.commands.main import called
    from dpd.digest import PACKAGE
    from dpd.errors import UserError, suggestion
    from dpd.files import check_output

    if options.paper is not None:
        _new_paper(options.paper, options.overwrite)
        return
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
    _write(written, options.overwrite)
    print(f"{path}: {_sentence(text)}")
    print(f"to run it: {called()} run {path} -o {path.stem}.nc")


def _new_paper(name, overwrite):
    """The example paper under another name."""
    from dpd.digest import ROOT
    from dpd.errors import UserError
    from dpd.pipeline.study import check_paper_name

    check_paper_name(name)
    papers, figures = ROOT / "config" / "papers", ROOT / "paper_figures"
    if name == "example":
        raise UserError(f"--paper: {name!r} is what is copied; take another name")
    text = (papers / "example.yaml").read_text()
    text = text[text.index("title:") :].replace("/example/", f"/{name}/")
    written = {papers / f"{name}.yaml": text}
    for path in sorted((figures / "example").iterdir()):
        if path.is_file():
            written[figures / name / path.name] = path.read_text()
    for path in written:
        path.parent.mkdir(exist_ok=True)
    _write(written, overwrite)
    print("\n".join(str(path.relative_to(ROOT)) for path in written))
    print(f"to make it: snakemake --cores 2 --config papers='[{name}]'")


def _write(written, overwrite):
    """Texts by their paths; none where another text is there, unless that is to be replaced."""
    from dpd.files import refuse_to_replace, replace_whole

    new = {path: text for path, text in written.items() if not _holds(path, text)}
    for path in new if not overwrite else ():
        refuse_to_replace(path)
    for path, text in new.items():
        replace_whole(path, partial(Path.write_text, data=text))


def _sentence(text):
    """What an example is: the first line of its comment."""
    return text.splitlines()[0].removeprefix("# ")


def _holds(file, text):
    """Whether a file is there and has just this text, so that it need not be replaced."""
    return file.is_file() and file.read_bytes() == text.encode()
