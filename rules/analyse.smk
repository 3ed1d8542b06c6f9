# The runs of a sweep, gathered on its axes.


rule collect:
    input:
        lambda wildcards: [
            f"{OUT}/{wildcards.paper}/runs/{wildcards.sweep}/{point.name}/run.nc"
            for point in PAPERS[wildcards.paper].sweeps[wildcards.sweep].points
        ],
    output:
        f"{OUT}/{{paper}}/sweeps/{{sweep}}.nc",
    log:
        f"{LOGS}/{{paper}}/sweeps/{{sweep}}.log",
    params:
        sources=stage_digest("collect"),
    shell:
        "python -m dpd collect {STUDY} {wildcards.paper} {wildcards.sweep} -o {output} > {log} 2>&1"
