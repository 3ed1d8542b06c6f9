"""Forces between pairs from tables, as from coarse-graining, beside the soft repulsion.

A cubic spline goes through the force, and the energy is its integral. Both are kept on a grid of
`CELLS` cells from 0 to the end of the table: within each the force is the polynomial of third order
that has the values and the slopes of the spline at both ends.
"""

import csv
from pathlib import Path
from typing import Annotated, Any, Self

import numpy as np
from pydantic import Field, ValidationError

from dpd.errors import UserError, reason
from dpd.page import OneOr, PairForce, PairTable, Refusals, Section, setting

CELLS = 1000
LEAST_ROWS = 5
NEAR = 0.1  # r_c, up to which a table must reach down; nearer the force goes on as a straight line
ALIKE = 0.01  # relative difference of energy and integral of the force: coarse, rounded tables
ENDS = 1e-3  # of the largest value: what may be left at the end
APART = 1e-6  # r_c between rows, at least
Sane = Annotated[float, Field(ge=-1e9, le=1e9)]


class Table(Section):
    """Columns of a file, as results have them."""

    r: list[float] = setting("Distances.", unit="r_c", min_length=LEAST_ROWS)
    energy: list[Sane] = setting("Energies.", unit="kT")
    force: list[Sane] = setting("Forces.", unit="kT / r_c")

    def conflicts(self) -> Refusals:
        """Where rows lie, how they end, and whether the energy is the integral of the force."""
        from scipy.interpolate import CubicSpline

        r, energy, force = map(np.array, (self.r, self.energy, self.force))
        if not len(r) == len(energy) == len(force):
            yield "", f"{len(r)}, {len(energy)} and {len(force)} numbers; let columns be as long"
            return
        rows = ~(np.diff(r) >= APART)
        if rows.any():
            last, here = r[np.argmax(rows) :][:2]
            yield "r", f"{here:g} is not above that before, {last:g}; let r ascend by {APART:g}"
            return
        if not 0 <= r[0] <= NEAR or r[-1] > 1:
            yield "r", f"from {r[0]:g} to {r[-1]:g}; allowed: from 0 to {NEAR:g} up to at most 1"
            return
        for name, column in (("energy", energy), ("force", force)):
            if abs(column[-1]) > ENDS * abs(column).max():
                text = f"{column[-1]:g} where the force ends; allowed: 0. Shift the energy, or let "
                yield name, f"{text}the table go on to where both vanish"
        work = CubicSpline(r, force).antiderivative()(r)
        off = abs(work[-1] - work - energy)
        far = off > ALIKE * np.maximum(abs(energy), 0.1 * abs(energy).max())
        for row in far.nonzero()[0][-1:]:
            text = f"{energy[row]:.6g} at r = {r[row]:g}, and the integral of the force to the end "
            text += f"is {work[-1] - work[row]:.6g}; the force must be minus its slope"
            yield "energy", text


class TabulatedForces(PairForce, key="pair"):
    """Forces from tables, beside the repulsion, as {A B: force.csv}; others feel the repulsion.

    A CSV file with the columns r, energy and force, r from near 0 to where the force ends, at most
    1. Its path counts from the file of the scene, and its content is part of the scene.
    """

    bare = "files"
    usual = ""
    caption = "forces from tables"
    files: PairTable[OneOr[Annotated[str, Field(min_length=1)], Table]] = setting(
        "A file for each pair of species."
    )

    def conflicts(self) -> Refusals:
        for pair, table in self.files.items():
            for place, problem in table.conflicts() if isinstance(table, Table) else ():
                yield f"{pair}.{place}".rstrip("."), problem

    def found(self, folder: str | Path, where: str) -> Self:
        """With the columns of the files."""
        found = {
            pair: read_table(Path(folder, table), f"{where}: pair.{pair}")
            if isinstance(table, str) else table
            for pair, table in self.files.items()
        }  # fmt: skip
        return self.model_copy(update={"files": found})

    def numbers(self, scene: Any) -> dict[str, Any]:
        """Number and end of the table of each pair of species, 0 for none, and all tables."""
        number, tables = np.zeros((len(scene.species),) * 2, np.int64), [np.zeros((CELLS, 5))]
        ends, files = [1.0], dict[str, Any](self.files)
        for pair, table in files.items():
            i, j = (scene.species.index(name) for name in pair.split())
            number[i, j] = number[j, i] = len(tables)
            tables.append(on_grid(table))
            ends.append(table.r[-1])
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
    """(`CELLS`, 5) array: energy where each cell begins, and four coefficients of its force."""
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


def read_table(path: Path, where: str) -> Table:
    """The table of a CSV file; a UserError says what is wrong with it."""
    where = f"{where}: {path}"
    try:
        lines = csv.DictReader(path.read_text().splitlines(), skipinitialspace=True)
        rows = [{name: float(line[name]) for name in Table.model_fields} for line in lines]
        table = Table(**{name: [row[name] for row in rows] for name in Table.model_fields})
    except (OSError, UnicodeDecodeError) as problem:
        raise UserError(f"{where}: cannot be read ({reason(problem)})") from None
    except ValidationError as problem:
        first = problem.errors()[0]
        raise UserError(f"{where}: {first['loc'][0]}: {first['msg']}") from None
    except (KeyError, TypeError, ValueError, csv.Error) as problem:
        raise UserError(
            f"{where}: row {lines.line_num}: {problem}; needed are numbers in the columns "
            f"{', '.join(Table.model_fields)}, named in the first row"
        ) from None
    for name, wrong in table.conflicts():
        raise UserError(f"{where}: {name}: {wrong}")
    return table
