# What Snakemake needs on a node of a cluster. It is told there which jobs to do, and splits that at
# commas (https://github.com/snakemake/snakemake/issues/2366): of the point "dt=0.01,replica=0" is
# left "dt=0.01", and replica is a wildcard of its own, which the rule does not know.


def with_whole_wildcards(new_job):
    """`snakemake.dag.DAG.new_job`, for wildcards that were split on their way."""

    async def joined(dag, rule, *more, wildcards_dict=None, **others):
        whole, last = {}, None
        for name, value in (wildcards_dict or {}).items():
            if name in rule.wildcard_names:
                whole[name], last = value, name
            else:
                whole[last] += f",{name}={value}"
        return await new_job(dag, rule, *more, wildcards_dict=whole or wildcards_dict, **others)

    return joined


if workflow.remote_exec:
    from snakemake.dag import DAG

    DAG.new_job = with_whole_wildcards(DAG.new_job)
