"""Polymerization: a melt of linear chains in two dimensions in which no two bonds cross.

Free monomers move by the scene's own dynamics while active ends take them up (Liu et al.
2008, Sec. II C). A fresh bond is long, and others can slip under it before it has shrunk:
bonds are looked at after each interval of dynamics, and of two that cross the younger is
undone with all that grew after it. In two dimensions free monomers get walled in, so
there are spare monomers and spare chains; what is left of them is removed at the end.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import product
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from dpd.engine.loop import advance_looking
from dpd.engine.queries.bonds import crossing_bonds
from dpd.engine.simulation import Simulation
from dpd.engine.space import edges_of, nearest
from dpd.engine.state import State
from dpd.errors import UserError
from dpd.scene.molecules import numbers_of
from dpd.start import start_description
from dpd.start.common.growth import CROSSED, FAR, FREE, MADE, TRIED, Chains, Rule, grow
from dpd.start.common.make import relaxed, start_system, thermal_velocities
from dpd.start.polymerize import RECORD

if TYPE_CHECKING:
    from collections.abc import Callable

    from dpd.engine.state import System
    from dpd.scene.scene import Scene
    from dpd.start.polymerize import Polymerize

SETTLE = 1.0  # tau: monomers before they react, and finished chains before spares are removed
STALL = 40.0  # tau without a new most of bonded beads after which growth has failed
SMALLEST_CELL = 0.5  # r_c; smaller cells only cost memory
LOOK = 0.2  # tau between looks for crossings while the melt relaxes


class Grown(NamedTuple):
    """Bonds: their (n, 2) members, and the chain of each and its place there."""

    members: np.ndarray
    chain: np.ndarray
    place: np.ndarray


class Growth:
    """Chains that are growing, and the monomers that they grow from.

    Parameters
    ----------
    scene : Scene
        Its molecules are what is wanted.
    spare, initiators : float
        Monomers beyond those needed over those needed; growing chains over chains wanted.
    """

    def __init__(
        self, scene: Scene, spare: float, initiators: float, rng: np.random.Generator
    ) -> None:
        kinds = scene.molecules
        grown = [k.count if len(k.beads) == 1 else round(k.count * initiators) for k in kinds]
        longest = max(len(k.beads) for k in kinds)
        self.asked = np.array([k.count for k in kinds])
        self.kind = np.repeat(np.arange(len(kinds)), grown)
        self.full = np.array([len(k.beads) for k in kinds])[self.kind]
        self.wanted = np.full((len(self.kind), longest), -1)
        for number, k in enumerate(kinds):
            row = [scene.species.index(name) for name in k.beads]
            self.wanted[self.kind == number, : len(row)] = row
        self._laws = _laws_of_pairs(scene)
        needed = sum(
            k.count * np.bincount(
                [scene.species.index(name) for name in k.beads], minlength=len(scene.species)
            )
            for k in kinds
        )  # fmt: skip
        stock = np.ceil(needed * (1 + spare)).astype(int)
        self.species = np.repeat(np.arange(len(stock)), stock).astype(np.uint8)
        self.target = int(needed.sum())  # type: ignore[union-attr]  # some molecule is there
        self.chain = np.full(len(self.species), FREE)
        self.beads = np.zeros_like(self.wanted)
        self.born = np.zeros_like(self.wanted)
        self.length = np.ones(len(self.kind), np.int64)
        for c in range(len(self.kind)):
            free = (self.chain == FREE) & (self.species == self.wanted[c, 0])
            if not free.any():
                raise UserError(
                    f"{scene.where}: start.polymerize: no monomer of species "
                    f"{scene.species[self.wanted[c, 0]]!r} is left for an initiator; raise "
                    f"spare (now {spare:g}) or lower initiators (now {initiators:g})"
                )
            first = rng.choice(np.flatnonzero(free))
            self.beads[c, 0], self.chain[first] = first, c

    def bonds(self) -> Grown:
        """The bonds that there are now."""
        places = np.arange(self.beads.shape[1] - 1)
        chain, place = np.nonzero(places < self.length[:, None] - 1)
        members = np.stack([self.beads[chain, place], self.beads[chain, place + 1]], axis=1)
        return Grown(members.astype(np.uint32), chain, place)

    def with_laws(self, bond: Any, members: np.ndarray) -> Any:
        """The law of bonds, or the table with the law of each of these."""
        if bond.number is None:
            return bond
        one, other = self.species[members].T
        return bond._replace(number=self._laws[one, other])

    def grow(
        self, position: np.ndarray, box: tuple[float, ...], radius: float, nearest: bool, now: int,
        rng: np.random.Generator,
    ) -> np.ndarray:  # fmt: skip
        """Let each active end try once; return the counts of `dpd.start.common.growth.grow`."""
        active = rng.permutation(np.flatnonzero(self.length < self.full))
        before = self.length.copy()
        shape = _cells(position, self.bonds().members, box, radius)
        rule = Rule(radius, nearest, self.species, self.wanted)
        chains = Chains(self.chain, self.beads, self.length)
        counts = grow(position, edges_of(box), shape, rule, chains, active, rng)
        taken = np.flatnonzero(self.length > before)
        self.born[taken, before[taken]] = now
        return counts

    def undo_crossed(self, position: np.ndarray, box: tuple[float, ...]) -> int:
        """Cut chains back until no two bonds cross; return the number of bonds undone."""
        undone = 0
        while True:
            members, chain, place = self.bonds()
            pairs = crossing_bonds(position, members, box)
            if pairs.shape[1] == 0:
                return undone
            one, other = (int(b) for b in pairs[:, 0])
            ages = [self.born[chain[b], place[b] + 1] for b in (one, other)]
            youngest = one if ages[0] > ages[1] else other
            c, keep = chain[youngest], place[youngest] + 1
            self.chain[self.beads[c, keep : self.length[c]]] = FREE
            undone += self.length[c] - keep
            self.length[c] = keep

    def mixed(self, state: State, system: System, share: float, rng: np.random.Generator) -> State:
        """The state with a share of the free monomers put to random places."""
        free = self.chain[state.identity] == FREE
        move = free & (rng.random(len(free)) < share)
        position = state.position.copy()
        position[:, move] = _random_places(system, int(move.sum()), rng)
        return replace(state, position=position)

    @property
    def bonded(self) -> int:
        """Beads in chains, up to those wanted."""
        return min(int(self.length.sum()), self.target)

    def finished(self) -> np.ndarray:
        """Chains of full length, as many of each kind as asked, or fewer."""
        full = self.length == self.full
        return np.concatenate(
            [np.flatnonzero(full & (self.kind == k))[:n] for k, n in enumerate(self.asked)]
        )


def _laws_of_pairs(scene):
    """(species, species) array of the numbers of the laws of bonds."""
    (bond,) = (term for term in scene.start_terms.values() if term.joins)
    pairs = list(product(scene.species, repeat=2))
    table = numbers_of(bond.laws(scene), pairs).reshape((len(scene.species),) * 2)
    return np.maximum(table, 0).astype(np.uint16)  # pairs without a law are never bonded


def _random_places(system, count, rng):
    """(2, count) array: places anywhere in the box, or between its walls."""
    edges, low = (np.array(each)[:, None] for each in (system.extent, system.origin))
    return rng.random((2, count)) * edges + low


def _cells(position, members, box, radius):
    """Cells for `grow`."""
    apart = nearest(position[:, members[:, 0]] - position[:, members[:, 1]], box)
    longest = np.sqrt((apart**2).sum(axis=0).max()) if len(members) else 0.0
    edge = max(radius, 0.5 * (radius + longest) * (1 + 1e-9), SMALLEST_CELL)
    return tuple(max(1, int(length / edge)) for length in box)


def grown(
    page: Polymerize, scene: Scene, progress: Callable[[int], object] | None
) -> tuple[State, dict[str, np.ndarray]]:
    """Grow the molecules of a scene, and relax them, so that no two bonds cross.

    Returns
    -------
    State
        Exactly the scene's molecules, in their order.
    dict
        One array per name of `RECORD`, one value per round of growth; and ``relax_crossings``,
        pairs of crossing bonds at every look while it relaxed: all 0.

    Raises
    ------
    UserError
        If the chains stop growing before they are complete, or cross while they relax.
    """
    description, settings = start_description(scene), page.polymerize
    seed, kT = description["seed"], description["kT"]
    system = start_system(scene, settings.dt)
    state, record = _polymerized(scene, settings, system, seed, kT, progress)
    if page.relax:
        crossings: list[int] = []

        def look(system, state):
            crossings.append(_crossing(scene, system, state))

        interval = max(1, round(LOOK / page.relax.dt))
        state = relaxed(scene, state, progress, interval, look)
        record["relax_crossings"] = np.array(crossings)
    # Chains that grow and spare monomers that vanish leave flows across the box, which only
    # viscosity would bring to rest.
    rng = np.random.default_rng([seed, 1])
    mass = system.mass_of(state.species)
    state.velocity = thermal_velocities(state.position.shape, kT, rng, mass)
    return state, record


def _crossing(scene, system, state):
    """Pairs of bonds that cross, of which there are none."""
    place = state.by_identity(state.position)
    try:
        crossings = crossing_bonds(place, system.members, system.box).shape[1]
    except UserError as problem:
        raise UserError(f"{scene.where}: start.relax: {problem}") from None
    if crossings:
        raise UserError(
            f"{scene.where}: start.relax: {crossings} pairs of bonds crossed after {state.step} "
            "steps: these forces do not keep chains apart. Raise the core force or radius or the "
            "bond stiffness, in the scene or in start.forces"
        )
    return crossings


def _polymerized(scene, settings, system, seed, kT, progress):
    """Molecules grown from free monomers, and the record of each round."""
    rng = np.random.default_rng(seed)
    growth = Growth(scene, settings.spare, settings.initiators, rng)
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

    state = _moved(state, system, growth, settle, look)
    begun, best, last_gain = state.step, 0, state.step
    record = {name: [] for name in RECORD}  # type: dict[str, list[float]]
    sums = np.zeros(4, np.int64)
    undone = 0
    while True:
        state = growth.mixed(state, system, settings.interval / settings.mixing, rng)
        place = state.by_identity(state.position)
        sums += growth.grow(
            place, box, settings.radius, settings.partner == "nearest", state.step, rng
        )
        complete = len(growth.finished()) == growth.asked.sum()
        state = _moved(state, system, growth, settle if complete else interval, look)
        place = state.by_identity(state.position)
        try:
            undone += growth.undo_crossed(place, box)
        except UserError as problem:
            raise UserError(f"{scene.where}: start.polymerize: {problem}") from None
        now = (state.step - begun) * system.dt
        values = (now, growth.bonded / growth.target, sums[TRIED], sums[CROSSED], sums[FAR], undone)
        for name, value in zip(RECORD, values):
            record[name].append(value)
        look()
        if complete and len(growth.finished()) == growth.asked.sum():
            break
        if sums[MADE] - undone > best:
            best, last_gain = sums[MADE] - undone, state.step
        if (state.step - last_gain) * system.dt > STALL:
            _stalled(scene, growth, now, settings, undone)
    return _finished_alone(state, growth, scene), {name: np.array(v) for name, v in record.items()}


def _moved(state, system, growth, steps, look):
    """The state after some steps with the bonds that there are now."""
    members = growth.bonds().members
    grown = replace(system, members=members, bond=growth.with_laws(system.bond, members))
    state = replace(state, force=None, reference=None)
    simulation = Simulation(grown, state)
    advance_looking(simulation, steps, look)
    return simulation.state


def _stalled(scene, growth, now, settings, undone):
    unfinished = int(growth.asked.sum()) - len(growth.finished())
    raise UserError(
        f"{scene.where}: start.polymerize: after {now:.0f} tau no chain grows any more: "
        f"{unfinished} of {growth.asked.sum()} are unfinished, {growth.bonded} of "
        f"{growth.target} beads bonded. Raise start.polymerize.spare (now "
        f"{settings.spare:g}), initiators (now {settings.initiators:g}) or radius (now "
        f"{settings.radius:g}), or ask for shorter chains. Bonds that were crossed and undone: "
        f"{undone}; if that is many, take a larger core or stiffer bonds in start.forces"
    )


def _finished_alone(state, growth, scene):
    """The finished chains alone, numbered in the scene's order."""
    chains = growth.finished()
    keep = np.concatenate([growth.beads[c, : growth.full[c]] for c in chains])
    position, velocity = (
        state.by_identity(part)[:, keep] for part in (state.position, state.velocity)
    )
    species = growth.species[keep] if len(scene.species) > 1 else None
    return State(position, velocity, None, np.arange(len(keep), dtype=np.uint32), species, 0)
