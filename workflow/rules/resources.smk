"""What the jobs of each rule ask of a cluster; measured, see docs/cluster.md. No rules here.

A machine of one's own heeds the threads alone. Where a job is tried again (`retries` of a profile),
it asks for as much once more each time.
"""

# Rule: megabytes, as many more for each thread, minutes.
NEEDS = {
    "evolve": (1000, 600, 60),
    "merge": (1000, 100, 10),
    "archive": (1000, 0, 10),
    "history": (1000, 0, 10),
    "postprocess": (1500, 0, 30),
    "collect": (2000, 1000, 30),
    "rescale": (1000, 300, 30),
    "grasp_label": (1000, 0, 30),
    "join_grasps": (2000, 0, 10),
    "join_tallies": (1000, 0, 10),
    "join_ungraspable": (1000, 0, 10),
    "dexnet_objects": (1000, 0, 30),
    "dexnet": (1000, 0, 30),
    "acronym": (1000, 0, 30),
    "select_eval": (2000, 250, 30),
    "size_effect": (1000, 0, 10),
    "print_export": (1500, 0, 10),
    "datasheet": (1000, 0, 10),
    "bundle": (1500, 500, 60),
    "simulated_trial": (2000, 0, 120),
    "join_trials": (1000, 0, 10),
    "agreement": (2000, 0, 60),
    "join_agreement": (1000, 0, 10),
    "render": (1500, 0, 30),
    "image_card": (1000, 0, 10),
    "image_layout": (1500, 0, 30),
    "train_network": (2000, 500, 120),
    "diversity": (2000, 0, 30),
    "compare": (1000, 0, 10),
    "report": (1000, 300, 30),
}
# As many as there are: --cores sets the limit on a machine, max-threads of a profile on a cluster.
SIDE_BY_SIDE = 64


def needs(rule):
    """Memory and run time of the jobs of a rule, by the resource that the executors know."""
    memory, of_thread, minutes = NEEDS[rule]
    return {
        "mem_mb": lambda wildcards, threads, attempt: attempt * (memory + of_thread * threads),
        "runtime": lambda wildcards, attempt: attempt * minutes,
    }
