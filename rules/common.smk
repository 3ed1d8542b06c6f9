# What rules look up: the scene of a point, and a point for a start.


def trajectories():
    """Paper, sweep and point of all runs that write a trajectory."""
    return [
        (paper, sweep.name, point.name)
        for paper, plan in PAPERS.items()
        for sweep in plan.sweeps.values()
        for point in sweep.points
        if "trajectory" in point.scene.observe
    ]


def only_before(files):
    """A pattern for the wildcard {paper} that fits in the paths of some results alone.

    A pattern constrains one wildcard, and these files are told by several: it looks ahead, over the
    rest of the path.
    """
    rests = [file.removeprefix(f"{OUT.folder}/") for file in files]
    return rf"(?=(?:{'|'.join(map(re.escape, rests))})$)[^/]+"


WITH_TRAJECTORY = trajectories()
SIMULATED = [OUT.sweep(paper.name, sweep) for paper in PAPERS.values() for sweep in paper.sweeps]
CALCULATED = [OUT.sweep(paper.name, sweep) for paper in PAPERS.values() for sweep in paper.theory]
PRIORITY = jobs.priorities(PAPERS, FIRST)
WAITING = {name: jobs.waiting_for_starts(paper) for name, paper in PAPERS.items()}


def sweep_of(wildcards):
    """The sweep that a job is about."""
    return PAPERS[wildcards.paper].sweeps[wildcards.sweep]


def point_of(wildcards):
    """The point that a job is about."""
    return sweep_of(wildcards).point(wildcards.point)


def kernels_of_run(wildcards):
    """Compiled kernels of a run. It waits for them, but is not made again where they are newer."""
    kernels = kernels_name(point_of(wildcards).scene)
    return ancient(OUT.compiled(wildcards.paper, kernels))


def kernels_of_start(wildcards):
    """The same of a first configuration."""
    _, point = first_with_start(wildcards)
    kernels = kernels_name(point.scene, of_start=True)
    return ancient(OUT.compiled(wildcards.paper, kernels))


def runs_of_sweep(wildcards):
    """Runs of a sweep, in the order of its points."""
    points = sweep_of(wildcards).points
    return [OUT.run(wildcards.paper, wildcards.sweep, point.name) for point in points]


def sweep_digest(wildcards):
    """Digest of all scenes of a sweep."""
    sweep = sweep_of(wildcards)
    return value_digest([sweep.planned_digest(point) for point in sweep.points])


def theory_digest(wildcards):
    """Digest of all points of a sweep that is calculated."""
    return PAPERS[wildcards.paper].theory[wildcards.sweep].digest


def derived_of(wildcards):
    """Table of values that other sweeps measure for a sweep; no file where there are none."""
    return OUT.derived(wildcards.paper, wildcards.sweep) if sweep_of(wildcards).derived else []


def derived_from(wildcards):
    """The sweeps that measure them."""
    return jobs.derived_from(OUT, wildcards.paper, sweep_of(wildcards))


def data_of_figure(wildcards):
    """Sweeps and measurements that feed a figure."""
    paper, figure = wildcards.paper, wildcards.figure
    return jobs.data_of_figure(OUT, paper, PAPERS[paper].figures[figure])


def results_folder(wildcards):
    """Folder of the study, for a page on all that is in it."""
    return OUT.folder


def planned_digest(wildcards):
    """Digest of what is known of a run when it is planned."""
    return sweep_of(wildcards).planned_digest(point_of(wildcards))


def planned_digests(wildcards):
    """The same of all runs of a sweep."""
    sweep = sweep_of(wildcards)
    return value_digest([(point.name, sweep.planned_digest(point)) for point in sweep.points])


def sources_of_run(wildcards):
    """Digest of the sources that a run depends on: not on what its scene does without."""
    return run_sources(point_of(wildcards).scene)


def priority_of(wildcards):
    """Of a run: see `dpd.pipeline.jobs`."""
    return PRIORITY[wildcards.paper, wildcards.sweep, wildcards.point]


def priority_of_kernels(wildcards):
    """Of compilation: more than that of any run of the paper."""
    return 1 + max((PRIORITY[run] for run in PRIORITY if run[0] == wildcards.paper), default=0)


def priority_of_start(wildcards):
    """Of a start: more than that of any run that waits for it."""
    paper, waiting = wildcards.paper, WAITING[wildcards.paper][wildcards.start]
    return 1 + max(PRIORITY[paper, sweep, point.name] for sweep, point in waiting)


def minutes_of_run(wildcards, attempt):
    """What a run asks a cluster for; no more than config/config.yaml allows."""
    return jobs.minutes(point_of(wildcards).scene.work, attempt, LONGEST)


def memory_of_run(wildcards, attempt):
    """The same, in MB."""
    return jobs.megabytes(point_of(wildcards).scene.beads, attempt)


def batch_of_run(wildcards):
    """Short runs are submitted together; not those that wait for others, which may be among them."""
    scene, batch = point_of(wildcards).scene, None
    if not sweep_of(wildcards).derived:
        batch = jobs.batch(scene.work)
    return f"{batch}_runs" if batch else None


def minutes_of_start(wildcards, attempt):
    """What a start asks a cluster for."""
    scene = first_with_start(wildcards)[1].scene
    return jobs.minutes(jobs.start_bead_steps(scene), attempt, LONGEST)


def memory_of_start(wildcards, attempt):
    """The same, in MB."""
    return jobs.megabytes(first_with_start(wildcards)[1].scene.beads, attempt)


def batch_of_start(wildcards):
    """Short starts are submitted together."""
    batch = jobs.batch(jobs.start_bead_steps(first_with_start(wildcards)[1].scene))
    return f"{batch}_starts" if batch else None


def start_of(wildcards):
    """First configuration of a run; no file where the run makes its own."""
    scene = point_of(wildcards).scene
    return OUT.start(wildcards.paper, start_digest(scene)) if start_is_shared(scene) else []


def first_with_start(wildcards):
    """Sweep and point that a start is made for: the first that needs it."""
    waiting = WAITING[wildcards.paper].get(wildcards.start)
    if not waiting:
        raise WorkflowError(f"no point of {wildcards.paper} starts from {wildcards.start}")
    return waiting[0]


def names_with_start(wildcards):
    """The same as words of a command."""
    sweep, point = first_with_start(wildcards)
    return [sweep, point.name]


def sources_of_start(wildcards):
    """Digest of the sources that a start depends on."""
    _, point = first_with_start(wildcards)
    return start_sources(point.scene)


def option(name):
    """A function that gives an input as an option of a command; nothing where there is none."""

    def words(wildcards, input):
        files = input.get(name)
        return [f"--{name}", *([files] if isinstance(files, str) else files)] if files else []

    return words


def figure_digest(wildcards):
    """Digest of all that a figure's numbers and looks depend on: sources, its published numbers."""
    paper, figure = wildcards.paper, wildcards.figure
    sources, entries = figure_sources(figure_path(paper, figure)), entries_of(paper, figure)
    return f"{sources} {value_digest(entries)}"
