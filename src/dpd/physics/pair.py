"""Forces between pairs from tables, as from coarse-graining, beside the soft repulsion.

A file has the columns r, energy and force, with force = -d energy / d r. A cubic spline goes
through the force, and the energy is its integral. Both are kept on a grid of `CELLS` cells from 0
to the end of the table: within each the force is the polynomial of third order that has the values
and the slopes of the spline at both ends.
"""

from __future__ import annotations

import csv
import hashlib
import os
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

from pydantic import Field, Tag

from dpd.errors import UserError, reason, shown
from dpd.page import OR_TABLE, PairForce, PairTable, Refusals, Section, check_table, setting

if TYPE_CHECKING:
    from pathlib import Path
    from typing import Self

    import numpy as np

CELLS = 1000
COLUMNS = ("r", "energy", "force")
LEAST_ROWS = 5
NEAR = 0.1  # r_c, up to which a table must reach down; nearer the force goes on as a straight line
ALIKE = 0.01  # relative difference of force and slope of the energy: coarse and rounded tables
ENDS = 1e-3  # of the largest value: what may be left at the end


class TableFile(Section):
    """A file as results name it."""

    path: str = setting("Where it lies.", min_length=1)
    sha256: str = setting("The digest that its content must have.", pattern=r"^[0-9a-f]{64}$")


class Table(NamedTuple):
    """Arrays of a file, and the digest of its content."""

    r: np.ndarray
    energy: np.ndarray
    force: np.ndarray
    sha256: str


class TabulatedForces(PairForce, key="pair"):
    """Forces from tables, beside the repulsion, as {A B: force.csv}; others feel the repulsion.

    A CSV file with the columns r, energy and force, r from near 0 to where the force ends, at most
    1. Its path counts from the file of the scene, and its content is part of the scene.
    """

    bare = "files"
    files: PairTable[
        Annotated[
            Annotated[str, Field(min_length=1), Tag("=one")] | Annotated[TableFile, Tag("=table")],
            OR_TABLE,
        ]
    ] = setting("A file for each pair of species.")

    def found(self, folder: str | Path, where: str) -> Self:
        """With whole paths and digests of the files; one with a digest is read when it acts."""
        found = {}
        for pair, file in self.files.items():
            if isinstance(file, str):
                path = os.path.abspath(os.path.join(folder, file))
                table = read_table(path, f"{where}: pair.{pair}")
                file = TableFile(path=path, sha256=table.sha256)
            found[pair] = file
        return self.model_copy(update={"files": found})

    def content(self) -> Any:
        return {pair: file["sha256"] for pair, file in self.plain().items()}

    def unknown(self, scene: Any) -> Refusals:
        yield from check_table(self.files, scene, scene.pairs, "")

    def numbers(self, scene: Any) -> dict[str, Any]:
        """Number and end of the table of each pair of species, 0 for none, and all tables."""
        import numpy as np

        number, tables = np.zeros((len(scene.species),) * 2, np.int64), [np.zeros((CELLS, 5))]
        ends, files = [1.0], dict[str, Any](self.files)
        for pair, file in files.items():
            where = f"{scene.where}: pair.{pair}"
            table = read_table(file.path, where)
            if table.sha256 != file.sha256:
                raise UserError(
                    f"{where}: {file.path}: is not the file that this was made with: its digest "
                    f"is {table.sha256}, and not {file.sha256}"
                )
            i, j = (scene.species.index(name) for name in pair.split())
            number[i, j] = number[j, i] = len(tables)
            tables.append(on_grid(table))
            ends.append(float(table.r[-1]))
        of_pair = number.ravel()
        return {"table": of_pair, "end": np.array(ends)[of_pair], "coefficients": np.array(tables)}

    def force(self: Any, r: float, w: float) -> float:
        table, c, place = self.table, self.coefficients, r / self.end * CELLS
        cell = min(int(place), CELLS - 1)
        t, inside = place - cell, 1.0 if r < self.end else 0.0
        slope = c[table, cell, 2] + t * (c[table, cell, 3] + t * c[table, cell, 4])
        return inside * (c[table, cell, 1] + t * slope)

    def energy(self: Any, r: float, w: float) -> float:
        """The integral of the force from here to the end."""
        table, c, place = self.table, self.coefficients, r / self.end * CELLS
        cell = min(int(place), CELLS - 1)
        t, inside = place - cell, 1.0 if r < self.end else 0.0
        rest = c[table, cell, 2] / 2 + t * (c[table, cell, 3] / 3 + t * c[table, cell, 4] / 4)
        return inside * (c[table, cell, 0] - t * (c[table, cell, 1] + t * rest) * self.end / CELLS)


def on_grid(table: Table) -> np.ndarray:
    """(`CELLS`, 5) array: energy where each cell begins, and four coefficients of its force.

    Nearer than the first row the force goes on along a straight line.
    """
    import numpy as np
    from scipy.interpolate import CubicSpline

    spline, end = CubicSpline(table.r, table.force), table.r[-1]
    r = np.linspace(0.0, end, CELLS + 1)
    inside = np.maximum(r, table.r[0])
    force, slope = spline(inside) + (r - inside) * spline(inside, 1), spline(inside, 1)
    slope *= end / CELLS
    a, b, rise = slope[:-1], slope[1:], np.diff(force)
    c = np.stack([force[:-1], a, 3 * rise - 2 * a - b, a + b - 2 * rise], axis=1)
    work = c @ (1 / np.arange(1, 5)) * end / CELLS
    energy = np.cumsum(work[::-1])[::-1]
    return np.concatenate([energy[:, None], c], axis=1)


def read_table(path: str, where: str) -> Table:
    """A table of a CSV file; a UserError says what is wrong, with file, row and column.

    Refused is what is no table of numbers, does not reach from near 0 to where the force ends, or
    has a force that is not minus the slope of the energy.
    """
    import numpy as np

    where = f"{where}: {path}"
    try:
        with open(path, "rb") as file:
            content = file.read()
        lines = enumerate(csv.reader(content.decode().splitlines()), 1)
        rows = [(n, [cell.strip() for cell in row]) for n, row in lines if row]
    except (OSError, UnicodeDecodeError, csv.Error) as problem:
        raise UserError(f"{where}: cannot be read ({reason(problem)})") from None
    header = rows[0][1] if rows else []
    if sorted(header) != sorted(COLUMNS):
        named = f"{shown(', '.join(header), str)}" if header else "nothing"
        raise UserError(f"{where}: row 1: {named} instead of the columns {', '.join(COLUMNS)}")
    values = []
    for n, row in rows[1:]:
        given = dict(zip(header, row))
        values.append([_number(given.get(name, ""), name, n, where) for name in COLUMNS])
    if len(values) < LEAST_ROWS:
        raise UserError(f"{where}: {len(values)} rows of numbers; allowed: >= {LEAST_ROWS}")
    r, energy, force = np.array(values).T
    table = Table(r, energy, force, hashlib.sha256(content).hexdigest())
    for place, column, text in _problems(table):
        raise UserError(f"{where}: row {rows[1:][place][0]}, column {column}: {text}")
    return table


def _number(text, name, n, where):
    try:
        value = float(text)
    except ValueError:
        value = float("nan")
    if not abs(value) < 1e100:
        raise UserError(f"{where}: row {n}, column {name}: {shown(text)} is not a number")
    return value


def _problems(table):
    """Where rows lie, how they end, and whether their force is minus the slope of their energy."""
    import numpy as np
    from scipy.interpolate import CubicSpline

    r, energy, force = table.r, table.energy, table.force
    for place, here in enumerate(r):
        if not 0 <= here <= 1:
            yield place, "r", f"{here:g}; allowed: from 0 to 1"
        if place and here <= r[place - 1]:
            yield place, "r", f"{here:g} is not above that before, {r[place - 1]:g}; let r ascend"
    if r[0] > NEAR:
        yield 0, "r", f"{r[0]:g} is far from 0; allowed: <= {NEAR:g}"
    for name, column in (("energy", energy), ("force", force)):
        if abs(column[-1]) > ENDS * abs(column).max():
            text = f"{column[-1]:g} where the force ends; allowed: 0. Shift the energy, or let the "
            yield -1, name, f"{text}table go on to where both vanish"
    work, fall, h = np.diff(CubicSpline(r, force).antiderivative()(r)), -np.diff(energy), np.diff(r)
    size = h * (abs(force[1:]) + abs(force[:-1]))
    rounding = 1e-12 + 1e-4 * np.maximum(abs(energy[1:]), abs(energy[:-1]))
    allowed = ALIKE * (size + h * abs(force).max() / 10) + rounding
    worst = int(np.argmax(abs(work - fall) / allowed))
    if abs(work - fall)[worst] > allowed[worst]:
        mean, slope = work[worst] / h[worst], fall[worst] / h[worst]
        text = f"since the row before the mean force is {mean:.6g}, and the energy falls by "
        text += f"{slope:.6g} for each r_c; the force must be minus the slope of the energy"
        yield worst + 1, "force", text
