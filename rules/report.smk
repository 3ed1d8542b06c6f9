# The verdict table and the page. Snakemake deletes what a rule makes before it runs, but not what is
# marked `update`: a job that fails leaves the former table and page as they were. That they are
# out of date shows in the stamp beside the log, which is missing then and asked for by `all`.

FIGURES = [f"{OUT}/{name}/figures/{figure}" for name, p in REPORTED.items() for figure in p.figures]


rule join_verdicts:
    input:
        expand("{figure}.csv", figure=FIGURES),
    output:
        table=report(update(VERDICTS), category="verdicts"),
        stamp=touch(STAMPS[0]),
    log:
        f"{LOGS}/verdicts{PAGE}.log",
    params:
        study=STUDY,
        papers=list(REPORTED),
    shell:
        "python -m dpd verdicts {params.study:q} {params.papers:q} -o {output.table:q} 2>&1 | tee -i {log:q}"


rule write_report:
    input:
        page_sources(REPORTED),
    output:
        page=update(REPORT),
        stamp=touch(STAMPS[1]),
    log:
        f"{LOGS}/report{PAGE}.log",
    params:
        study=STUDY,
        papers=list(REPORTED),
        sources=stage_digest("report"),
    shell:
        "python -m dpd report {params.study:q} {params.papers:q} -o {output.page:q} 2>&1 | tee -i {log:q}"
