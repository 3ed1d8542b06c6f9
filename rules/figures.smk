# One figure a job: picture, PDF, the plotted numbers, its rows of the verdict table, caption.


rule draw_figure:
    input:
        data=data_of_figure,
    output:
        png=report(
            OUT.figure("{paper}", "{figure}", "png"),
            caption="../paper_figures/caption.rst",
            category="{paper}",
        ),
        pdf=OUT.figure("{paper}", "{figure}", "pdf"),
        numbers=OUT.figure("{paper}", "{figure}", "nc"),
        verdicts=OUT.figure("{paper}", "{figure}", "csv"),
        caption=OUT.figure("{paper}", "{figure}", "html"),
    log:
        said=OUT.log("{paper}", "figures", "{figure}"),
        traceback=OUT.log("{paper}", "figures", "{figure}", kind="traceback"),
    params:
        study=STUDY,
        sources=figure_digest,
        data=option("data"),
        folder=OUT.figures("{paper}"),
        page=lambda wildcards: page_so_far(wildcards.paper),
    priority: lambda wildcards: priority(wildcards.paper, PAGES)
    retries: 0
    # Then the report so far, where that is older than two minutes: its last state is a job of its own.
    shell:
        "{DPD:q} figure {params.study:q} {wildcards.paper:q} {wildcards.figure:q}"
        " {params.data:q} -o {params.folder:q} --traceback {log.traceback:q} 2>&1 | tee -i {log.said:q}"
        "{params.page}"
