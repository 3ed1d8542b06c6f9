"""Regenerate the figures of papers on DPD and hold every published number against ours.

    snakemake --cores 2                          the study named in config/config.yaml
    snakemake --cores 2 --config study=smoke     another one
    snakemake --cores 2 benchmark                what the engine costs, and what that buys
"""

import atexit
import os
import re
import shlex
import subprocess
import sys
import tempfile
import time
from pathlib import Path

BEGUN = time.time()
sys.path.insert(0, str(Path(workflow.basedir) / "src"))
if "papers_dir" in config:  # papers outside of this clone; the commands of the rules look there too
    if not os.path.isabs(str(config["papers_dir"])):
        raise WorkflowError(
            f"papers_dir: {config['papers_dir']!r} is no whole path; begin it with / or $PWD/"
        )
    os.environ.update(DPD_PAPERS_DIR=str(config["papers_dir"]))

from dpd.analysis.verdicts import figure_path, published, shown_by
from dpd.folders import ROOT
from dpd.digests import value_digest
from dpd.errors import UserError
from dpd.pipeline import jobs
from dpd.pipeline.paths import LONG_STUDY, errors_in, results_of
from dpd.pipeline.paper import read_config, read_paper
from dpd.digests import calculations_file, kernels_name, run_sources, stage_digest, start_sources
from dpd.start import start_digest

# Rules run `python -m dpd`: with the Python and the sources that belong to this Snakemake. A job has
# the cores that it says: linear algebra starts no threads of its own, which a fork could not copy.
here = {"PATH": f"{Path(sys.executable).parent}:{os.environ.get('PATH', '')}"}
os.environ.update(here, PYTHONPATH=f"{ROOT / 'src'}:{ROOT}", MPLBACKEND="Agg")
os.environ.update(OPENBLAS_NUM_THREADS="1")


# Where rules find their commands, and how they call them: see rules/jobs.py.
os.environ.pop("DPD_JOBS", None)
DPD = [sys.executable, "-IS", str(ROOT / "rules" / "jobs.py")]
SERVING = []


# Results belong to the repository, wherever snakemake is called from, unless -d says otherwise.
workdir: str(ROOT)


configfile: str(ROOT / "config" / "config.yaml")


try:
    CONFIG = read_config(dict(config))
    STUDY = CONFIG["study"]
    LONGEST = CONFIG["longest_job"]
    # What names of report and verdicts end in: nothing for all papers, or -liu_2008+mine.
    chosen, every = (sorted(set(each["papers"])) for each in (CONFIG, read_config()))
    PAGE = "" if chosen == every else f"-{'+'.join(chosen)}"
    REPORTED = {name: read_paper(name, STUDY) for name in CONFIG["papers"]}
    # Not part of the report unless it is asked for; `snakemake benchmark` makes it all the same.
    PAPERS = REPORTED | {"benchmark": read_paper("benchmark", STUDY)}
    for name, paper in PAPERS.items():
        for figure in paper.figures:
            figure_path(name, figure)
        published(name)
except UserError as problem:
    raise WorkflowError(str(problem)) from None

OUT = results_of(STUDY)
# The shared page is that of all papers in config/config.yaml; others get one of their own.
REPORT = OUT.report(PAGE)
VERDICTS = OUT.verdicts(PAGE)
# See rules/report.smk.
STAMPS = [OUT.log(f"{name}{PAGE}", kind="made") for name in ("verdicts", "report")]
if not PAGE:  # a page of each paper as well
    STAMPS += [OUT.log(f"report-{name}", kind="made") for name in REPORTED]


wildcard_constraints:
    paper="|".join(map(re.escape, PAPERS)),
    sweep="[a-z0-9_]+",
    measurement="[^/]+",
    batch="[0-9]+",
    figure="[a-z0-9_]+",
    kernels="[0-9a-f]+",


onstart:
    # While it limits the rate of jobs, as it does by default, each wake-up of Snakemake's
    # scheduler sets a timer for one more: after some hundred jobs that keeps half a core busy.
    workflow.scheduler.job_rate_limiter = None
    os.environ["DPD_JOBS"] = f"{tempfile.mkdtemp(prefix='dpd-')}/jobs"
    serve = [sys.executable, DPD[-1], "--serve", os.environ["DPD_JOBS"]]
    SERVING.append(subprocess.Popen(serve, stdin=subprocess.PIPE))  # which ends with Snakemake


onsuccess:
    for page in (REPORT, OUT.benchmark()):
        if os.path.exists(page) and os.path.getmtime(page) >= BEGUN:
            print(f"report: {page}")


onerror:
    # The first sentences of jobs that failed, last: below all that Snakemake has to say of them.
    lines = [f"{line} ({path})" for line, path in errors_in(OUT.logs, BEGUN).items()][:20]
    if lines:
        atexit.register(lambda: print("", *lines, sep="\n", file=sys.stderr))


# On a cluster these run where Snakemake does: each takes seconds, and a place in the queue more.
# What fails there fails again, so that no retries are of use.
localrules:
    all,
    collect,
    draw_figure,
    join_verdicts,
    write_page,
    write_report,
    benchmark,


rule all:
    input:
        REPORT,
        VERDICTS,
        STAMPS,


include: "rules/common.smk"
include: "rules/simulate.smk"
include: "rules/analyse.smk"
include: "rules/figures.smk"
include: "rules/report.smk"
include: "rules/benchmark.smk"

if not workflow.remote_exec:
    remove_old_stamps()
