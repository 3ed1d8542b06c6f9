"""Data files of LAMMPS taken apart: a title, a header with counts and the box, and sections.

https://docs.lammps.org/read_data.html. Every number of such a file is read here, in one way.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from dpd.errors import UserError, reason, shown
from dpd.particles.particles import LARGEST_STEP

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from pathlib import Path

WHOLE = r"[+-]?[0-9]{1,15}"  # which a double precision number holds exactly
NUMBER = r"[+-]?(?:[0-9]{1,40}\.?[0-9]{0,40}|\.[0-9]{1,40})(?:[eE](?:\+?[0-9]{1,2}|-[0-9]{1,3}))?"
LARGEST = 1e15  # of a number in the header
KINDS = ("atom", "bond", "angle", "dihedral", "improper")
COUNTS = {
    *(f"{kind}s" for kind in KINDS), *(f"{kind} types" for kind in KINDS),
    *(f"extra {kind} per atom" for kind in (*KINDS[1:], "special")),
    "ellipsoids", "lines", "triangles", "bodies",
}  # fmt: skip
UPRIGHT = {"xlo xhi": 2, "ylo yhi": 2, "zlo zhi": 2, "xy xz yz": 3}  # and how many numbers each has
GENERAL = {"avec": 3, "bvec": 3, "cvec": 3, "abc origin": 3}
HEADER = dict.fromkeys(COUNTS, 1) | UPRIGHT | GENERAL
WHOLES = {"id", "molecule", "type", "ix", "iy", "iz", "flag"}  # columns of whole numbers
SECTION = re.compile(r"[A-Z][A-Za-z0-9]*( [A-Z][A-Za-z0-9]*)*")  # its name
STEP = re.compile(r"timestep = ([0-9]+)")  # in the title, where LAMMPS puts it


class Line(NamedTuple):
    """A line of the file: its number, its text before ``#``, and what stands behind."""

    number: int
    text: str
    comment: str


class Data(NamedTuple):
    """A file taken apart.

    Attributes
    ----------
    header : dict of str to tuple of float
        Numbers by what stands behind them: ``atoms``, ``xlo xhi``, ``bond types`` ...
    sections : dict of str to list of Line
        Bodies by name; the line with the name itself stands first.
    """

    path: Path
    title: str
    header: dict[str, tuple[float, ...]]
    sections: dict[str, list[Line]]

    @property
    def step(self) -> int:
        """Which the title says, otherwise 0; of too many digits, one that is out of range."""
        found = STEP.search(self.title)
        return int(found[1][: len(str(LARGEST_STEP))]) if found else 0

    def count(self, name: str) -> int:
        """A count of the header; 0 if it is not there."""
        return int(self.header.get(name, (0,))[0])

    def refuse(self, line: Line, problem: str) -> None:
        """Say what is wrong with a line."""
        raise UserError(f"{self.path}: line {line.number}: {shown(line.text)} {problem}")

    def labels(self, kind: str) -> dict[str, str]:
        """Numbers of types, as text, by their labels; ``kind`` is ``Atom``, ``Bond`` ..."""
        found = {}
        for line in self.sections.get(f"{kind} Type Labels", [])[1:]:
            words = line.text.split()
            if len(words) != 2 or not self.is_type(words[0], kind) or words[1][0] in "0123456789*":
                self.refuse(
                    line,
                    f"is not a type, from 1 to {self.types(kind)}, and a label, which begins with "
                    "a letter",
                )
            found[words[1]] = words[0]
        return found

    def types(self, kind: str) -> int:
        """How many types there are."""
        return self.count(f"{kind.lower()} types")

    def is_type(self, text: str, kind: str) -> bool:
        """Whether a text is the number of a type."""
        return bool(re.fullmatch(WHOLE, text)) and 1 <= int(text) <= self.types(kind)


def taken_apart(path: Path) -> Data:
    """Header and sections of a file; refused if not whole, or if its header has an unknown line."""
    try:
        content = path.read_bytes()
    except OSError as problem:
        raise UserError(f"{path}: cannot be read ({reason(problem)})") from None
    try:
        text = content.decode()
    except UnicodeDecodeError:
        text = content.decode("latin-1")  # comments and labels of older programs
    title, *rest = text.split("\n")
    data = Data(path, title, {}, {})
    body = None
    for number, whole in enumerate(rest, start=2):
        words, _, comment = whole.partition("#")
        line = Line(number, " ".join(words.split()), comment.strip())
        if not line.text:
            continue
        if SECTION.fullmatch(line.text):
            if line.text in data.sections:
                data.refuse(line, "is there as a section before; keep one")
            body = data.sections[line.text] = [line]
        elif body is not None:
            body.append(line)
        else:
            _read_header(data, line)
    if "atoms" not in data.header or "Atoms" not in data.sections:
        what = "section Atoms" if "atoms" in data.header else "line '<number> atoms' in the header"
        raise UserError(
            f"{path}: not a whole data file of LAMMPS: there is no {what}; write it again with "
            "write_data"
        )
    if rest[-1]:
        raise UserError(
            f"{path}: the last line has no end, so the file may be cut off there; write it again, "
            "or end the line if it is whole"
        )
    return data


def _read_header(data, line):
    words = line.text.split()
    for size in (1, 2, 3):
        name = " ".join(words[size:])
        if HEADER.get(name) == size:
            break
    else:
        data.refuse(
            line,
            "is neither a section nor a line that a header has, such as '3 atoms', '0 5 xlo xhi' "
            "or '0 0 0 xy xz yz'; mend or remove it",
        )
    if name in data.header:
        data.refuse(line, "is there a second time; keep one")
    form, kind = ("[0-9]+", "whole ") if name in COUNTS else (NUMBER, "")
    values = [float(word) if re.fullmatch(form, word) else np.inf for word in words[:size]]
    if max(map(abs, values)) > LARGEST:
        data.refuse(line, f"has not {size} {kind}number(s), up to {LARGEST:g}, before {name!r}")
    data.header[name] = tuple(values)


class Table:
    """A section whose lines are numbers, as many lines as the header says."""

    def __init__(self, data: Data, name: str, count: int) -> None:
        self.data, self.name = data, name
        self.head, *self.lines = data.sections[name]
        if len(self.lines) != count:
            raise UserError(
                f"{data.path}: line {self.head.number}: section {name} has {len(self.lines)} "
                f"lines, and the header says {count}; the file is cut off or damaged, write it "
                "again"
            )

    def width(self) -> int:
        """Columns of the first line; 0 if there is none."""
        return len(self.lines[0].text.split()) if self.lines else 0

    def numbers(self, columns: Sequence[str], labels: Mapping[str, str]) -> np.ndarray:
        """(lines, columns) array; columns in `WHOLES` are whole, labels may stand for types."""
        forms = [WHOLE if name in WHOLES else NUMBER for name in columns]
        good = re.compile(" ".join(forms)).fullmatch
        texts = [line.text for line in self.lines]
        if labels:
            place = columns.index("type")
            rows = (text.split(" ") for text in texts)
            texts = [" ".join(_labelled(row, place, labels)) for row in rows]
        for line, text in zip(self.lines, texts):
            if not good(text):
                self._refuse(line, text.split(" "), forms)
        values = np.array(list(map(float, " ".join(texts).split(" "))) if texts else [])
        return values.reshape(-1, len(columns))

    def _refuse(self, line, words, forms):
        problem = f"has {len(words)} columns, and {len(forms)} are expected"
        if len(words) == len(forms):
            pairs = zip(words, forms)
            word, form = next(pair for pair in pairs if not re.fullmatch(pair[1], pair[0]))
            kind = "whole number of up to 15 digits" if form == WHOLE else "number"
            problem = f"has {shown(word)} where a {kind} is needed"
        self.refuse(line, problem)

    def refuse(self, line: Line, problem: str) -> None:
        self.data.refuse(line, f"in section {self.name} {problem}; mend the line")


def _labelled(words, place, labels):
    """Words of a line with the number in place of a label."""
    return [labels.get(word, word) if k == place else word for k, word in enumerate(words)]
