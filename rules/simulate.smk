# One job for all scenes of a paper in which the same terms of the physics act: what it makes is named
# after the sources of those, and so an edited term concerns the scenes that have it.
rule compile_kernels:
    output:
        OUT.compiled("{paper}", "{kernels}"),
    log:
        OUT.log("{paper}", "compiled", "{kernels}"),
    params:
        study=STUDY,
    priority: 10**9  # before all runs, which wait for it
    resources:
        runtime=lambda wildcards, attempt: 20 * attempt,  # half a minute was measured
        mem_mb=lambda wildcards, attempt: 2000 * attempt,  # 537 were
    shell:
        "python -m dpd compile {params.study:q} {wildcards.paper:q} --kernels {wildcards.kernels:q}"
        " -o {output:q} 2>&1 | tee -i {log:q}"


# Short runs of a sweep share a job, one after the other: Python starts, and kernels are read, once.
# Its output is a stamp: the results lie beside it, one a point, and Snakemake must not delete them
# before it makes some anew. A run that finds itself made already, of the same scene and sources, stays
# as it is; so an edited sweep runs the points that changed, an edited kernel all. Values that another
# sweep measures are known only when that has run.


rule simulate:
    input:
        kernels_of_runs,
        data=derived_from,
    output:
        touch(OUT.batch("{paper}", "{sweep}", "{batch}")),
    log:
        OUT.log("{paper}", "runs", "{sweep}", "{batch}"),
    params:
        study=STUDY,
        sources=lambda wildcards: sorted(set(map(run_sources, scenes_of(wildcards)))),
        scenes=planned_digests,
        points=lambda wildcards: [point.name for point in batch_of(wildcards)],
        runs=results_of_runs,
        derived=lambda wildcards: stage_digest("derive") if sweep_of(wildcards).derived else "",
        data=option("data"),
    priority: longest_first
    threads: 1
    resources:
        runtime=lambda wildcards, attempt: jobs.minutes(scenes_of(wildcards), attempt, LONGEST),
        mem_mb=lambda wildcards, attempt: jobs.megabytes(scenes_of(wildcards), attempt),
    shell:
        "python -m dpd simulate {params.study:q} {wildcards.paper:q} {wildcards.sweep:q}"
        " {params.points:q} {params.data:q} --threads {threads}"
        " -o {params.runs:q} 2>&1 | tee -i {log:q}"
