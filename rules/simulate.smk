# One job for all scenes of a paper in which the same terms of the physics act: what it makes is named
# after the sources of those, and so an edited term concerns the scenes that have it.
rule compile_kernels:
    output:
        OUT.compiled("{paper}", "{kernels}"),
    log:
        OUT.log("{paper}", "compiled", "{kernels}"),
    params:
        study=STUDY,
    priority: priority_of_kernels
    resources:
        runtime=lambda wildcards, attempt: 20 * attempt,  # half a minute was measured
        mem_mb=lambda wildcards, attempt: 2000 * attempt,  # 537 were
    shell:
        "{DPD:q} compile {params.study:q} {wildcards.paper:q} --kernels {wildcards.kernels:q}"
        " -o {output:q} 2>&1 | tee -i {log:q}"


# A melt whose chains grow, in a job of its own: points that differ in nothing that matters there
# share one. Beads that are only placed each run places itself.
rule make_start:
    input:
        lambda wildcards: kernels_of([first_with_start(wildcards)[1]], wildcards),
    output:
        OUT.start("{paper}", "{start}"),
    log:
        OUT.log("{paper}", "starts", "{start}"),
    params:
        study=STUDY,
        sources=lambda wildcards: start_sources(first_with_start(wildcards)[1].scene),
        sweep=lambda wildcards: first_with_start(wildcards)[0],
        point=lambda wildcards: first_with_start(wildcards)[1].name,
    priority: lambda wildcards: priority(wildcards.paper, KERNELS)
    resources:
        runtime=lambda wildcards, attempt: jobs.minutes(
            [first_with_start(wildcards)[1].scene], attempt, LONGEST
        ),
        mem_mb=lambda wildcards, attempt: jobs.megabytes(
            [first_with_start(wildcards)[1].scene], attempt
        ),
    shell:
        "{DPD:q} start {params.study:q} {wildcards.paper:q} {params.sweep:q}"
        " {params.point:q} -o {output:q} 2>&1 | tee -i {log:q}"


# Short runs of a sweep share a job, one after the other: Python starts, and kernels are read, once.
# Its output is a stamp: the results lie beside it, one a point, and Snakemake must not delete them
# before it makes some anew. A run that finds itself made already, of the same scene and sources, stays
# as it is; so an edited sweep runs the points that changed, an edited kernel all. Values that another
# sweep measures are known only when that has run.


rule simulate:
    input:
        lambda wildcards: kernels_of(batch_of(wildcards), wildcards),
        start=start_of_runs,
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
        start=option("start"),
        data=option("data"),
        threads=lambda wildcards, threads: 1 if ranks_of(wildcards) > 1 else threads,
    priority: priority_of_runs
    threads: ranks_of
    resources:
        tasks=ranks_of,  # of Slurm, each on a core; with mpi it leaves their start to mpiexec
        cpus_per_task=lambda wildcards, threads: 1 if ranks_of(wildcards) > 1 else threads,
        mpi=lambda wildcards: "mpiexec" if ranks_of(wildcards) > 1 else None,
        runtime=lambda wildcards, attempt: jobs.minutes(scenes_of(wildcards), attempt, LONGEST),
        mem_mb=lambda wildcards, attempt: jobs.megabytes(scenes_of(wildcards), attempt),
    shell:
        "{DPD:q} simulate {params.study:q} {wildcards.paper:q} {wildcards.sweep:q}"
        " {params.points:q} {params.start:q} {params.data:q} --threads {params.threads}"
        " -o {params.runs:q} 2>&1 | tee -i {log:q}"
