# First configurations. Points that differ in nothing that matters there share one.


def first_with_start(wildcards):
    """Sweep and point that a start is made for: the first that needs it."""
    for sweep in PAPERS[wildcards.paper].sweeps.values():
        for point in sweep.points:
            if start_digest(point.scene) == wildcards.start:
                return sweep.name, point.name
    raise WorkflowError(f"no point of {wildcards.paper} starts from {wildcards.start}")


rule compile_kernels:
    output:
        f"{OUT}/compiled-{stage_digest('engine')}.txt",
    log:
        f"{LOGS}/compile.log",
    shell:
        "python -m dpd compile {STUDY} {PAPER_NAMES} -o {output} > {log} 2>&1"


rule make_start:
    input:
        ancient(rules.compile_kernels.output),
    output:
        f"{OUT}/{{paper}}/starts/{{start}}.nc",
    log:
        f"{LOGS}/{{paper}}/starts/{{start}}.log",
    params:
        sources=stage_digest("start"),
        point=lambda wildcards: " ".join(first_with_start(wildcards)),
    shell:
        "python -m dpd start {STUDY} {wildcards.paper} {params.point} -o {output} > {log} 2>&1"
