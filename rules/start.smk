# Compiled kernels, and first configurations worth a job of their own: points that differ in
# nothing that matters there share one.


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
        "python -m dpd compile {params.study:q} {wildcards.paper:q} --kernels {wildcards.kernels:q}"
        " -o {output:q} 2>&1 | tee -i {log:q}"


rule make_start:
    input:
        kernels_of_start,
    output:
        OUT.start("{paper}", "{start}"),
    log:
        OUT.log("{paper}", "starts", "{start}"),
    params:
        study=STUDY,
        sources=lambda wildcards: start_sources(first_with_start(wildcards)[1].scene),
        sweep=lambda wildcards: first_with_start(wildcards)[0],
        point=lambda wildcards: first_with_start(wildcards)[1].name,
    priority: priority_of_start
    resources:
        runtime=minutes_of_job,
        mem_mb=memory_of_job,
    group:
        group_of_start
    shell:
        "python -m dpd start {params.study:q} {wildcards.paper:q} {params.sweep:q}"
        " {params.point:q} -o {output:q} 2>&1 | tee -i {log:q}"
