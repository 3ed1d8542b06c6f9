# The verdict table and the page.

FIGURES = [f"{OUT}/{name}/figures/{figure}" for name, p in PAPERS.items() for figure in p.figures]


rule join_verdicts:
    input:
        expand("{figure}.csv", figure=FIGURES),
    output:
        report(f"{OUT}/verdicts.csv", category="verdicts"),
    log:
        f"{LOGS}/verdicts.log",
    shell:
        "python -m dpd verdicts {STUDY} {PAPER_NAMES} -o {output} > {log} 2>&1"


rule write_report:
    input:
        f"{OUT}/verdicts.csv",
        expand("{figure}.{kind}", figure=FIGURES, kind=["png", "md", "nc"]),
        [f"{OUT}/{name}/sweeps/{sweep}.nc" for name, p in PAPERS.items() for sweep in p.sweeps],
    output:
        f"{OUT}/report.html",
    log:
        f"{LOGS}/report.log",
    params:
        sources=stage_digest("report"),
    shell:
        "python -m dpd report {STUDY} {PAPER_NAMES} -o {output} > {log} 2>&1"
