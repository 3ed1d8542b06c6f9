# One run per point. The scene's digest and that of the sources are parameters, so that an
# edited sweep reruns the points that changed and an edited kernel reruns all.


rule simulate:
    input:
        start_of,
    output:
        f"{OUT}/{{paper}}/runs/{{sweep}}/{{point}}/run.nc",
    log:
        f"{LOGS}/{{paper}}/runs/{{sweep}}/{{point}}.log",
    params:
        study=STUDY,
        sources=stage_digest("simulate"),
        scene=lambda wildcards: scene_of(wildcards).digest,
    priority: work_of
    threads: 1
    shell:
        "python -m dpd simulate {params.study} {wildcards.paper} {wildcards.sweep}"
        " {wildcards.point} --start {input} --threads {threads}"
        " -o {output} 2>&1 | tee {log}"
