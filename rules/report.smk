# The verdict table and the page.

FIGURES = [f"{OUT}/{name}/figures/{figure}" for name, p in PAPERS.items() for figure in p.figures]


rule join_verdicts:
    input:
        expand("{figure}.csv", figure=FIGURES),
    output:
        report(f"{OUT}/verdicts.csv", category="verdicts"),
    log:
        f"{LOGS}/verdicts.log",
    params:
        study=STUDY,
        papers=" ".join(PAPERS),
    shell:
        "python -m dpd verdicts {params.study} {params.papers} -o {output} 2>&1 | tee {log}"


rule write_report:
    input:
        rules.join_verdicts.output,
        expand("{figure}.{kind}", figure=FIGURES, kind=["png", "md", "nc"]),
        [f"{OUT}/{name}/sweeps/{sweep}.nc" for name, p in PAPERS.items() for sweep in p.sweeps],
    output:
        f"{OUT}/report.html",
    log:
        f"{LOGS}/report.log",
    params:
        study=STUDY,
        papers=" ".join(PAPERS),
        sources=stage_digest("report"),
    shell:
        "python -m dpd report {params.study} {params.papers} -o {output} 2>&1 | tee {log}"
