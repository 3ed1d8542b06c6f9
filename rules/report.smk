# The verdict table and the page.

FIGURES = [f"{OUT}/{name}/figures/{figure}" for name, p in REPORTED.items() for figure in p.figures]


rule join_verdicts:
    input:
        expand("{figure}.csv", figure=FIGURES),
    output:
        report(f"{OUT}/verdicts.csv", category="verdicts"),
    log:
        f"{LOGS}/verdicts.log",
    params:
        study=STUDY,
        papers=" ".join(REPORTED),
    shell:
        "python -m dpd verdicts {params.study} {params.papers} -o {output} 2>&1 | tee {log}"


rule write_report:
    input:
        page_sources(REPORTED),
    output:
        f"{OUT}/report.html",
    log:
        f"{LOGS}/report.log",
    params:
        study=STUDY,
        papers=" ".join(REPORTED),
        sources=stage_digest("report"),
    shell:
        "python -m dpd report {params.study} {params.papers} -o {output} 2>&1 | tee {log}"
