"""Functions: the default targets. No rules here."""


def published():
    """The files that the report shows."""
    targets = SETTINGS.targets
    of_gripper = [
        "rescaled/{gripper}/scales.parquet",
        "rescaled/{gripper}/rejected.parquet",
        "grasps/{gripper}.parquet",
        "grasps/{gripper}.sampling.parquet",
        "grasps/{gripper}.rejected.parquet",
        "size_effect/{gripper}.parquet",
        "print/{gripper}/manifest.parquet",
        "bundle/{gripper}/rejected.parquet",
    ]
    if targets.graspability:
        of_gripper.append("graspability/{gripper}.parquet")
    if targets.simulated_labels:
        of_gripper.append("simulated/{gripper}.parquet")
    if targets.agreement:
        of_gripper.append("agreement/{gripper}.parquet")
    trials, clutter = (f"{name}/{{gripper}}/{{detector}}.parquet" for name in ("trials", "clutter"))
    failures = "failures/{gripper}/{detector}.html"
    of_target = [
        "eval49.parquet",
        "eval49.rejected.parquet",
        "eval49/README.md",
        "eval49/contact-sheet.pdf",
        "eval49/trials.csv",
        *expand(of_gripper, gripper=targets.grippers),
        *expand(trials, gripper=targets.grippers, detector=targets.detectors),
        *expand(clutter, gripper=targets.grippers, detector=targets.clutter),
        *expand(failures, gripper=targets.grippers, detector=targets.failures),
    ]
    return [
        "results/comparison.parquet",
        "results/comparison.svg",
        *of_datasets([*EVOLVED, *GIVEN], ["archive.parquet"]),
        *of_datasets(EVOLVED, ["history.parquet", "ancestry.parquet"]),
        *of_datasets(SETTINGS.datasets, ["objects.parquet", "rejected.parquet", "meshes"]),
        *of_datasets(targets.datasets, of_target),
    ]


def exported():
    """The requested exports of labelled grasps and images for other programs."""
    targets = SETTINGS.targets
    wanted = [
        "exchange/{gripper}.hdf5" if name == "dexnet" else f"exchange/{{gripper}}-{name}"
        for name in targets.exports
    ]
    return of_datasets(targets.datasets, expand(wanted, gripper=targets.grippers))


def rendered():
    """The images with grasps, if requested."""
    targets = SETTINGS.targets
    wanted = expand("images/{gripper}/card.md", gripper=targets.grippers)
    return of_datasets(targets.datasets, wanted) if targets.render else []


def made_scenes():
    """The labelled scenes, if requested."""
    targets = SETTINGS.targets
    wanted = expand("scenes/{gripper}/card.md", gripper=targets.grippers)
    return of_datasets(targets.datasets, wanted) if targets.scenes else []
