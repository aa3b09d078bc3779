"""Options that several commands of `labbook sim` take."""

from typing import Annotated

import typer

SceneOption = Annotated[
    str, typer.Option("--scene", metavar="NAME", help="bed, sim1, sim2, emulator, force_plate, or a .toml file.")
]
SetOption = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="NAME=VALUE",
        help="A parameter in SI units, or gain, flight, jumps, ...: see `labbook sim parts`; repeatable.",
    ),
]
EffectsOption = Annotated[
    str | None,
    typer.Option(
        "--effects", metavar="LIST", help="Effects on and off: +drag,-added_mass; auto: only those that matter."
    ),
]
WithinOption = Annotated[
    str | None,
    typer.Option("--within", metavar="SHARE", help="With --effects auto: the change that may pass, such as 1%."),
]
AccuracyOption = Annotated[float, typer.Option("--accuracy", help="The relative error aimed at.")]
