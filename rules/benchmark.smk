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
        "python -m dpd measure {wildcards.measurement:q} -o {output:q} 2>&1 | tee -i {log:q}"


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
        "python -m dpd report {params.study:q} benchmark -o {output.page:q} 2>&1 | tee -i {log:q}"
