# The runs of a sweep, gathered on its axes; and values that one sweep measures for another.


rule collect:
    input:
        sweep_runs,
        derived=derived_of,
    output:
        f"{OUT}/{{paper}}/sweeps/{{sweep}}.nc",
    log:
        f"{LOGS}/{{paper}}/sweeps/{{sweep}}.log",
    params:
        study=STUDY,
        sources=stage_digest("collect"),
        series=lambda wildcards: PAPERS[wildcards.paper].sweeps[wildcards.sweep].series,
        scenes=sweep_digest,  # so that runs that were moved here are looked at when it changes
    shell:
        "python -m dpd collect {params.study:q} {wildcards.paper:q} {wildcards.sweep:q} -o {output:q}"
        " 2>&1 | tee -i {log:q}"


rule derive:
    input:
        derived_from,
    output:
        f"{OUT}/{{paper}}/derived/{{sweep}}.csv",
    log:
        f"{LOGS}/{{paper}}/derived/{{sweep}}.log",
    params:
        study=STUDY,
        sources=stage_digest("derive"),
        points=planned_digests,
    shell:
        "python -m dpd derive {params.study:q} {wildcards.paper:q} {wildcards.sweep:q} -o {output:q}"
        " 2>&1 | tee -i {log:q}"
