# One run per point. The scene's digest and that of the sources are parameters, so that an
# edited sweep reruns the points that changed and an edited kernel reruns all.


def scene_of(wildcards):
    return PAPERS[wildcards.paper].sweeps[wildcards.sweep].point(wildcards.point).scene


rule simulate:
    input:
        lambda wildcards: f"{OUT}/{wildcards.paper}/starts/{start_digest(scene_of(wildcards))}.nc",
    output:
        f"{OUT}/{{paper}}/runs/{{sweep}}/{{point}}/run.nc",
    log:
        f"{LOGS}/{{paper}}/runs/{{sweep}}/{{point}}.log",
    params:
        sources=stage_digest("simulate"),
        scene=lambda wildcards: scene_of(wildcards).digest,
    shell:
        "python -m dpd simulate {STUDY} {wildcards.paper} {wildcards.sweep} {wildcards.point}"
        " --start {input} -o {output} > {log} 2>&1"
