# What the engine costs: measurements, and a page of its own on them.


# Takes all cores, so that nothing runs beside it, and comes after what has a priority.
rule measure:
    output:
        f"{OUT}/{{paper}}/measurements/{{measurement}}.nc",
    log:
        f"{LOGS}/{{paper}}/measurements/{{measurement}}.log",
    params:
        sources=stage_digest("measure"),
    priority: 0
    threads: workflow.cores
    shell:
        "python -m dpd measure {wildcards.measurement} -o {output} 2>&1 | tee {log}"


rule benchmark:
    input:
        page_sources({"benchmark": PAPERS["benchmark"]}),
    output:
        page=update(f"{OUT}/benchmark.html"),  # see rules/report.smk
        stamp=touch(f"{LOGS}/benchmark.made"),
    log:
        f"{LOGS}/benchmark.log",
    params:
        study=STUDY,
        sources=stage_digest("report"),
    shell:
        "python -m dpd report {params.study} benchmark -o {output.page} 2>&1 | tee {log}"
