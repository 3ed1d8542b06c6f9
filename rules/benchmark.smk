# The engine's speed. Takes all cores, so that nothing else runs beside it.


rule benchmark:
    input:
        ancient(rules.compile_kernels.output),
    output:
        f"{OUT}/benchmark.txt",
    log:
        f"{LOGS}/benchmark.log",
    params:
        sources=stage_digest("engine"),
    threads: workflow.cores
    shell:
        "python -m dpd bench -o {output} 2>&1 | tee {log}"
