# Short runs of a sweep share a job, one after the other: Python starts, and kernels are read, once.
# Its output is a stamp: the results lie beside it, one a point, and Snakemake must not delete them
# before it makes some anew. A run that finds itself made already, of the same scene and sources, stays
# as it is; so an edited sweep runs the points that changed, an edited kernel all. Values that another
# sweep measures are known only when that has run.


rule simulate:
    input:
        kernels_of_runs,
        start=start_of_runs,
        derived=derived_of,
    output:
        touch(OUT.batch("{paper}", "{sweep}", "{batch}")),
    log:
        OUT.log("{paper}", "runs", "{sweep}", "{batch}"),
    params:
        study=STUDY,
        sources=lambda wildcards: sorted({run_sources(p.scene) for p in batch_of(wildcards)}),
        scenes=planned_digests,
        points=lambda wildcards: [point.name for point in batch_of(wildcards)],
        runs=results_of_runs,
        start=option("start"),
        derived=option("derived"),
    priority: priority_of_runs
    threads: 1
    resources:
        runtime=minutes_of_job,
        mem_mb=memory_of_job,
    group:
        group_of_runs
    shell:
        "python -m dpd simulate {params.study:q} {wildcards.paper:q} {wildcards.sweep:q}"
        " {params.points:q} {params.start:q} {params.derived:q} --threads {threads}"
        " -o {params.runs:q} 2>&1 | tee -i {log:q}"
