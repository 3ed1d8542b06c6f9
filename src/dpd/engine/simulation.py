"""A system in motion."""

from collections.abc import Iterable
from dataclasses import replace
from typing import Any

import numpy as np

from dpd.engine.beads import DEPTH, DRAG, across_of, near_buffers, sampled_buffers
from dpd.engine.forces import angles_of, bonds_of, buffers_of, cache_buffers
from dpd.engine.integrate import row_edges, time_ahead, times_of
from dpd.engine.neighbours import CUTOFF, line_buffers, list_buffers, pair_buffers
from dpd.engine.rows import aligned, axes_of, row_width, rows_of
from dpd.engine.space import TURN, cell_buffers, edges_of, grid_of, slide_of, tilted, wrapped
from dpd.engine.state import Beads, State, Sums, System
from dpd.engine.step import OF_CACHED, OF_LINE, OF_LIST, Own, Plan, Shared, Span, advance
from dpd.engine.threads import new_team, started
from dpd.errors import LostRun, UserError

SPARE_ROOM = 2.0  # times what buffers were too small for


class Snapshot:
    """A `System` and its `State`, as observables see them."""

    def __init__(self, system: System, state: State) -> None:
        self.system, self.state = system, state
        self.snapshot: Any = None  # what pages see of this step, if one has looked

    @property
    def box(self) -> tuple[float, ...]:
        """Edges of the box as it is now, in r_c; under shear with images where they are now."""
        system, state = self.system, self.state
        if state.box is not None:
            return state.box
        return tilted(system.box, system.shear, system.dt, state.step, state.slid or 0)

    @property
    def volume(self) -> float:
        """Volume of the box as it is now, in r_c^dimension; between walls that of the fluid."""
        box = self.state.box
        return self.system.volume if box is None else float(np.prod(box))


class Simulation(Snapshot):
    """A `System` and its `State`, advanced by the compiled loop.

    Beads outside the box are put to their image inside. With a force of None, or for a list without
    a reference, the force is evaluated where the beads are. The number of threads does not change a
    bit of the result. A `UserError` refuses more than one with a scheme whose pairs exchange
    momentum one after the other.
    """

    def __init__(self, system: System, state: State, threads: int = 1) -> None:
        super().__init__(system, state)
        self.shares = 1  # processes that share the beads
        if system.shear is not None and state.slid is None:
            state.slid = 0
        if system.shear is not None and state.peculiar is None:
            state.peculiar = np.zeros(state.position.shape[1])
        if system.pressure is not None:
            from dpd.engine.barostat import refuse_box

            state.box = state.box or system.box
            refuse_box(system.pressure, system, state.box, state.step)
        # In rows, whatever they came in: each layout would compile kernels of its own.
        position, further = wrapped(state.position, self.box)
        state.image = state.image + state.by_identity(further)
        state.position = np.ascontiguousarray(position)
        state.velocity = np.ascontiguousarray(state.velocity)
        self._threads = threads
        self._others = started(threads - 1) if threads > 1 else None
        self.go_on_with(system)

    def close(self) -> None:
        """End what else works on it."""

    def go_on_with(self, system: System, anew: bool = False, before: System | None = None) -> None:
        """Go on with a system of the same beads in the same box; if anew, forces come first.

        ``before``: what acted up to this step, if it was another system.
        """
        if system.scheme.exchange is not None and self._threads > 1:
            raise UserError(
                f"{self._threads} threads: in this scheme pairs exchange momentum one after the "
                "other, so it runs on one thread; take gw-vv or dpd-vv, or threads 1"
            )
        if before is not None and before.shear is not None and system.shear is not None:
            # Images slide on from where they are, at another rate.
            step = self.state.step
            old: Any = tilted(system.box, before.shear, before.dt, step)
            new: Any = tilted(system.box, system.shear, system.dt, step)
            further = (int(old.slide.parts) - int(new.slide.parts)) * step
            self.state = replace(self.state, slid=((self.state.slid or 0) + further) % TURN)
        if anew:
            self.state = replace(self.state, force=None, reference=None)
        if before is not None and before.box != system.box:
            from dpd.engine.barostat import scaled_state

            self.state = scaled_state(system, self.state, self.box, system.box)
        self.system = system
        self._spare: Beads | None = None
        self._plan, self._room = _plan_of(system, self.box), np.zeros(3, np.int64)
        self._make_buffers()
        unlisted = system.skin > 0 and self.state.reference is None
        if self.state.force is None or unlisted:
            self.call(0)

    def advance(self, steps: int) -> None:
        """Advance by ``steps`` >= 1 steps; for errors see `sample`."""
        self.sample(steps, ())

    def advance_measured(self, steps: int) -> Sums:
        """The same; sums of the end, with forces, as those of one sample."""
        return self.sample(steps, [self.state.step + steps], measure=True)

    def measure(self) -> Sums:
        """Sums of one sample where the beads are, leaving the state alone."""
        before = self.state
        try:
            return self.call(0, [before.step], measure=True)
        finally:
            self.state = before

    def sample(self, steps: int, samples: Iterable[int], measure: bool = False) -> Sums:
        """Advance by ``steps`` >= 1 steps, and take sums after some, the earliest first.

        Virial and energy, if asked for, come with the forces at the end of the step, or, where a
        scheme has its force in the middle of it, of one more evaluation. The state is as it was
        before the call if the run blows up (`LostRun`), or the box becomes too large or too small
        at constant pressure (`UserError`).
        """
        at, before = np.array(list(samples), np.int64), self.state
        try:
            if self.system.pressure is None:
                return self.sample_in_box(steps, at, measure)
            from dpd.engine.barostat import sample_rescaling

            return sample_rescaling(self, self.system.pressure, steps, at, measure)
        except UserError:
            self.state = before
            raise

    def sample_in_box(self, steps: int, at: np.ndarray, measure: bool) -> Sums:
        if not (measure and self.system.scheme.middle and len(at)):
            return self.call(steps, at, measure)
        end, parts = self.state.step + steps, []
        for step in at.tolist():
            self.call(step - self.state.step)
            parts.append(self.measure())
        if self.state.step < end:
            self.call(end - self.state.step)
        return Sums.joined(parts)

    def call(self, steps: int, samples: Iterable[int] = (), measure: bool = False) -> Sums:
        """Call the compiled loop; once more with larger buffers if they were too small.

        For 0 steps the beads are sorted, and their forces evaluated where they are.
        """
        box, at = self.box, np.array(list(samples), np.int64)
        if self._plan.edges != edges_of(box):
            self._plan = self._plan._replace(**_of_box(box, self._plan.skin))
            self._make_buffers()
        if (slide := slide_of(box)) is not None:
            self._plan.slide.tilt[:] = slide.tilt
        while (sums := self._attempt(steps, at, measure)) is None:
            self._make_buffers()
        return sums

    def _attempt(self, steps, at, measure):
        """The same; None, and more room the next time, if the buffers were too small."""
        system, state, dimension = self.system, self.state, self.system.dimension
        beads = self._copied_beads()
        spare = self._spare or self._copied_beads()
        listed = state.reference is not None and state.reference is self._listed
        self._listed = None
        force = rows_of(state.force) if steps else np.zeros_like(beads.position)
        shared = self._shared_now(len(at))
        span = Span(state.step, steps, listed, at, measure)
        in_spare, lost, short = self._all_threads(beads, spare, force, shared, span)
        beads, self._spare = (spare, beads) if in_spare else (beads, spare)
        if short:
            need = SPARE_ROOM * shared.need.max(axis=0)
            self._room = np.maximum(self._room, need.astype(np.int64))
            return None
        if lost.bead >= 0:
            raise LostRun(
                f"the run blew up: bead {lost.bead} moved {lost.distance:.3g} r_c along an axis in "
                f"one step at step {lost.step} (limit: 1 r_c). dt {system.dt:g} is too large for "
                "this scene: lower integrator.dt, or the friction, repulsion or bond stiffness "
                "that asks for it (Groot and Warren use dt 0.04 with repulsion 25 and gamma 4.5).",
                lost.step,
            )
        if shared.deepest is not None:
            self._refuse_behind(shared.deepest)
        if beads.reference is not None:
            self._listed = axes_of(beads.reference, dimension)
        self.state = replace(
            state,
            position=axes_of(beads.position, dimension),
            velocity=axes_of(beads.velocity, dimension),
            force=axes_of(force, dimension),
            reference=self._listed,
            identity=beads.identity,
            species=beads.species,
            step=state.step + steps,
            image=shared.image.T,
            peculiar=beads.peculiar,
        )
        sampled, q = shared.sampled, shared.sampled.moments.shape[3]
        volume = np.full(len(at), self.volume if len(at) else 0.0)
        sums = Sums(at, volume, sampled.moments[:, :, q, 0], sampled.moments[:, :, :q])
        if not measure:
            return sums
        return sums._replace(virial=sampled.virial, energy=sampled.energy, walls=sampled.walls)

    def _copied_beads(self):
        """Copies, as the loop works in place, and a former state must stay as it was."""
        scheme, state, reference = self.system.scheme, self.state, None
        if self.system.skin > 0:
            reference = rows_of(state.position if state.reference is None else state.reference)
        return Beads(
            position=rows_of(state.position),
            velocity=rows_of(state.velocity),
            predicted=None if scheme.prediction is None else rows_of(state.velocity),
            identity=state.identity.copy(),
            species=None if state.species is None else state.species.copy(),
            peculiar=None if state.peculiar is None else state.peculiar.copy(),
            reference=reference,
        )

    def _make_buffers(self):
        self._listed: np.ndarray | None = None  # the reference of the list that is in them
        self._shared = self._shared_buffers()
        self._own = [self._buffers(self._room) for _ in range(self._threads)]

    def _buffers(self, room):
        plan, dimension = self._plan, self.system.dimension
        forces, phases = plan.forces, len(plan.grid.blocks.phase) - 1
        again, cached = forces.exchange or forces.friction, None
        if plan.scheme.renewal is not None or forces.exchange is not None:
            gamma = np.zeros_like(forces.pair.repulsion)
            if again is not None:
                gamma += again.gamma * (1.0 if again.shares is None else again.shares)
            cached = cache_buffers(dimension, room[OF_CACHED], phases, gamma)
        return Own(
            wrap=row_edges(plan.edges, row_width(dimension)),
            line=line_buffers(plan.grid, room[OF_LINE]),
            pairs=pair_buffers(dimension),
            listed=list_buffers(plan.grid, room[OF_LIST]) if plan.skin > 0 else None,
            cached=cached,
            arms=buffers_of(dimension, plan.bonds, plan.angles),
            others=buffers_of(dimension, plan.angles),
            near=near_buffers(dimension) if forces.walls or forces.langevin else None,
            room=room,
        )

    def _shared_buffers(self):
        """What threads share in a call without samples; the image is yet to be added."""
        plan, dimension, beads = self._plan, self.system.dimension, self.state.identity.size
        batches = 0 if plan.bonds is None else len(plan.bonds.batch) - 1
        tasks = batches + len(plan.grid.blocks.piece) - 1
        renews, walls = plan.scheme.renewal is not None, plan.forces.walls
        virial = np.zeros((tasks, 2, dimension, dimension))
        at_walls = None if walls is None else np.zeros((len(walls.axis), DRAG + dimension))
        return Shared(
            cells=cell_buffers(plan.grid, beads, self._threads),
            slot=None if plan.bonds is None else np.empty(beads, np.uint32),
            density=None if plan.forces.many_body is None else np.empty(beads),
            virial=virial,
            energy=np.zeros((tasks, 2)),
            moved=np.zeros(self._threads),
            lost=np.zeros((self._threads, 2)),
            at_walls=at_walls,
            deepest=None if walls is None else np.zeros((self._threads, 3)),
            image=None,
            excess=aligned((beads, row_width(dimension))) if renews else None,
            sampled=sampled_buffers(0, beads, plan.across, virial, at_walls),
            need=np.zeros((self._threads, self._room.size), np.int64),
        )

    def _shared_now(self, samples):
        """The same for a call that takes so many samples."""
        shared, across, beads = self._shared, self._plan.across, self.state.identity.size
        if shared.at_walls is not None:
            shared.at_walls[:] = shared.deepest[:] = 0.0
        if samples:
            shared.virial[:] = shared.energy[:] = 0.0  # of a call that has failed
            sampled = sampled_buffers(samples, beads, across, shared.virial, shared.at_walls)
            shared = shared._replace(sampled=sampled)
        return shared._replace(image=np.array(self.state.image.T, np.int32, order="C"))

    def _refuse_behind(self, deepest):
        # In a step a bead moves by 1 r_c at most, and half of the gap behind a plane is `reach` and
        # 1 r_c: none can pass the middle of the gap unseen.
        depth, bead, step = deepest[np.argmax(deepest[:, DEPTH])].tolist()
        if depth > (reach := self.system.walls.reach):
            raise LostRun(
                f"bead {bead:.0f} got {depth:.3g} r_c behind a wall at step {step:.0f} (limit: "
                f"{reach:g} r_c, beyond which it might feel beads at the opposite wall). The walls "
                "are too soft for this scene: raise walls.repulsion, or lower integrator.dt if the "
                "run is too hot", int(step),
            )  # fmt: skip

    def _all_threads(self, beads, spare, force, shared, span):
        def take_part(team, own):
            return advance(team, self._plan, beads, spare, force, shared, own, span)

        first, *rest = zip(new_team(self._threads), self._own)
        others = [self._others.submit(take_part, *each) for each in rest]
        found = take_part(*first)
        for other in others:
            other.result()
        return found


def _plan_of(system, box):
    bonds, scheme, forces = bonds_of(system), system.scheme, system.forces
    return Plan(
        **_of_box(box, system.skin),
        forces=forces._replace(bond=None, angle=None),  # they are in what follows
        bonds=bonds,
        angles=angles_of(system, bonds),
        scheme=scheme,
        times=times_of(scheme, system.dt),
        kick_waits=not (scheme.renewal or scheme.middle or forces.exchange),
        dt=system.dt,
        skin=float(system.skin),
        ahead=time_ahead(system),
        seed=np.uint64(system.seed),
        mass=None if system.masses is None else np.asarray(system.masses, float),
        across=across_of(system),
    )


def _of_box(box, skin):
    grid = grid_of(box, CUTOFF + skin)
    return {"edges": edges_of(box), "slide": slide_of(box), "grid": grid}
