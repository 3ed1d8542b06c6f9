# What the engine costs: measurements, and a page of its own on them.


# Takes all cores, so that nothing runs beside it, and comes after what has a priority.
rule measure:
    output:
        OUT.measurement("{paper}", "{measurement}"),
    log:
        OUT.log("{paper}", "measurements", "{measurement}"),
    params:
        sources=stage_digest("measure"),
    priority: 0
    threads: workflow.cores
    resources:
        runtime=lambda wildcards, attempt: 240 * attempt,
        mem_mb=lambda wildcards, attempt: 4000 * attempt,
    shell:
        "python -m benchmarks measure {wildcards.measurement:q} -o {output:q} 2>&1 | tee -i {log:q}"


# LAMMPS beside our engine, on a point of each sweep of the study that it can have.
rule witness:
    output:
        f"{OUT.folder}/benchmark/witness.csv",
    log:
        OUT.log("benchmark", "witness"),
    params:
        study=STUDY,
        sources=stage_digest("measure"),
    threads: workflow.cores
    shell:
        "python -m benchmarks witness {params.study:q} --cores {threads} -o {output:q}"
        " 2>&1 | tee -i {log:q}"


rule benchmark:
    input:
        sources_of_page([PAPERS["benchmark"]]),
    output:
        page=update(OUT.benchmark()),  # see rules/report.smk
        stamp=touch(OUT.log("benchmark", kind="made")),
    log:
        OUT.log("benchmark"),
    params:
        study=STUDY,
        sources=stage_digest("report"),
        results=lambda wildcards: OUT.folder,
    retries: 0
    shell:
        "{DPD:q} report {params.study:q} benchmark --results {params.results:q}"
        " -o {output.page:q} 2>&1 | tee -i {log:q}"
