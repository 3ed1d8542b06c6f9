"""Molecules: the grammar of architectures, which beads they have, and how these are bonded.

`RULES` say how an architecture is written. Branches and groups nest: ``(A (B 2)) 10`` is a comb,
``(A 20)o`` a ring.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import combinations, groupby
from typing import Any, NoReturn

import numpy as np

from dpd.errors import shown

MOST_BEADS = 10**6  # of one molecule
AROUND = 30  # characters that a message shows on either side of a mistake
# A bracket that opens; or a species or a bracket that closes, each with a number behind it or none.
PIECE = re.compile(
    r"(?P<what>\(|(?:\)(?:o(?![^\s()]))?|[A-Za-z][A-Za-z0-9_+-]{0,31}(?![^\s()])))"
    r"(?:(?<!\()\s*(?P<times>[1-9][0-9]{0,6})(?![^\s()]))?\s*"
)
RULES = (
    "write species and repeats as 'A 3 B 9'; behind a bead a branch in brackets, 'A 3 (B 2) A 3'; "
    "groups with their repeats, '(A 2 B) 4', and rings, '(A 20)o'; a species is a letter, then "
    "letters, digits, _, + or -, 32 at most"
)
NOBODY = -1  # instead of the number of a law, where none acts


@dataclass(frozen=True)
class Molecule:
    """A kind of molecule: a tree of beads, bonds that close rings in it, and how many there are."""

    beads: tuple[str, ...]  # the species of each
    parents: tuple[int, ...]  # the bead on which each hangs, of a lower number; -1 for the first
    rings: tuple[tuple[int, int], ...]  # the two beads of each bond more, the lower number first
    count: int
    types: tuple[tuple[tuple[int, ...], str], ...] = ()  # of bonds and angles with laws by name

    @cached_property
    def tree(self) -> np.ndarray:
        """(beads - 1, 2) array: the bead on which each hangs, and that bead, from the second on."""
        return np.array([*enumerate(self.parents)][1:], np.int64).reshape(-1, 2)[:, ::-1]

    @cached_property
    def bonds(self) -> np.ndarray:
        """(bonds, 2) array: the two beads of each, the lower number first; those of rings last."""
        return np.concatenate([self.tree, np.array(self.rings, np.int64).reshape(-1, 2)])

    @cached_property
    def is_chain(self) -> bool:
        """Whether each bead hangs on the one numbered before it."""
        return self.parents == tuple(range(-1, len(self.beads) - 1))

    @cached_property
    def ends(self) -> np.ndarray:
        """(ends,) array: beads with one bond, none in a ring; the bead itself for a single one."""
        times = np.bincount(self.bonds.ravel(), minlength=len(self.beads))
        return np.flatnonzero(times <= 1)

    @property
    def is_linear(self) -> bool:
        """Whether it has no branches and no rings: two ends, or one for a single bead."""
        return len(self.ends) <= 2 and not self.rings

    @cached_property
    def neighbours(self) -> list[list[int]]:
        """For each bead the beads that it is bonded to, by increasing number."""
        found: list[list[int]] = [[] for _ in self.beads]
        for one, other in self.bonds.tolist():
            found[one].append(other)
            found[other].append(one)
        return found

    @cached_property
    def triples(self) -> np.ndarray:
        """(n, 3) array of all i, j, k in which i and k are bonded to j; i is less than k."""
        found = [
            (i, j, k)
            for j, around in enumerate(self.neighbours)
            for i, k in combinations(around, 2)
        ]
        return np.array(found, np.int64).reshape(-1, 3)

    def along(self, size: int) -> np.ndarray:
        """Its bonds, of 2 beads, or its triples, of 3."""
        return self.bonds if size == 2 else self.triples

    def species_along(self, size: int) -> list[tuple[str, ...]]:
        """What laws name them by: species of their beads, or, once for each bead, their type."""
        types, found = dict(self.types), []
        for beads in self.along(size).tolist():
            name = types.get(either_way(beads)) if types else None
            found.append(tuple(name or self.beads[bead] for bead in beads))
        return found

    @cached_property
    def middle(self) -> tuple[int, int]:
        """The two beads in the middle of any longest way through it; one is there twice."""
        way = [0]
        for _ in range(2):  # the bead farthest from any, and the way from there to the farthest
            before, order = {way[0]: -1}, way[:1]
            for one in order:  # which grows
                for other in self.neighbours[one]:
                    if other not in before:
                        before[other] = one
                        order.append(other)
            way = order[-1:]
            while before[way[-1]] >= 0:
                way.append(before[way[-1]])
        inner = sorted((way[len(way) // 2], way[(len(way) - 1) // 2]))
        return inner[0], inner[1]

    def summed(self, steps: np.ndarray) -> np.ndarray:
        """Places of beads, from the step to each from its parent: (..., beads) arrays."""
        if self.is_chain:
            return steps.cumsum(axis=-1)
        # Each round adds the steps of as many forebears again as have been added before.
        nobody = len(self.beads)
        place = np.concatenate([steps, np.zeros_like(steps[..., :1])], axis=-1)
        forebear = np.array([nobody, *self.parents[1:], nobody])
        while (forebear < nobody).any():
            place = place + place[..., forebear]
            forebear = forebear[forebear]
        return place[..., :nobody]


def either_way(beads: Sequence[int]) -> tuple[int, ...]:
    """Beads of a bond or an angle, from the end with the lower number."""
    return min(tuple(beads), tuple(beads[::-1]))


Joined = tuple[np.ndarray, np.ndarray | None]


def joined(molecules: Sequence[Molecule], laws: Mapping[str, Any], size: int) -> Joined:
    """What laws of bonds, ``size`` 2, or of angles, 3, join in all molecules.

    Laws stand by the species that they join, read from either end; one for all by no name. Result:
    (n, size) numbers of beads, and (n,) numbers of laws, None of one for all.
    """
    members, numbers, first = [np.zeros((0, size), np.int64)], [np.zeros(0, np.int64)], 0
    for kind in molecules:
        inside = kind.along(size)
        number = np.zeros(len(inside), np.int64)
        if "" not in laws:
            number = numbers_of(laws, kind.species_along(size))
            inside, number = inside[number != NOBODY], number[number != NOBODY]
        starts = first + len(kind.beads) * np.arange(kind.count)
        members.append((starts[:, None, None] + inside).reshape(-1, size))
        numbers.append(np.tile(number, kind.count))
        first += len(kind.beads) * kind.count
    law = None if "" in laws else np.concatenate(numbers).astype(np.uint16)
    return np.concatenate(members).astype(np.uint32), law


def numbers_of(table: Mapping[str, Any], names: Sequence[tuple[str, ...]]) -> np.ndarray:
    """The number of the law for each pair or triple of species; `NOBODY` where there is none."""
    number = {tuple(key.split()): place for place, key in enumerate(table)}
    found = [number.get(each, number.get(each[::-1], NOBODY)) for each in names]
    return np.array(found, np.int64)


@lru_cache(maxsize=64)
def graph_of(
    architecture: str,
) -> tuple[tuple[str, ...], tuple[int, ...], tuple[tuple[int, int], ...]]:
    """Beads, parents and rings of a `Molecule`; a `ValueError` marks where it cannot be read."""

    def refuse(start: int, problem: str) -> NoReturn:
        mistake = re.findall(r"[()]|[^\s()]*", architecture[start:])[0]
        before, behind = architecture[max(0, start - AROUND) : start], start + len(mistake)
        around = f"{before}>>>{mistake[:AROUND]}<<<{architecture[behind : behind + AROUND]}"
        raise ValueError(f"{shown(around, str)}: {problem}; {RULES}")

    beads: list[str] = []
    parents: list[int] = []
    rings: list[tuple[int, int]] = []
    opened: list[tuple[int, int, int]] = []  # where a bracket is, its first bead, the one before
    last, place = -1, len(architecture) - len(architecture.lstrip())
    while place < len(architecture):
        piece = PIECE.match(architecture, place)
        if piece is None:
            refuse(place, "neither a bracket nor a species, with a number behind it or without one")
        what, times, start, place = piece["what"], piece["times"], place, piece.end()
        if what == "(":
            opened.append((start, len(beads), last))
            continue
        first, before, ring = len(beads), last, what == ")o"
        if what[0] != ")":
            beads.append(what)
            parents.append(last)
            last = first
        else:
            if not opened:
                refuse(start, "no bracket is open that this one could close")
            start, first, before = opened.pop()
            if first == len(beads):
                refuse(start, "the bracket is empty")
            if times is None and not ring and first == (opened[-1][1] if opened else 0):
                refuse(start, "there is no bead before this branch that it could hang on")
            if ring:
                if parents[last] in (-1, before, first):
                    refuse(start, "a ring has three beads or more from its first to its last")
                if (first, last) in rings:
                    refuse(start, "this ring is closed already; keep one o")
                rings.append((first, last))
        size, copies = len(beads) - first, int(times or 1) - 1
        if len(beads) + size * copies > MOST_BEADS:
            refuse(start, f"more beads than {MOST_BEADS}, which is the most in one molecule")
        inside, closed = parents[first + 1 :], [pair for pair in rings if pair[0] >= first]
        for shift in range(size, size * (copies + 1), size):
            parents += [last, *(parent + shift for parent in inside)]
            last += size
            rings += [(one + shift, other + shift) for one, other in closed]
        beads += beads[first:] * copies
        if what == ")" and times is None:
            last = before
    if opened:
        refuse(opened[-1][0], "this bracket is not closed")
    if not beads:
        refuse(0, "there are no beads")
    return tuple(beads), tuple(parents), tuple(sorted(rings))


def written(beads: Sequence[str], parents: Sequence[int] | np.ndarray) -> str:
    """The architecture of a tree whose beads are in the order of a walk, deeper first."""
    words: list[str] = []
    last, after = np.full(len(beads), -1), np.arange(1, len(beads) + 1)  # ends of branches
    for bead in range(len(beads) - 1, 0, -1):
        parent = parents[bead]
        after[parent] = max(after[parent], after[bead])
        last[parent] = max(last[parent], bead)
    ends: list[int] = []  # where branches end that have begun
    for bead, (name, parent) in enumerate(zip(beads, parents)):
        while ends and ends[-1] == bead:
            words.append(")")
            ends.pop()
        if parent >= 0 and last[parent] != bead:
            words.append("(")
            ends.append(after[bead])
        words.append(name)
    words += [")"] * len(ends)
    runs = ((name, len(list(each))) for name, each in groupby(words))
    return " ".join(
        " ".join([name] * number if name in "()" else [name, str(number)][: 1 + (number > 1)])
        for name, number in runs
    )  # fmt: skip


def of_each_length(kind: dict[str, Any], volume: float) -> list[dict[str, Any]]:
    """Kinds of molecules of each length in brackets, as in ``A [8, 12, 20]``: whole molecules.

    Their numbers are as near to the weights as they can be (largest remainders).
    """
    found = re.search(r"\[([\d\s,]+)\]", kind["architecture"])
    if found is None:
        return [kind]
    lengths = [int(length) for length in found[1].split(",")]
    texts = [kind["architecture"].replace(found[0], str(length)) for length in lengths]
    share = np.array(kind.get("weights") or [1] * len(lengths), float)
    if len(share) != len(lengths) or not (share > 0).all():
        return [kind | {"architecture": texts[0]}]  # of which the weights are refused
    share /= share.sum()
    mean = share @ [len(graph_of(text)[0]) for text in texts]
    wanted = share * (kind.get("count") or round(kind["density"] * volume / mean))
    counts = wanted.astype(int)
    counts[np.argsort(counts - wanted, kind="stable")[: round(wanted.sum()) - counts.sum()]] += 1
    rest = {key: value for key, value in kind.items() if key not in ("density", "weights")}
    return [
        rest | {"architecture": text, "count": int(count)}
        for text, count in zip(texts, counts) if count
    ]  # fmt: skip
