# One run per point. The scene's digest and that of the sources are parameters, so that an
# edited sweep reruns the points that changed and an edited kernel reruns all.


rule simulate:
    input:
        ancient(rules.compile_kernels.output),
        start=start_of,
    output:
        f"{OUT}/{{paper}}/runs/{{sweep}}/{{point}}/run.nc",
    log:
        f"{LOGS}/{{paper}}/runs/{{sweep}}/{{point}}.log",
    params:
        study=STUDY,
        sources=stage_digest("simulate"),
        scene=lambda wildcards: scene_of(wildcards).digest,
        start=given_start,
    priority: work_of
    threads: 1
    shell:
        "python -m dpd simulate {params.study} {wildcards.paper} {wildcards.sweep}"
        " {wildcards.point} {params.start} --threads {threads}"
        " -o {output} 2>&1 | tee {log}"
