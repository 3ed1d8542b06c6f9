"""Polymerization: a melt of linear chains in two dimensions in which no two bonds cross.

Active ends take up free monomers within the reaction radius, by bonds that cross no other (Liu et
al. 2008, Sec. II C). A fresh bond is long, and others can slip under it before it has shrunk: of
two that then cross the younger is undone with all that grew after it. Free monomers get walled in,
so there are spare monomers and spare chains, whose rest is removed at the end.
"""

from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import product
from typing import Any, NamedTuple

import numpy as np

from dpd.engine.crossings import crossing_bonds, segments_meet
from dpd.engine.loop import advance_looking
from dpd.engine.simulation import Simulation
from dpd.engine.space import edges_of, nearest, nearest_image
from dpd.engine.state import State, System
from dpd.errors import UserError
from dpd.jit import inlined, kernel
from dpd.scene.molecules import numbers_of
from dpd.scene.scene import Scene
from dpd.start import start_description
from dpd.start.common.make import relaxed, start_system, thermal_velocities

SETTLE = 1.0  # tau: monomers before they react, and finished chains before spares are removed
STALL = 40.0  # tau without a new most of bonded beads after which growth has failed
SMALLEST_CELL = 0.5  # r_c; smaller cells only cost memory
LOOK = 0.2  # tau between looks for crossings while the melt relaxes
FREE = -1  # of a monomer that belongs to no chain


# --- one round of growth


class BondCells(NamedTuple):
    """Bonds, named by their second beads, in cells of their middles: lists that end with -1."""

    head: np.ndarray  # (columns, rows) int64: the bond that was put last into each cell
    following: np.ndarray  # (n,) int64: the one before it
    first: np.ndarray  # (n,) int64: its other bead


@inlined()
def cell_at(x, y, edges, shape):
    """Column and row of the cell of a point inside the box."""
    a = min(int(x * (shape[0] / edges[0])), shape[0] - 1)
    return a, min(int(y * (shape[1] / edges[1])), shape[1] - 1)


@inlined()
def around(along, cells):
    """First and last offset to the neighbours of a cell, each cell once."""
    if cells >= 3:
        return -1, 2
    return -along, cells - along


@inlined()
def middle_of_bond(first, second, position, edges, shape):
    """The middle of a bond, the way to it from the first bead, and its cell."""
    x, y = position[0, first], position[1, first]
    hx = 0.5 * nearest_image(position[0, second] - x, edges[0])
    hy = 0.5 * nearest_image(position[1, second] - y, edges[1])
    x += hx
    y += hy
    a, c = cell_at(
        x - edges[0] * np.floor(x / edges[0]), y - edges[1] * np.floor(y / edges[1]), edges, shape
    )
    return x, y, hx, hy, a, c


@inlined()
def insert_bond(first, second, position, edges, bonds):
    """Put a bond into the cell of its middle."""
    _, _, _, _, a, c = middle_of_bond(first, second, position, edges, bonds.head.shape)
    bonds.first[second], bonds.following[second] = first, bonds.head[a, c]
    bonds.head[a, c] = second


@inlined()
def crosses_some(end, monomer, position, edges, bonds):
    """Whether a bond between two beads would cross an existing one."""
    shape = bonds.head.shape
    x, y, hx, hy, a, c = middle_of_bond(end, monomer, position, edges, shape)
    low_a, high_a = around(a, shape[0])
    low_c, high_c = around(c, shape[1])
    for i in range(low_a, high_a):
        for j in range(low_c, high_c):
            second = bonds.head[(a + i) % shape[0], (c + j) % shape[1]]
            while second >= 0:
                first = bonds.first[second]
                if first != end and second != end:
                    # The image of the bond that is near is the one whose middle is.
                    u, v, ku, kv, _, _ = middle_of_bond(first, second, position, edges, shape)
                    u, v = nearest_image(u - x, edges[0]), nearest_image(v - y, edges[1])
                    if segments_meet(u, v, hx, hy, ku, kv):
                        return True
                second = bonds.following[second]
    return False


@kernel(allocates=True)
def grow(
    position, edges, shape, radius, in_order, species, wanted, chain, beads, length, active, rng
):
    """Let the ends of active chains try to take up one monomer each; return the bonds made.

    Positions, (2, n), are in the order of identities, inside the box. Its cells, ``shape``, have
    edges of at least the radius, and of half the sum of it and the longest bond. The nearest
    monomer comes first, or any. Arrays along chains: see `Growth`.
    """
    n = position.shape[1]
    head = np.full(shape, -1)
    following = np.empty(n, np.int64)
    for i in range(n):
        if chain[i] == FREE:
            a, c = cell_at(position[0, i], position[1, i], edges, shape)
            following[i] = head[a, c]
            head[a, c] = i
    bonds = BondCells(np.full(shape, -1), np.empty(n, np.int64), np.empty(n, np.int64))
    for c in range(len(length)):
        for k in range(length[c] - 1):
            insert_bond(beads[c, k], beads[c, k + 1], position, edges, bonds)
    made = 0
    near = np.empty(n, np.int64)
    order = np.empty(n)
    for c in active:
        end = beads[c, length[c] - 1]
        x, y = position[0, end], position[1, end]
        a, b = cell_at(x, y, edges, shape)
        low_a, high_a = around(a, shape[0])
        low_b, high_b = around(b, shape[1])
        found = 0
        for i in range(low_a, high_a):
            for j in range(low_b, high_b):
                monomer = head[(a + i) % shape[0], (b + j) % shape[1]]
                while monomer >= 0:
                    if chain[monomer] == FREE and species[monomer] == wanted[c, length[c]]:
                        dx = nearest_image(position[0, monomer] - x, edges[0])
                        dy = nearest_image(position[1, monomer] - y, edges[1])
                        if dx * dx + dy * dy <= radius * radius:
                            near[found] = monomer
                            order[found] = dx * dx + dy * dy if in_order else rng.random()
                            found += 1
                    monomer = following[monomer]
        while found > 0:
            best = np.argmin(order[:found])
            monomer = near[best]
            found -= 1
            near[best], order[best] = near[found], order[found]
            if crosses_some(end, monomer, position, edges, bonds):
                continue
            insert_bond(end, monomer, position, edges, bonds)
            made += 1
            beads[c, length[c]] = monomer
            length[c] += 1
            chain[monomer] = c
            break
    return made


# --- all rounds


class Growth:
    """Chains that are growing, and the monomers that they grow from."""

    def __init__(self, scene: Scene, settings: Any, rng: np.random.Generator) -> None:
        self.scene, self.settings = scene, settings
        spare, initiators = settings.spare, settings.initiators
        kinds, number = scene.molecules, {name: k for k, name in enumerate(scene.species)}
        grown = [k.count if len(k.beads) == 1 else round(k.count * initiators) for k in kinds]
        rows = [[number[name] for name in k.beads] for k in kinds]
        self.asked = np.array([k.count for k in kinds])
        self.kind = np.repeat(np.arange(len(kinds)), grown)
        self.full = np.array([len(row) for row in rows])[self.kind]
        self.wanted = np.full((len(self.kind), max(map(len, rows))), -1)
        for k, row in enumerate(rows):
            self.wanted[self.kind == k, : len(row)] = row
        needed = np.bincount(scene.kinds, minlength=len(number))
        stock = np.ceil(needed * (1 + spare)).astype(int)
        self.species = np.repeat(np.arange(len(stock)), stock).astype(np.uint8)
        self.chain = np.full(len(self.species), FREE)  # of each bead
        self.beads = np.zeros_like(self.wanted)  # identities along chains
        self.born = np.zeros_like(self.wanted)  # steps at which beads came to chains
        self.length = np.ones(len(self.kind), np.int64)
        self.made, self.undone = 0, 0  # bonds
        for c, first in enumerate(self.wanted[:, 0]):
            free = np.flatnonzero((self.chain == FREE) & (self.species == first))
            if not len(free):
                raise UserError(
                    f"{scene.where}: start.polymerize: no monomer of species "
                    f"{scene.species[first]!r} is left for an initiator; raise spare (now "
                    f"{spare:g}) or lower initiators (now {initiators:g})"
                )
            self.beads[c, 0] = rng.choice(free)
            self.chain[self.beads[c, 0]] = c
        # The number of the law of bonds for each pair of species; those without are never bonded.
        (bond,) = (term for term in scene.start_terms.values() if term.joins)
        laws = numbers_of(bond.laws(scene), list(product(scene.species, repeat=2)))
        self._laws = np.maximum(laws, 0).astype(np.uint16).reshape(len(number), -1)

    def bonds(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """(n, 2) uint32 members of the bonds that there are, the chain of each, its place there."""
        places = np.arange(self.beads.shape[1] - 1)
        chain, place = np.nonzero(places < self.length[:, None] - 1)
        members = np.stack([self.beads[chain, place], self.beads[chain, place + 1]], axis=1)
        return members.astype(np.uint32), chain, place

    def moved(self, state: State, system: System, steps: int, look: Callable[[], object]) -> State:
        """The state after some steps with the bonds that there are now."""
        members, bond = self.bonds()[0], system.bond
        if bond.number is not None:  # of a table
            one, other = self.species[members].T
            bond = bond._replace(number=self._laws[one, other])
        state = replace(state, force=None, reference=None)
        simulation = Simulation(replace(system, members=members, bond=bond), state)
        advance_looking(simulation, steps, look)
        return simulation.state

    def grow(
        self, position: np.ndarray, box: tuple[float, ...], now: int, rng: np.random.Generator
    ) -> int:
        """Let each active end try once; return the number of bonds made."""
        active = rng.permutation(np.flatnonzero(self.length < self.full))
        before, members = self.length.copy(), self.bonds()[0]
        apart = nearest(position[:, members[:, 0]] - position[:, members[:, 1]], box)
        longest = np.sqrt((apart**2).sum(axis=0).max(initial=0.0))
        radius, nearest_first = self.settings.radius, self.settings.partner == "nearest"
        edge = max(radius, 0.5 * (radius + longest) * (1 + 1e-9), SMALLEST_CELL)
        shape = tuple(max(1, int(length / edge)) for length in box)
        made = grow(
            position, edges_of(box), shape, radius, nearest_first, self.species, self.wanted,
            self.chain, self.beads, self.length, active, rng,
        )  # fmt: skip
        taken = np.flatnonzero(self.length > before)
        self.born[taken, before[taken]] = now
        return made

    def undo_crossed(self, position: np.ndarray, box: tuple[float, ...]) -> int:
        """Cut chains back until no two bonds cross; return the number of bonds undone."""
        undone = 0
        while True:
            members, chain, place = self.bonds()
            pairs = _crossing(self.scene, "polymerize", position, members, box)
            if pairs.shape[1] == 0:
                return undone
            one, other = pairs[:, 0]
            age = self.born[chain, place + 1]
            youngest = one if age[one] > age[other] else other
            c, length = chain[youngest], place[youngest] + 1
            self.chain[self.beads[c, length : self.length[c]]] = FREE
            undone += self.length[c] - length
            self.length[c] = length

    @property
    def bonded(self) -> int:
        """Beads in chains, up to those wanted."""
        return min(int(self.length.sum()), self.scene.beads)

    def finished(self) -> np.ndarray:
        """Chains of full length, as many of each kind as asked, or fewer."""
        full = self.length == self.full
        return np.concatenate(
            [np.flatnonzero(full & (self.kind == k))[:n] for k, n in enumerate(self.asked)]
        )


def _random_places(system, count, rng):
    """(2, count) array: places anywhere in the box, or between its walls."""
    edges, low = (np.array(each)[:, None] for each in (system.extent, system.origin))
    return rng.random((2, count)) * edges + low


def grown(page: Any, scene: Scene, progress: Callable[[int], object] | None) -> State:
    """Molecules, grown and relaxed; `UserError` where growth stalls or bonds cross."""
    description, settings = start_description(scene), page.polymerize
    best, last_gain = 0, SETTLE / settings.dt
    for growth, state in rounds(scene, description["seed"], description["kT"], progress):
        if growth.made - growth.undone > best:
            best, last_gain = growth.made - growth.undone, state.step
        if (state.step - last_gain) * settings.dt > STALL:
            raise UserError(
                f"{scene.where}: start.polymerize: after {state.step * settings.dt - SETTLE:.0f} "
                f"tau no chain grows any more: {growth.bonded} of {scene.beads} beads are in "
                f"chains. Raise start.polymerize.spare (now {settings.spare:g}), initiators (now "
                f"{settings.initiators:g}) or radius (now {settings.radius:g}), or ask for shorter "
                f"chains. {growth.undone} bonds were crossed and undone: if that is many, take a "
                "larger core or stiffer bonds in start.forces"
            )
    # The finished chains alone, numbered in the scene's order.
    taken = np.concatenate([growth.beads[c, : growth.full[c]] for c in growth.finished()])
    place, velocity = (state.by_identity(x)[:, taken] for x in (state.position, state.velocity))
    species = None if state.species is None else state.by_identity(state.species)[taken]
    state = State(place, velocity, None, np.arange(len(taken), dtype=np.uint32), species, 0)
    if page.relax:

        def look(system, state):
            place = state.by_identity(state.position)
            pairs = _crossing(scene, "relax", place, system.members, system.box)
            if crossings := pairs.shape[1]:
                raise UserError(
                    f"{scene.where}: start.relax: {crossings} pairs of bonds crossed after "
                    f"{state.step} steps: these forces do not keep chains apart. Raise the core "
                    "force or radius or the bond stiffness, in the scene or in start.forces"
                )

        state = relaxed(scene, state, progress, max(1, round(LOOK / page.relax.dt)), look)
    # Chains that grow and spare monomers that vanish leave flows across the box, which only
    # viscosity would bring to rest.
    rng = np.random.default_rng([description["seed"], 1])
    mass = start_system(scene, settings.dt).mass_of(state.species)
    state.velocity = thermal_velocities(state.position.shape, description["kT"], rng, mass)
    return state


def _crossing(scene, section, position, members, box):
    """As `crossing_bonds`, which refuses bonds that are too long."""
    try:
        return crossing_bonds(position, members, box)
    except UserError as problem:
        raise UserError(f"{scene.where}: start.{section}: {problem}") from None


def rounds(scene: Scene, seed: int, kT: float, progress: Any) -> Iterator[tuple[Growth, State]]:
    """Let molecules grow from free monomers: what there is after each round, till all are whole."""
    rng, settings = np.random.default_rng(seed), scene.start.polymerize
    system, growth = start_system(scene, settings.dt), Growth(scene, settings, rng)
    n, box = len(growth.chain), system.box
    position = _random_places(system, n, rng)
    species = growth.species if len(scene.species) > 1 else None
    velocity = rng.normal(scale=np.sqrt(kT / system.mass_of(species)), size=position.shape)
    state = State(position, velocity, None, np.arange(n, dtype=np.uint32), species, 0)
    interval = max(1, round(settings.interval / system.dt))
    settle = max(1, round(SETTLE / system.dt))

    def look():
        if progress is not None:
            progress(growth.bonded)

    state = growth.moved(state, system, settle, look)
    complete = False
    while not (complete and len(growth.finished()) == growth.asked.sum()):
        free = growth.chain[state.identity] == FREE
        mixed = free & (rng.random(len(free)) < settings.interval / settings.mixing)
        position = state.position.copy()
        position[:, mixed] = _random_places(system, int(mixed.sum()), rng)
        state = replace(state, position=position)
        growth.made += growth.grow(state.by_identity(state.position), box, state.step, rng)
        complete = len(growth.finished()) == growth.asked.sum()
        state = growth.moved(state, system, settle if complete else interval, look)
        growth.undone += growth.undo_crossed(state.by_identity(state.position), box)
        look()
        yield growth, state
