# One figure a job: picture, PDF, the plotted numbers, and its rows of the verdict table.


rule draw_figure:
    input:
        lambda wildcards: [
            f"{OUT}/{wildcards.paper}/sweeps/{sweep}.nc"
            for sweep in PAPERS[wildcards.paper].figures[wildcards.figure]
        ],
    output:
        png=report(
            f"{OUT}/{{paper}}/figures/{{figure}}.png",
            caption="../paper_figures/caption.rst",
            category="{paper}",
        ),
        pdf=f"{OUT}/{{paper}}/figures/{{figure}}.pdf",
        numbers=f"{OUT}/{{paper}}/figures/{{figure}}.nc",
        verdicts=f"{OUT}/{{paper}}/figures/{{figure}}.csv",
        caption=f"{OUT}/{{paper}}/figures/{{figure}}.md",
    log:
        f"{LOGS}/{{paper}}/figures/{{figure}}.log",
    params:
        sources=stage_digest("figure"),
        code=lambda wildcards: files_digest(
            ROOT / "paper_figures" / wildcards.paper / f"{wildcards.figure}.py"
        ),
        published=lambda wildcards: files_digest(ROOT / "paper_figures" / "published.yaml"),
    shell:
        "python -m dpd figure {STUDY} {wildcards.paper} {wildcards.figure}"
        " -o $(dirname {output.png}) > {log} 2>&1"
