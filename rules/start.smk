# Compiled kernels, and first configurations worth a job of their own: points that differ in
# nothing that matters there share one.


# Runs wait for it, but are not made again because of it: whether they depend on an edited kernel
# their own digests say.
rule compile_kernels:
    output:
        OUT.compiled("{paper}"),
    log:
        OUT.log("{paper}", "compile"),
    params:
        study=STUDY,
        sources=stage_digest("compile"),
    priority: work_compiled_for
    shell:
        "python -m dpd compile {params.study:q} {wildcards.paper:q} -o {output:q} 2>&1 | tee -i {log:q}"


rule make_start:
    input:
        ancient(rules.compile_kernels.output),
    output:
        OUT.start("{paper}", "{start}"),
    log:
        OUT.log("{paper}", "starts", "{start}"),
    params:
        study=STUDY,
        sources=sources_of_start,
        point=names_with_start,
    priority: work_after
    shell:
        "python -m dpd start {params.study:q} {wildcards.paper:q} {params.point:q} -o {output:q}"
        " 2>&1 | tee -i {log:q}"
