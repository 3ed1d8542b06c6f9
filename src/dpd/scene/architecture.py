"""The grammar of architectures: ``A 3 B 9``, ``A 3 (B 2) A 3``, ``(A 2 B) 4``.

A species with a number is a run of beads. A bracket without a number behind it is a branch, which
hangs on the bead before it. A bracket with a number is a group, repeated along the chain. Both
nest, so ``(A (B 2)) 10`` is a comb. Rings cannot be written.
"""

from __future__ import annotations

import re
from typing import NamedTuple

from dpd.errors import UserError, shown

MOST_BEADS = 10**6  # of one molecule
MOST_NESTED = 50  # brackets in brackets
AROUND = 30  # characters that a message shows on either side of a mistake
NAME = re.compile(r"[A-Za-z][A-Za-z0-9_+-]{0,31}")
WORD = re.compile(r"[()]|[^\s()]+")
RULES = (
    "write species and repeats as 'A 3 B 9'; behind a bead a branch in brackets, 'A 3 (B 2) A 3'; "
    "groups with their repeats, '(A 2 B) 4'; a species is a letter, then letters, digits, _, + or "
    "-, 32 at most; there are no rings"
)


class Word(NamedTuple):
    """A word of an architecture, and where it begins."""

    text: str
    place: int


class Run(NamedTuple):
    """Beads of one species, one after the other."""

    species: str
    times: int


class Bracket(NamedTuple):
    """What stands in brackets: a group that is repeated; a branch if ``times`` is None."""

    parts: list
    times: int | None


class Tree(NamedTuple):
    """The beads of a molecule.

    Attributes
    ----------
    beads : tuple of str
        Species of each.
    parents : tuple of int
        The bead on which each one hangs, always one with a lower number; -1 for the first.
    """

    beads: tuple[str, ...]
    parents: tuple[int, ...]


def tree_of(architecture: str, where: str = "architecture") -> Tree:
    """The molecule that an architecture describes.

    Parameters
    ----------
    architecture : str
        Such as ``A 3 (B 2) A 3``.
    where : str
        File and key to name in messages.

    Raises
    ------
    UserError
        If it cannot be read; with the place marked.
    """
    beads: list[str] = []
    parents: list[int] = []
    _write_out(parts_of(architecture, where), beads, parents, -1)
    return Tree(tuple(beads), tuple(parents))


def length_of(architecture: str, where: str = "architecture") -> int:
    """How many beads an architecture describes, without writing them out.

    Raises
    ------
    UserError
        As `tree_of` has it.
    """
    return _count(parts_of(architecture, where))


def parts_of(architecture: str, where: str) -> list:
    """Runs and brackets of an architecture.

    Parameters
    ----------
    architecture, where : str
        As for `tree_of`.

    Returns
    -------
    list of Run and Bracket

    Raises
    ------
    UserError
        As `tree_of` has it, also for more than `MOST_BEADS` beads.
    """

    def refuse(word, problem):
        raise UserError(f"{where}: {_marked(architecture, word)}: {problem}; {RULES}")

    words = [Word(found[0], found.start()) for found in WORD.finditer(architecture)]
    parts: list = []
    outer: list[tuple[Word, list]] = []  # brackets that are open, and what stands before each
    for number, word in enumerate(words):
        after = words[number + 1] if number + 1 < len(words) else None
        if word.text == "(":
            outer.append((word, parts))
            parts = []
            if len(outer) > MOST_NESTED:
                refuse(word, f"brackets are nested deeper than {MOST_NESTED}")
        elif word.text == ")":
            if not outer:
                refuse(word, "no bracket is open that this one could close")
            opened, inside = outer[-1][0], parts
            if not inside:
                refuse(opened, "the bracket is empty")
            times = _times(after, refuse)
            parts = outer.pop()[1]
            if times is None and not parts:
                refuse(opened, "there is no bead before this branch that it could hang on")
            parts.append(Bracket(inside, times))
        elif NAME.fullmatch(word.text):
            parts.append(Run(word.text, _times(after, refuse) or 1))
        elif not _is_number(word):
            refuse(word, "this is neither a species, nor a number, nor a bracket")
        elif number == 0 or words[number - 1].text == "(" or _is_number(words[number - 1]):
            refuse(word, "a number of repeats stands behind a species or a bracket")
    if outer:
        refuse(outer[-1][0], "this bracket is not closed")
    if not parts:
        refuse(Word("", 0), "there are no beads")
    beads = _count(parts)
    if beads > MOST_BEADS:
        raise UserError(
            f"{where}: {shown(architecture)} is a molecule of {beads:.6g} beads; allowed: <= "
            f"{MOST_BEADS}"
        )
    return parts


def _is_number(word):
    return word is not None and word.text.isascii() and word.text.isdigit()


def _times(word, refuse):
    """The repeats that a word gives; None if it is something else."""
    if not _is_number(word):
        return None
    if len(word.text) > len(str(MOST_BEADS)):
        refuse(word, f"so many repeats are not allowed: <= {MOST_BEADS}")
    if int(word.text) == 0:
        refuse(word, "repeats are at least 1")
    return int(word.text)


def _marked(text, word):
    """The text around a word, which stands between arrows."""
    end = word.place + len(word.text)
    before, behind = text[: word.place], text[end:]
    before = f"...{before[-AROUND:]}" if len(before) > AROUND else before
    behind = f"{behind[:AROUND]}..." if len(behind) > AROUND else behind
    middle = word.text if len(word.text) <= AROUND else f"{word.text[:AROUND]}..."
    return shown(f"{before}>>>{middle}<<<{behind}", str)


def _count(parts):
    """Beads of some parts."""
    return sum(
        part.times if isinstance(part, Run) else (part.times or 1) * _count(part.parts)
        for part in parts
    )


def _write_out(parts, beads, parents, last):
    """Append beads that go on from bead ``last``; return the last one along the chain."""
    for part in parts:
        if isinstance(part, Run):
            first = len(beads)
            beads += [part.species] * part.times
            parents += [last, *range(first, first + part.times - 1)]
            last = len(beads) - 1
        elif part.times is None:
            _write_out(part.parts, beads, parents, last)
        else:
            for _ in range(part.times):
                last = _write_out(part.parts, beads, parents, last)
    return last
