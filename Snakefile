"""Regenerate the figures of three DPD papers and hold every published number against ours.

    snakemake --cores 2                          the study named in config/config.yaml
    snakemake --cores 2 --config study=smoke     another one
    snakemake --cores 2 benchmark                what the engine costs, and what that buys
"""

import os
import sys
import time
from pathlib import Path

BEGUN = time.time()
sys.path.insert(0, str(Path(workflow.basedir) / "src"))

from dpd.digest import ROOT, files_digest, stage_digest, value_digest
from dpd.errors import UserError
from dpd.report.overhead import overhead
from dpd.starting import start_digest, start_is_shared
from dpd.study import read_config, read_paper

# Rules run `python -m dpd`: with the Python and the sources that belong to this Snakemake.
here = {"PATH": f"{Path(sys.executable).parent}:{os.environ.get('PATH', '')}"}
os.environ.update(here, PYTHONPATH=str(ROOT / "src"), MPLBACKEND="Agg")
# For the report, which says what the workflow cost.
os.environ.update(DPD_BEGUN=str(BEGUN), DPD_CORES=str(workflow.cores))


configfile: "config/config.yaml"


try:
    CONFIG = read_config(dict(config))
    STUDY = CONFIG["study"]
    REPORTED = {name: read_paper(name, STUDY) for name in CONFIG["papers"]}
    # Not part of the report unless it is asked for; `snakemake benchmark` makes it all the same.
    PAPERS = REPORTED | {"benchmark": read_paper("benchmark", STUDY)}
except UserError as problem:
    raise WorkflowError(str(problem)) from None

OUT = f"results/{STUDY}"
LOGS = f"{OUT}/logs"


wildcard_constraints:
    paper="|".join(PAPERS),
    sweep="[a-z0-9_]+",
    measurement="[a-z0-9_]+",
    point="[^/]+",
    figure="[a-z0-9_]+",


onstart:
    # While it limits the rate of jobs, as it does by default, each wake-up of Snakemake's
    # scheduler sets a timer for one more: after some hundred jobs that keeps half a core busy.
    workflow.scheduler.job_rate_limiter = None


onsuccess:
    if cost := overhead(OUT, BEGUN, workflow.cores):
        print(cost)


localrules:
    all,


rule all:
    input:
        f"{OUT}/report.html",
        f"{OUT}/verdicts.csv",


include: "rules/common.smk"
include: "rules/start.smk"
include: "rules/simulate.smk"
include: "rules/analyse.smk"
include: "rules/figures.smk"
include: "rules/report.smk"
include: "rules/benchmark.smk"
