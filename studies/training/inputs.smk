"""Functions: settings and inputs of the rules of the study. No rules here."""


def of_set(file):
    """A file of the dataset that a training set is made from."""
    return lambda wildcards: (
        f"results/{PLAN.training_sets[wildcards.training_set].dataset}/{file}"
    )


def settings_of_set(stage):
    """The settings of a stage for a training set and, if the wildcards have a seed, a network."""
    return lambda wildcards: plain(select(_settings_of_set(wildcards), stage, GRIPPER))


def _settings_of_set(wildcards):
    network = Network(wildcards.training_set, int(wildcards.get("seed", 0)))
    return settings_for(STUDY, network)


def settings_of_test(stage):
    """The settings of a stage for a detector that is tested, with the noise in the file name."""

    def chosen(wildcards):
        whole = settings_of_tests(STUDY, wildcards.get("noise", "none"))
        return plain(select(whole, stage, GRIPPER, wildcards.detector))

    return chosen


def held_out_of_set(wildcards):
    """The evaluation set of the dataset, if it is held out for testing."""
    held = _settings_of_set(wildcards).render.hold_out
    return [of_set("eval49.parquet")(wildcards)] if held else []


def convex_parts_of_set(wildcards):
    """The convex parts of its objects, if its images are made with a simulation."""
    needed = _settings_of_set(wildcards).render.needs_convex_parts
    return [of_set(f"convex_parts/{GRIPPER}.parquet")(wildcards)] if needed else []


def shards_of_set(wildcards):
    """Numbers of the shards of the images of a training set."""
    return range(shard_count(_settings_of_set(wildcards).render.images))


def all_shards_of_set(pattern):
    """The files of all shards of a training set."""
    return lambda wildcards: expand(pattern, shard=shards_of_set(wildcards), **wildcards)


def images_of_network(wildcards):
    """The cards of all images that a network is trained on."""
    sources = PLAN.image_sets(wildcards.training_set)
    return expand("results/training_study/images/{source}/card.md", source=sources)


def grasps_of_labels(wildcards):
    """The labelled grasps for the detector `labels`; none for others."""
    knows = SETTINGS.detectors[wildcards.detector].detector == "labels"
    return [f"results/{wildcards.dataset}/grasps/{GRIPPER}.parquet"] if knows else []


def weights_of_network(wildcards):
    """The weights of a network that is trained here; none for other detectors."""
    trained = {each.name: each.folder for each in PLAN.trained}
    return [
        f"results/training_study/networks/{folder}/weights.safetensors"
        for name, folder in trained.items()
        if name == wildcards.detector
    ]


def compared():
    """The inputs of the report: tests, trainings and images."""
    detectors = [*(network.name for network in PLAN.networks), *PLAN.references]
    sources = [name for each in PLAN.trained for name in PLAN.image_sets(each.training_set)]
    return [
        *expand(
            f"results/training_study/trials/{{test}}/{{noise}}/{{detector}}.parquet",
            test=PLAN.tests,
            noise=PLAN.noise,
            detector=detectors,
        ),
        *expand(
            f"results/training_study/clutter/{{test}}/{{detector}}.parquet",
            test=PLAN.tests if PLAN.clutter else [],
            detector=detectors,
        ),
        *expand(
            "results/{test}/{file}",
            test=PLAN.tests,
            file=["eval49.parquet", f"rescaled/{GRIPPER}/scales.parquet"],
        ),
        *[
            f"results/training_study/networks/{each.folder}/{file}.parquet"
            for each in PLAN.trained
            for file in ("history", "score")
        ],
        *expand(f"results/training_study/images/{{source}}/card.md", source=dict.fromkeys(sources)),
    ]
