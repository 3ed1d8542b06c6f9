"""A system that runs step by step, and is changed and looked at in between."""

import os
import signal
import time
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import xarray as xr

from dpd import files
from dpd.api import as_scene, keyboard_interrupt, load, plain, refuse_more_files, warn
from dpd.engine import simulation as engine
from dpd.engine.loop import arrays_of, counts_from, run
from dpd.errors import LostRun, UserError, suggestion
from dpd.observe.common.bins import ThermalMotion
from dpd.observe.common.measured import EVERY, observables
from dpd.observe.common.snapshot import Snapshot, snapshot_of
from dpd.runs import Progress
from dpd.runs.auto import settle
from dpd.runs.result import go_on_from, write_result
from dpd.runs.run import Options, stop_on, whole
from dpd.scene.scene import Scene, enter
from dpd.start.common.files import begin
from dpd.start.common.make import make_start, system_of

ROOM = 10**6  # steps of sampling of a scene that does not say how many: intervals are shorter


class Simulation:
    """A scene in motion, which is run, looked at, changed, and run on.

    What the scene observes is measured as in `dpd.run`: nothing within ``steps.equilibrate``, and
    then every so many steps. How long it runs, calls of `run` say, and not the scene; a dict needs
    no ``steps.sample``. For arguments and errors see `dpd.run`.

    Examples
    --------
    With ``fluid`` as in `dpd.run`:

    >>> sim = dpd.Simulation(fluid, progress=False)
    >>> sim.run(200)
    >>> sim.positions.shape, sim.step, round(sim.time, 6)
    ((648, 3), 200, 8.0)
    >>> sim.set({"repulsion.A A": 30}, dt=0.02, kT=1.5)
    >>> sim.run(200)
    >>> bool(1.2 < sim.kT < 1.8), round(sim.time, 6)
    (True, 12.0)
    >>> run = sim.result()
    >>> run.kT.size, float(run.time[-1].round(6))
    (30, 8.0)
    >>> sim.save("hotter.nc")  # for dpd.load, dpd.extend and dpd.draw
    """

    def __init__(
        self,
        scene: str | os.PathLike | Mapping[str, Any] | Scene,
        *,
        observe: Sequence[Any] = (),
        pages: Sequence[Any] = (),
        start: str | os.PathLike | None = None,
        threads: int = 1,
        progress: bool | None = None,
    ) -> None:
        endless = False
        if isinstance(scene, Mapping) and isinstance(length := scene.get("steps", {}), Mapping):
            endless = not {"sample"} & {*length, *scene.get("duration", ())}
            scene = {**scene, "steps": {"sample": ROOM, **length}}
        given = as_scene(scene, observe, pages)
        for key, ramp in given.ramps.items():
            if endless and ramp.over == "sample":
                raise UserError(f"{given.where}: {key}: a ramp lasts for 'steps.sample'; add it")
        refuse_more_files(given, "dpd.run(..., output='run.nc')")
        if "engine" in given.data:
            raise UserError(f"{given.where}: engine: only whole runs have another; use dpd.run")
        if start:
            given, state = begin(given, Path(start), None, warn)
        else:
            state = make_start(given, None, warn)
        given = settle(given, state)
        self._progress, self._seconds = partial(Progress, bar=progress), 0.0
        self._equilibrate, self._chosen = given.steps.equilibrate, given.chosen
        self._where, self._stretches = given.where, given.stretches
        self._data = {key: value for key, value in given.data.items() if key != "schedule"}
        pages_looking = self._planned(ROOM).observe.values()
        self._room = max([EVERY, *(page.every for page in pages_looking)])
        self._scene = self._planned(self._room)
        self._systems = [(0, system_of(self._scene))]
        self._schedule: list[dict[str, Any]] = []
        for each in given.data.get("schedule", []):
            self._enter(each["step"], each["set"])
        self._engine = engine.Simulation(self._systems[0][1], state, Options(threads).threads)
        self._observers = self._watching(self._scene)

    @property
    def step(self) -> int:
        """Steps since the beginning."""
        return int(self._engine.state.step)

    @property
    def time(self) -> float:
        """The same in tau."""
        return float(self._scene.tau(self.step))

    @property
    def positions(self) -> np.ndarray:
        """(beads, dimension) array in r_c, within the box, molecule after molecule."""
        return self.snapshot().positions

    @property
    def velocities(self) -> np.ndarray:
        """(beads, dimension) array in r_c / tau."""
        return self.snapshot().velocities

    @property
    def kT(self) -> float:
        """Kinetic temperature now, as ``thermo`` has it."""
        thermal = ThermalMotion(self._scene, self._engine.system)
        kinetic = thermal.kinetic(self._engine.measure())[0]
        return float(np.trace(kinetic)) / (self._scene.dimension * self._scene.beads)

    def snapshot(self) -> Snapshot:
        """Beads as they are now, as observables of one's own see them."""
        return snapshot_of(self._scene, self._engine)

    def run(
        self, steps: int, until: Callable[[Snapshot], object] | None = None, every: int = 100
    ) -> None:
        """Go on for some steps; Ctrl-C stops it, and it can go on from there.

        ``until`` sees a snapshot every so many steps, and ends it where it returns what is true.
        """
        if until is not None:
            end = self.step + whole("steps", steps)
            while self.step < end:
                self.run(min(whole("every", every), end - self.step))
                if until(self.snapshot()):
                    break
            return
        first, since = self.step, time.perf_counter()
        sample = first + whole("steps", steps) - self._equilibrate
        if sample > self._room:
            self._room = max(sample, 2 * self._room)
            scene = self._planned(self._room)
            scene.stages += self._scene.stages[1:]
            self._observers = self._watching(scene, self._observers)
            self._scene = scene
        with (
            self._progress(steps, "dpd.Simulation") as shown,
            keyboard_interrupt(),
            stop_on([signal.SIGINT]) as asked,
        ):
            try:
                run(
                    self._engine, (self._equilibrate, sample), self._observers,
                    progress=lambda done: shown(done - first), stopping=asked,
                    systems=self._systems,
                )  # fmt: skip
            except LostRun as problem:
                raise UserError(f"{self._where}: {problem}") from None
            finally:
                self._seconds += time.perf_counter() - since

    def set(self, settings: Mapping[str, Any] | None = None, /, **named: Any) -> None:
        """Go on with other values.

        ``settings`` are values by keys of the scene, joined by dots, as ``{"repulsion.A A": 30}``;
        ``named`` the same by the last part of a key that is there once, as ``dt=0.02, kT=1.2``.
        Raises `dpd.UserError`, with nothing changed, if a value is not allowed or cannot change
        while the system runs, as the box, molecules, start and seed.
        """
        keys = {self._key(name): value for name, value in named.items()}
        self._enter(self.step, plain({**(settings or {}), **keys}))

    def result(self) -> xr.Dataset:
        """What was measured so far, as `dpd.run` gives it.

        Observables that have not looked yet are left out. Raises `dpd.UserError` if the system has
        not run for longer than its equilibration.
        """
        with TemporaryDirectory(prefix="dpd-") as folder:
            self.save(Path(folder, "run.nc"))
            return load(Path(folder, "run.nc"))

    def save(self, path: str | os.PathLike, *, overwrite: bool = False) -> None:
        """Write the result as ``dpd run`` does, with all that was set as its ``schedule``.

        Its scene, run by `dpd.run`, comes to the same bits; so does the result made longer by
        `dpd.extend` and this simulation run for longer. Nothing is replaced unasked.
        """
        path = Path(path)
        files.check_output(path, ".nc")
        if not overwrite:
            files.refuse_to_replace(path)
        # As long as this has run, with the observables that have looked.
        sample = self.step - self._equilibrate
        if sample < 1:
            raise UserError(
                f"{self._where}: nothing is measured yet: step {self.step} of "
                f"{self._equilibrate} to equilibrate; run it for longer"
            )
        pages = self._scene.observe
        looked = [
            item for item in self._data["observe"]
            if pages[item if isinstance(item, str) else next(iter(item))].every <= sample
        ]  # fmt: skip
        schedule = [each for each in self._schedule if each["step"] <= self.step]
        past = {"schedule": schedule} if schedule else {}
        scene = self._planned(sample, observe=looked, **past)
        observers = self._watching(scene, self._observers)
        timed = {
            "lost_step": -1,
            "seconds": self._seconds,
            "bead_steps_per_second": scene.beads * self.step / max(self._seconds, 1e-9),
        }
        for sentence in write_result(path, scene, self._engine, observers, timed)[1]:
            warn(sentence)

    def _planned(self, sample, **changes):
        """The scene with so many steps of sampling."""
        length = {"steps": {"equilibrate": self._equilibrate, "sample": sample}, "duration": {}}
        scene = Scene(self._data | length | changes, self._where)
        scene.chosen, scene.stretches = self._chosen, self._stretches
        return scene

    def _watching(self, scene, former=()):
        """The observables of a scene, where others have got to."""
        state = self._engine.state
        found = observables(scene, self._systems[0][1], None, state)
        if former:
            before = {each.key: each for each in former}
            arrays = arrays_of(state, [before[each.key] for each in found])
            go_on_from(arrays, found, self._equilibrate)
        for each in found if former else ():
            looked = self.step - counts_from(each, self._equilibrate)
            if each.every == looked and not each.arrays["taken"]:  # that which looks in the end
                each.sample(self._engine)
        return found

    def _enter(self, step, settings):
        """Other values from a step on."""
        enter(self._scene, step, settings, f"{self._where}: set")
        self._systems.append((step, system_of(self._scene.stages[-1].scene)))
        self._schedule.append({"step": step, "set": settings})

    def _key(self, name):
        """The key of a setting by its name alone."""
        scene = self._scene.stages[-1].scene
        if name in scene.terms:
            return name
        every = {key: scene.data[key] for key in scene.terms if isinstance(scene.data[key], dict)}
        found = [f"{key}.{name}" for key, names in every.items() if name in names]
        if len(found) == 1:
            return found[0]
        allowed = found or sorted({each for names in every.values() for each in names})
        raise UserError(f"set: {name!r} cannot change here; {suggestion(name, allowed)}")
