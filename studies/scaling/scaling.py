"""The forecast of README.md and its figure: `python studies/scaling/scaling.py`.

Every stage waits for all of the one before; a part of it is done by one core, the rest by as many
as there are pieces. The CPU seconds are those of README.md, for 2305 objects.
"""

from pathlib import Path
from typing import NamedTuple

from egad._util.files import write_text
from egad.report.colors import LINES, SOFT
from egad.report.drawing import new_figure

FOLDER = Path(__file__).parent
CORES = (1, 2, 4, 8, 16, 32, 64, 128, 256)
SHOWN = (1, 16, 256)
# pieces: 32 shards, the fullest with 93 of 2305 objects or 5 of 49; cores that a job can use
SHARDS, TRIED, MACHINE = 25, 10, 64


class Stage(NamedTuple):
    """CPU seconds that one core has to do, that many can share, and in how many pieces."""

    name: str
    alone: float
    shared: float
    pieces: int

    def wall(self, cores: int) -> float:
        """Seconds on a number of cores."""
        return self.alone + self.shared / min(cores, self.pieces)


EVOLUTION = [Stage("evolve", 135, 4515, MACHINE)]
OBJECTS = [
    Stage("postprocess", 2, 388, SHARDS),
    Stage("collect", 8, 30, MACHINE),
    Stage("select-eval", 22, 77, MACHINE),
    Stage("rescale", 2, 85, MACHINE),
    Stage("grasp-label", 2, 408, SHARDS),
    Stage("bundle", 2, 45, 49),
    Stage("simulated-trial", 2, 222, TRIED),
    Stage("print-export, datasheet, size-effect, joins, compare", 50, 0, 1),
    Stage("report", 5, 64, MACHINE),
]
RUNS = {"from the released archive": OBJECTS, "with evolution": [*EVOLUTION, *OBJECTS]}


def main() -> None:
    """Write the figure beside this file and print the tables."""
    write_text(FOLDER / "scaling.svg", figure())
    heads = ["stage", *(f"{cores} core{'s' * (cores > 1)}, s" for cores in SHOWN)]
    print(row(heads), row(["---"] * len(heads)), sep="\n")
    for stage in RUNS["with evolution"]:
        print(row([stage.name, *(f"{stage.wall(cores):.0f}" for cores in SHOWN)]))
    for name, stages in RUNS.items():
        print(row([f"all, {name}", *(f"{seconds(stages, cores):.0f}" for cores in SHOWN)]))


def seconds(stages: list[Stage], cores: int) -> float:
    """One stage after another on a number of cores."""
    return sum(stage.wall(cores) for stage in stages)


def row(cells: list[str]) -> str:
    """A row of a table."""
    return "| " + " | ".join(cells) + " |"


def figure() -> str:
    """Time over cores, beside what it would be if all work could be shared."""
    with new_figure(5.6, 3.2) as drawing:
        axes = drawing.figure.subplots()
        for color, (name, stages) in zip(LINES, RUNS.items(), strict=False):
            minutes = [seconds(stages, cores) / 60 for cores in CORES]
            ideal = [minutes[0] / cores for cores in CORES]
            axes.loglog(CORES, minutes, color=color, marker="o", ms=4, label=name)
            axes.loglog(CORES, ideal, color=SOFT, lw=0.8, ls="--")
        axes.plot([], [], color=SOFT, lw=0.8, ls="--", label="if cores could share all")
        axes.set_xticks(CORES, [str(cores) for cores in CORES])
        axes.set_yticks([1, 3, 10, 30, 90], ["1", "3", "10", "30", "90"])
        axes.minorticks_off()
        axes.set_ylim(0.9, 120)
        axes.grid(visible=True)
        axes.set_xlabel("cores")
        axes.set_ylabel("minutes")
        axes.legend()
    return drawing.svg


if __name__ == "__main__":
    main()
