# What rules look up: the scene of a point, and a point for a start.


def waiting_for_starts(paper):
    """Digest of each start to the (sweep, point) pairs that need it, in order."""
    waiting = {}
    for sweep in paper.sweeps.values():
        for point in sweep.points:
            if start_is_shared(point.scene):
                waiting.setdefault(start_digest(point.scene), []).append((sweep.name, point))
    return waiting


WAITING = {name: waiting_for_starts(paper) for name, paper in PAPERS.items()}


def sweep_runs(wildcards):
    """Runs of a sweep, in the order of its points."""
    folder = f"{OUT}/{wildcards.paper}/runs/{wildcards.sweep}"
    points = PAPERS[wildcards.paper].sweeps[wildcards.sweep].points
    return [f"{folder}/{point.name}/run.nc" for point in points]


def sweep_digest(wildcards):
    """Digest of all scenes of a sweep."""
    sweep = PAPERS[wildcards.paper].sweeps[wildcards.sweep]
    return value_digest([sweep.planned_digest(point) for point in sweep.points])


def derived_of(wildcards):
    """Table of values that other sweeps measure for a sweep; no file where there are none."""
    if not PAPERS[wildcards.paper].sweeps[wildcards.sweep].derived:
        return []
    return f"{OUT}/{wildcards.paper}/derived/{wildcards.sweep}.csv"


def derived_from(wildcards):
    """The sweeps that measure them."""
    rules = PAPERS[wildcards.paper].sweeps[wildcards.sweep].derived
    return sorted({f"{OUT}/{wildcards.paper}/sweeps/{rule.source}.nc" for rule in rules})


def figure_sources(wildcards):
    """Sweeps and measurements that feed a figure."""
    folder, figure = f"{OUT}/{wildcards.paper}", PAPERS[wildcards.paper].figures[wildcards.figure]
    return [f"{folder}/sweeps/{name}.nc" for name in figure.sweeps] + [
        f"{folder}/measurements/{name}.nc" for name in figure.measurements
    ]


def page_sources(papers):
    """All that a page on some papers is made from."""
    files = []
    for name, paper in papers.items():
        folder = f"{OUT}/{name}"
        figures = expand(
            "{figure}.{kind}", figure=paper.figures, kind=["png", "html", "nc", "csv"]
        )
        files += [f"{folder}/figures/{figure}" for figure in figures]
        files += [f"{folder}/sweeps/{sweep}.nc" for sweep in paper.sweeps]
        files += [f"{folder}/measurements/{name}.nc" for name in paper.measurements]
    return files


def scene_of(wildcards):
    """Scene of a run."""
    return PAPERS[wildcards.paper].sweeps[wildcards.sweep].point(wildcards.point).scene


def planned_digest(wildcards):
    """Digest of what is known of a run when it is planned."""
    sweep = PAPERS[wildcards.paper].sweeps[wildcards.sweep]
    return sweep.planned_digest(sweep.point(wildcards.point))


def planned_digests(wildcards):
    """The same of all runs of a sweep."""
    sweep = PAPERS[wildcards.paper].sweeps[wildcards.sweep]
    return value_digest([(point.name, sweep.planned_digest(point)) for point in sweep.points])


def work_of(wildcards):
    """Millions of bead-steps of a run: its priority, so that no long run is left to the end."""
    return 1 + round(scene_of(wildcards).work / 1e6)


def work_compiled_for(wildcards):
    """The same for compilation: of the longest run of a paper."""
    sweeps = PAPERS[wildcards.paper].sweeps.values()
    works = (point.scene.work for sweep in sweeps for point in sweep.points)
    return 1 + round(max(works, default=0) / 1e6)


def work_after(wildcards):
    """The same for a start: of the longest run that waits for it."""
    return 1 + max(round(point.scene.work / 1e6) for _, point in WAITING[wildcards.paper][wildcards.start])


def start_of(wildcards):
    """First configuration of a run; no file where the run makes its own."""
    scene = scene_of(wildcards)
    if not start_is_shared(scene):
        return []
    return f"{OUT}/{wildcards.paper}/starts/{start_digest(scene)}.nc"


def given_start(wildcards, input):
    """The option that names it, as words of a command."""
    return ["--start", input.start] if input.start else []


def first_with_start(wildcards):
    """Sweep and point that a start is made for: the first that needs it."""
    waiting = WAITING[wildcards.paper].get(wildcards.start)
    if not waiting:
        raise WorkflowError(f"no point of {wildcards.paper} starts from {wildcards.start}")
    sweep, point = waiting[0]
    return [sweep, point.name]


def figure_digest(wildcards):
    """Digest of all that a figure's numbers and looks depend on: sources, its published numbers."""
    paper, figure = wildcards.paper, wildcards.figure
    sources, entries = figure_files(paper, figure), entries_of(paper, figure)
    return f"{stage_digest('figure')} {files_digest(*sources)} {value_digest(entries)}"
