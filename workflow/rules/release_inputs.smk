"""Functions: the inputs of the release and its gallery. No rules here."""

from egad.exchange.release import Gallery

RELEASED = {"dataset": SETTINGS.release.dataset, "gripper": SETTINGS.release.gripper}


def of_release(pattern, **more):
    """A file of the dataset and the gripper of the release, or several."""
    found = expand(pattern, **RELEASED, **more)
    return found if more else found[0]


def ancestry_of_release(wildcards):
    """The ancestors of the objects, if they are known."""
    return ancestry_of(RELEASED["dataset"])


def shipped_networks(wildcards):
    """The files of the networks that egad ships, which are copied into the release."""
    return sorted(str(path) for path in NETWORKS.rglob("*") if path.is_file())


def archives_of_release(wildcards):
    """The archives for simulators, if the packages that write them are installed."""
    try:
        for name in SETTINGS.release.archives:
            module_of(name)
    except UserError as error:
        raise WorkflowError(f"release.archives: {error}")
    return expand("results/release/archives/{format}.zip", format=SETTINGS.release.archives)


def archive_of_release(wildcards):
    """The archive of the objects, if they come from one."""
    name = RELEASED["dataset"]
    return [f"results/{name}/archive.parquet"] if name in [*EVOLVED, *GIVEN] else []


def trials_of_release(wildcards):
    """The trials with the evaluation set, if they are targets, by detector."""
    targets = SETTINGS.targets
    if RELEASED["dataset"] not in targets.datasets or RELEASED["gripper"] not in targets.grippers:
        return {}
    pattern = "results/{dataset}/trials/{gripper}/{detector}.parquet"
    return {name: pattern.format(**RELEASED, detector=name) for name in targets.detectors}


def settings_of_gallery(wildcards):
    """The settings that the stage reads, with the gripper of the release."""
    return plain(select(SETTINGS, Gallery, RELEASED["gripper"]))
