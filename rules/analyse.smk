# The runs of a sweep, gathered on its axes; and sweeps that are calculated.


# The command is given the folder of the runs: a line with the names of thousands would be too long.
rule collect:
    input:
        runs_of_sweep,
        data=derived_from,
    output:
        OUT.sweep("{paper}", "{sweep}"),
    log:
        OUT.log("{paper}", "sweeps", "{sweep}"),
    params:
        study=STUDY,
        sources=stage_digest("collect"),
        series=lambda wildcards: sweep_of(wildcards).series,
        scenes=planned_digests,  # so that runs that were moved here are looked at when it changes
        runs=OUT.runs("{paper}", "{sweep}"),
        data=option("data"),
    priority: lambda wildcards: priority(wildcards.paper, PAGES)
    wildcard_constraints:
        paper=only_before(SIMULATED),
    retries: 0
    shell:
        "{DPD:q} collect {params.study:q} {wildcards.paper:q} {wildcards.sweep:q}"
        " --runs {params.runs:q} {params.data:q} -o {output:q} 2>&1 | tee -i {log:q}"


# A sweep of theory: one job for all points, which take milliseconds to a second each, or half a
# minute where chains grow. What moves beads has a `scene`, and waits for its kernels.
if CALCULATED:

    rule calculate:
        input:
            kernels_of_calculations,
        output:
            OUT.sweep("{paper}", "{sweep}"),
        log:
            OUT.log("{paper}", "sweeps", "{sweep}"),
        params:
            study=STUDY,
            sources=lambda wildcards: stage_digest("calculate", calculations_file(wildcards.paper)),
            points=lambda wildcards: PAPERS[wildcards.paper].theory[wildcards.sweep].calculated_digest,
        priority: lambda wildcards: priority(wildcards.paper, PAGES)
        wildcard_constraints:
            paper=only_before(CALCULATED),
        resources:
            runtime=lambda wildcards, attempt: 60 * attempt,
            mem_mb=lambda wildcards, attempt: 1000 * attempt,
        retries: 0
        shell:
            "{DPD:q} calculate {params.study:q} {wildcards.paper:q} {wildcards.sweep:q}"
            " -o {output:q} 2>&1 | tee -i {log:q}"
