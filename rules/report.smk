# The verdict table and the page. Snakemake deletes what a rule makes before it runs, but not what is
# marked `update`: a job that fails leaves the former table and page as they were. That they are
# out of date shows in the stamp beside the log, which is missing then and asked for by `all`.


rule join_verdicts:
    input:
        [OUT.figure(name, f, "csv") for name, paper in REPORTED.items() for f in paper.figures],
    output:
        table=report(update(VERDICTS), category="verdicts"),
        stamp=touch(STAMPS[0]),
    log:
        OUT.log(f"verdicts{PAGE}"),
    retries: 0
    shell:
        "{DPD:q} verdicts {input:q} -o {output.table:q} 2>&1 | tee -i {log:q}"


rule write_report:
    input:
        sources_of_page(REPORTED.values()),
        archived=ARCHIVED,
    output:
        page=update(REPORT),
        stamp=touch(STAMPS[1]),
    log:
        OUT.log(f"report{PAGE}"),
    params:
        sources=stage_digest("report"),
        command=report_of(REPORTED, REPORT),
    retries: 0
    shell:
        "{params.command} 2>&1 | tee -i {log:q}"


# A page on one paper, as soon as all of its figures are made.
if not PAGE:

    rule write_page:
        input:
            lambda wildcards: sources_of_page([REPORTED[wildcards.paper]]),
            archived=ARCHIVED,
        output:
            page=update(OUT.report("-{paper}")),
            stamp=touch(OUT.log("report-{paper}", kind="made")),
        log:
            OUT.log("report-{paper}"),
        params:
            sources=stage_digest("report"),
            command=lambda wildcards, output: report_of([wildcards.paper], output.page),
        priority: lambda wildcards: priority(wildcards.paper, PAGES)
        retries: 0
        shell:
            "{params.command} 2>&1 | tee -i {log:q}"
