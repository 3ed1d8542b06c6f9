# What rules look up.


def only_before(files):
    """A pattern for the wildcard {paper} that fits in the paths of some results alone.

    A pattern constrains one wildcard, and these files are told by several: it looks ahead, over the
    rest of the path.
    """
    rests = [file.removeprefix(f"{OUT.folder}/") for file in files]
    return rf"(?=(?:{'|'.join(map(re.escape, rests))})$)[^/]+"


SIMULATED = [OUT.sweep(paper.name, sweep) for paper in PAPERS.values() for sweep in paper.sweeps]
CALCULATED = [OUT.sweep(paper.name, sweep) for paper in PAPERS.values() for sweep in paper.theory]
BATCHES = {
    (name, sweep.name): jobs.batches(sweep, CONFIG["batch"])
    for name, paper in PAPERS.items()
    for sweep in paper.sweeps.values()
}
STARTS = {}
for name, paper in PAPERS.items():
    for sweep in paper.sweeps.values():
        for point in sweep.points:
            if point.scene.start.work:
                STARTS.setdefault((name, start_digest(point.scene)), (sweep.name, point))


def sweep_of(wildcards):
    """The sweep that a job is about."""
    return PAPERS[wildcards.paper].sweeps[wildcards.sweep]


def batch_of(wildcards):
    """The points whose runs share a job."""
    return BATCHES[wildcards.paper, wildcards.sweep][int(wildcards.batch)]


def scenes_of(wildcards):
    """Their scenes."""
    return [point.scene for point in batch_of(wildcards)]


def ranks_of(wildcards):
    """Processes of another engine that they want, as LAMMPS by MPI; 1 of our own."""
    return max(scene.ranks for scene in scenes_of(wildcards))


def results_of_runs(wildcards):
    """Their results."""
    paper, sweep = wildcards.paper, wildcards.sweep
    return [OUT.run(paper, sweep, point.name) for point in batch_of(wildcards)]


def remove_old_stamps():
    """Remove the stamp of a job one of whose results is gone, or was made by another since."""
    for (paper, sweep), batches in BATCHES.items():
        for number, batch in enumerate(batches):
            stamp = Path(OUT.batch(paper, sweep, str(number)))
            runs = [Path(OUT.run(paper, sweep, point.name)) for point in batch]
            if stamp.exists() and not all(
                run.exists() and run.stat().st_mtime <= stamp.stat().st_mtime for run in runs
            ):
                stamp.unlink()


def kernels_of(points, wildcards):
    """Compiled kernels of runs. They wait for them, but are not made again where they are newer."""
    kernels = {kernels_name(point.scene) for point in points}
    return [ancient(OUT.compiled(wildcards.paper, name)) for name in sorted(kernels)]


def kernels_of_calculations(wildcards):
    """The same of calculations that move beads."""
    points = PAPERS[wildcards.paper].theory[wildcards.sweep].points
    moved = [p._replace(scene=p.scene.scene()) for p in points if hasattr(p.scene, "scene")]
    return kernels_of(moved, wildcards)


def runs_of_sweep(wildcards):
    """Stamps of all runs of a sweep."""
    paper, sweep = wildcards.paper, wildcards.sweep
    return [OUT.batch(paper, sweep, str(number)) for number in range(len(BATCHES[paper, sweep]))]


def start_of_runs(wildcards):
    """First configuration that runs share; no file where they make their own."""
    scene = batch_of(wildcards)[0].scene
    return OUT.start(wildcards.paper, start_digest(scene)) if scene.start.work else []


def first_with_start(wildcards):
    """Sweep and point that a start is made for: the first that needs it."""
    if (wildcards.paper, wildcards.start) not in STARTS:
        raise WorkflowError(f"no point of {wildcards.paper} starts from {wildcards.start}")
    return STARTS[wildcards.paper, wildcards.start]


PAGES, FIRST, KERNELS, RUNS = 4, 3, 2, 1  # what comes before what within a paper
QUICKEST = {name: jobs.quickest(paper) for name, paper in PAPERS.items()}
KERNELS_OF_QUICKEST = {
    name: {kernels_name(p.scene) for sweep in QUICKEST[name] for p in paper.sweeps[sweep].points}
    for name, paper in PAPERS.items()
}


def priority(paper, place, work=0):
    """Papers come in their order, and within a paper what helps to see something soon.

    That is figures and pages, then the figure that takes the least work, kernels, and runs.
    """
    return (len(PAPERS) - list(PAPERS).index(paper)) * 10**9 + place * 10**8 + round(work / 1e6)


def priority_of_kernels(wildcards):
    """Of compilation."""
    soon = wildcards.kernels in KERNELS_OF_QUICKEST[wildcards.paper]
    return priority(wildcards.paper, FIRST if soon else KERNELS)


def priority_of_runs(wildcards):
    """The longest run comes first, so that none is left to the end, where a core would wait."""
    soon = wildcards.sweep in QUICKEST[wildcards.paper]
    longest = max(scene.work for scene in scenes_of(wildcards))
    return priority(wildcards.paper, FIRST if soon else RUNS, longest)


def derived_from(wildcards):
    """The sweeps that measure values for a sweep."""
    sources = sorted({rule.from_ for rule in sweep_of(wildcards).derived.values()})
    return [OUT.sweep(wildcards.paper, source) for source in sources]


def data_of_figure(wildcards):
    """Sweeps and measurements that feed a figure."""
    paper = wildcards.paper
    figure = PAPERS[paper].figures[wildcards.figure]
    measured = [OUT.measurement(paper, name) for name in figure.measurements]
    return [OUT.sweep(paper, name) for name in figure.sweeps] + measured


def planned_digests(wildcards):
    """Digest of what is known of runs when they are planned: of a job's, or of a whole sweep's."""
    sweep = sweep_of(wildcards)
    points = batch_of(wildcards) if "batch" in wildcards.keys() else sweep.points
    return value_digest([(point.name, sweep.planned_digest(point)) for point in points])


def option(name):
    """A function that gives an input as an option of a command; nothing where there is none."""

    def words(wildcards, input):
        files = input.get(name)
        return [f"--{name}", *([files] if isinstance(files, str) else files)] if files else []

    return words


# The verdict table of the long study that git keeps, which no -d takes elsewhere; none at first.
ARCHIVED = ROOT / "results" / "archive" / LONG_STUDY / "verdicts.csv"
ARCHIVED = [str(ARCHIVED)] if ARCHIVED.is_file() else []


def sources_of_page(papers):
    """What a page shows of some papers."""
    kinds, found = ("csv", "png", "html", "nc"), []
    for paper in papers:
        found += [OUT.figure(paper.name, f, kind) for f in paper.figures for kind in kinds]
        found += [OUT.sweep(paper.name, sweep) for sweep in (*paper.sweeps, *paper.theory)]
        found += [OUT.measurement(paper.name, name) for name in paper.measurements]
    return found


def report_of(papers, page):
    """The command that writes a page on some papers, from what is there."""
    archived = [f"--archived={path}" for path in ARCHIVED]
    words = [*DPD, "report", STUDY, *papers, "--results", OUT.folder, *archived]
    return shlex.join([*words, "-o", page])


def page_so_far(paper):
    """What a figure of the report does in the end, for who watches it grow."""
    if paper not in REPORTED:
        return ""
    recent = f"find {shlex.quote(REPORT)} -mmin -2 2>/dev/null"
    return f'; [ -n "$({recent})" ] || {report_of(REPORTED, REPORT)} &> /dev/null || true'


def figure_digest(wildcards):
    """Digest of all that a figure's numbers and looks depend on: sources, its published numbers."""
    paper, path = wildcards.paper, figure_path(wildcards.paper, wildcards.figure)
    entries = {name: published(paper)[name] for name in shown_by(str(path))}
    return f"{stage_digest('figure', path)} {value_digest(entries)}"
