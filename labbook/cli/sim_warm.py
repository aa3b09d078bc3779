"""`labbook sim warm`: kernels compiled before they are needed."""

from typing import Annotated

import typer

from labbook.cli.common import JsonOption
from labbook.terminal import emit, progress


def warm(
    scenes: Annotated[
        list[str] | None, typer.Argument(metavar="[SCENE]...", help="Names or .toml files; without any, all shipped.")
    ] = None,
    lanes: Annotated[
        bool, typer.Option("--lanes", help="Also compile sweeps that simulate many scenes side by side: 50 s each.")
    ] = False,
    as_json: JsonOption = False,
) -> None:
    """Compile the simulator for the effects of scenes: 10 to 30 s each, once for each version of labbook.

    Nothing needs it: a first simulation runs in plain Python for 10 s before it compiles. Sweeps, reports and anything
    with many jumps then start at once. With --lanes sweeps of these scenes take half the time, to the same numbers;
    scenes that have no lanes are left out.

    Example: labbook sim warm sim2 bed --lanes
    """
    from data_schema.cache_folder import CACHE_VARIABLE
    from data_schema.errors import UsageError
    from simulator.kernel.build import is_cached, kernel_for, why_no_lanes
    from simulator.scene_file import load_scene, shipped_scenes

    found = {name: load_scene(name) for name in scenes or shipped_scenes()}
    spent_s: dict[str, float] = {}
    with progress("compiling", len(found), shown=not as_json) as done:
        for name, scene in found.items():
            spent_s[name] = kernel_for(scene.effects).compile_time_s
            if lanes and why_no_lanes(scene.effects) is None:
                spent_s[name] += kernel_for(scene.effects, lanes=True).compile_time_s
            done(name)
            if not is_cached(scene.effects):
                raise UsageError(
                    f"the kernel of {name} was compiled and cannot be kept: name a folder that can be written in "
                    f"{CACHE_VARIABLE}."
                )
    emit(
        {"compile_time_s": spent_s}, [f"{name}: ready after {spent:.3g} s" for name, spent in spent_s.items()], as_json
    )
