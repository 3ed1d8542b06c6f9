# One run per point. The scene's digest and that of the sources are parameters, so that an
# edited sweep reruns the points that changed and an edited kernel reruns all. Values that another
# sweep measures are known only when that has run: a run that finds itself made already, with the
# same values, stays as it is (`update` keeps Snakemake from deleting it).


rule simulate:
    input:
        kernels_of_run,
        start=start_of,
        derived=derived_of,
    output:
        result=update(OUT.run("{paper}", "{sweep}", "{point}")),
    log:
        OUT.log("{paper}", "runs", "{sweep}", "{point}"),
    params:
        study=STUDY,
        sources=sources_of_run,
        scene=planned_digest,
        start=option("start"),
        derived=option("derived"),
    priority: priority_of
    threads: 1
    resources:
        runtime=minutes_of_run,
        mem_mb=memory_of_run,
    group:
        batch_of_run
    shell:
        "python -m dpd simulate {params.study:q} {wildcards.paper:q} {wildcards.sweep:q}"
        " {wildcards.point:q} {params.start:q} {params.derived:q} --threads {threads}"
        " -o {output.result:q} 2>&1 | tee -i {log:q}"


# Runs whose scenes ask for a trajectory make that file too. Snakemake has no rule whose outputs depend
# on wildcards: this one is for those runs alone, and comes first.
if WITH_TRAJECTORY:

    use rule simulate as simulate_with_trajectory with:
        output:
            result=update(OUT.run("{paper}", "{sweep}", "{point}")),
            trajectory=update(OUT.trajectory("{paper}", "{sweep}", "{point}")),
        wildcard_constraints:
            paper=only_before(
                [file(*run) for run in WITH_TRAJECTORY for file in (OUT.run, OUT.trajectory)]
            ),

    ruleorder: simulate_with_trajectory > simulate
