# Compiled kernels, and first configurations worth a job of their own: points that differ in
# nothing that matters there share one.


rule compile_kernels:
    output:
        f"{OUT}/{{paper}}/compiled-{stage_digest('engine')}.txt",
    log:
        f"{LOGS}/{{paper}}/compile.log",
    params:
        study=STUDY,
    priority: work_compiled_for
    shell:
        "python -m dpd compile {params.study:q} {wildcards.paper:q} -o {output:q} 2>&1 | tee -i {log:q}"


rule make_start:
    input:
        ancient(rules.compile_kernels.output),
    output:
        f"{OUT}/{{paper}}/starts/{{start}}.nc",
    log:
        f"{LOGS}/{{paper}}/starts/{{start}}.log",
    params:
        study=STUDY,
        sources=stage_digest("start"),
        point=first_with_start,
    priority: work_after
    shell:
        "python -m dpd start {params.study:q} {wildcards.paper:q} {params.point:q} -o {output:q}"
        " 2>&1 | tee -i {log:q}"
