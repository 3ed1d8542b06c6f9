# One figure a job: picture, PDF, the plotted numbers, its rows of the verdict table, caption.


rule draw_figure:
    input:
        figure_sources,
    output:
        png=report(
            f"{OUT}/{{paper}}/figures/{{figure}}.png",
            caption="../paper_figures/caption.rst",
            category="{paper}",
        ),
        pdf=f"{OUT}/{{paper}}/figures/{{figure}}.pdf",
        numbers=f"{OUT}/{{paper}}/figures/{{figure}}.nc",
        verdicts=f"{OUT}/{{paper}}/figures/{{figure}}.csv",
        caption=f"{OUT}/{{paper}}/figures/{{figure}}.html",
    log:
        said=f"{LOGS}/{{paper}}/figures/{{figure}}.log",
        traceback=f"{LOGS}/{{paper}}/figures/{{figure}}.traceback",
    params:
        study=STUDY,
        sources=figure_digest,
    shell:
        "python -m dpd figure {params.study:q} {wildcards.paper:q} {wildcards.figure:q}"
        ' -o "$(dirname {output.png:q})"'
        " --traceback {log.traceback:q} 2>&1 | tee -i {log.said:q}"
