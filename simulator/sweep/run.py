"""Run a sweep: chunk by chunk to disk, then one file; killed at any moment, the same command goes on where it was.

The chunks depend on the sweep alone, never on who computes them: the same bits come out whatever the number of cores
and the order. They lie in a folder beside the file to come, each in a file that has its name once it is on disk.

Chunks are computed by threads on this machine, or by the workers of a Dask cluster. Kernels let the interpreter go
while they run, so that threads use all cores. On a cluster the same chunks are sent to the workers, and the results
come back and are stored here: a chunk is a pure function of what is sent, so those of a worker that is lost are
computed again by another. Libraries that only sweeps need may be absent.
"""

from __future__ import annotations

import contextlib
import hashlib
import io
import itertools
import json
import math
import os
import shutil
import time
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import FIRST_COMPLETED, Executor, Future, ThreadPoolExecutor, wait
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from data_schema.disk import exclusive_lock, sync, sync_all, write_json
from data_schema.errors import BookBusy, LabbookError, UsageError
from data_schema.libraries import optional
from simulator.effects.registry import EFFECTS
from simulator.jump import small_cost
from simulator.kernel.layout import OUTCOMES
from simulator.scene_file import write_scene
from simulator.sweep.chunks import (
    FLAGS,
    NEVER_ROSE,
    NOT_MADE,
    NOT_MADE_ROW,
    OUTCOME_FLAGS,
    PLACE,
    REFUSED,
    REFUSED_FLAG,
    SAMPLED_ERROR,
    Block,
    Recipe,
    cores,
    kernel_of,
    recipe_for,
    simulate_rows,
    simulator_here,
)
from simulator.sweep.sweep import JUMP, Identity, Sweep, differences, identity_of

if TYPE_CHECKING:
    import xarray


IDENTITY = "sweep"
"""Attribute of the file with what identifies the sweep, as JSON."""
PLAN, LOCK = "sweep.json", "lock"
_MOST_NUMBERS = 2**23
"""Numbers of the outputs that are in memory at once, 64 MB: for each further time every chunk is opened again."""
_CAME_DOWN = OUTCOMES.index("touchdown")
_ZARR_BLOCK = 65_536
"""Most numbers in a block of a Zarr folder along its first dimension."""


@dataclass(frozen=True, slots=True)
class Summary:
    """How many jumps had each outcome, where `NEVER_ROSE` is one of its own, and how many each flag; of how many a
    sample has error bars, and how many of these do not keep the accuracy.

    `small_costs` are ill-conditioned since their cost is a small difference; that of `not_positive` is none, though
    the robot came down again.
    """

    outcomes: Mapping[str, int]
    flagged: Mapping[str, int]
    small_costs: int = 0
    not_positive: int = 0
    sampled: int = 0
    outside: int = 0

    @property
    def jumps(self) -> int:
        """How many jumps were made."""
        return sum(count for outcome, count in self.outcomes.items() if outcome not in (NOT_MADE, REFUSED))


@dataclass(frozen=True, slots=True)
class Finished:
    """A sweep that is done. `chunks_before` of its chunks were done by earlier runs; all where the file was there.

    `jumps_wanted`: how many jumps this run simulated, where all scenes made theirs. `compute_time_s`: simulating and
    keeping the chunks; `write_time_s`: making the file of them. `why_scalar`: why the scenes were not simulated side by
    side in lanes.
    """

    out: Path
    sweep: Sweep
    summary: Summary
    chunks_before: int
    jumps_wanted: int = 0
    compile_time_s: float = 0.0
    compute_time_s: float = 0.0
    write_time_s: float = 0.0
    why_scalar: str | None = None


def run_sweep(
    sweep: Sweep, out: Path, computing: Computing, advance: Callable[[int], None] = lambda _: None
) -> Finished:
    """Run a sweep to the file `out`, .nc or .zarr, and call `advance` with how many more jumps are done.

    Chunks are stored in the folder `out`.part until the file is there. An interrupted and continued sweep gives the
    same file as an undisturbed one, bit for bit. Raises `UsageError` where `out` or that folder holds something else.
    """
    _check_format(out)
    recipe = recipe_for(sweep.scene, sweep.design, sweep.accuracy, error_bars=sweep.error_bars)
    identity, chunks = identity_of(sweep), sweep.chunks
    if not out.parent.is_dir():
        raise UsageError(f"there is no folder {out.parent} for {out.name}: make it, or give another --out.")
    if not part_folder(out).exists() and _is_there(out, identity):
        advance(sweep.jumps_wanted)
        return Finished(out, sweep, _summary_of(out), len(chunks))
    with _part_folder_alone(out, identity) as folder:
        if _is_there(out, identity):  # another program may have made it a moment ago
            _remove_part_folder(folder)
            advance(sweep.jumps_wanted)
            return Finished(out, sweep, _summary_of(out), len(chunks))
        compile_time_s = kernel_of(recipe).compile_time_s if computing.here else 0.0
        started = time.perf_counter()
        missing = [number for number in range(len(chunks)) if not _is_whole(_chunk_file(folder, number))]
        wanted = {number: int((~sweep.refused[chunks[number]]).sum()) * sweep.scene.jumps for number in missing}
        advance(sweep.jumps_wanted - sum(wanted.values()))
        for number, block in _computed(sweep, recipe, missing, computing):
            _keep(folder, number, _with_refused(block, sweep.refused[chunks[number]]))
            advance(wanted[number])
        computed = time.perf_counter()
        result = folder / f".result{out.suffix}"
        _write(sweep, identity, folder, result)
        sync_all(result)
        result.rename(out)
        sync(out.parent)
        _remove_part_folder(folder)
        written = time.perf_counter()
    return Finished(
        out,
        sweep,
        _summary_of(out),
        chunks_before=len(chunks) - len(missing),
        jumps_wanted=sum(wanted.values()),
        compile_time_s=compile_time_s,
        compute_time_s=computed - started,
        write_time_s=written - computed,
        why_scalar=recipe.why_scalar,
    )


def _computed(sweep: Sweep, recipe: Recipe, numbers: list[int], computing: Computing) -> Iterator[tuple[int, Block]]:
    """Yield the chunks with these numbers as they are done, with a bounded number of them under way."""
    under_way: dict[Future[Block], int] = {}
    left, chunks = iter(numbers), sweep.chunks
    while True:
        for number in left:
            rows = chunks[number]
            made = ~sweep.refused[rows]
            values, barred = sweep.design.rows(rows.start, rows.stop)[made], sweep.barred(rows)[made]
            under_way[computing.executor.submit(simulate_rows, recipe, values, barred)] = number
            if len(under_way) >= computing.at_once:
                break
        if not under_way:
            return
        for future in wait(under_way, return_when=FIRST_COMPLETED).done:
            number = under_way.pop(future)
            try:
                block = future.result()
            except LabbookError:
                raise
            except Exception as error:
                if computing.here:
                    raise
                text = " ".join(str(error).split()).partition(". ")[0].rstrip(".")
                raise UsageError(
                    f"the cluster did not finish a chunk ({text or type(error).__name__}): see that its workers have "
                    "this labbook and look at their logs, then give the same command to go on."
                ) from error
            yield number, block


def _with_refused(block: Block, refused: NDArray[np.bool_]) -> Block:
    """Put the rows that were not simulated among those that were: `refused` says which, shape (all rows,)."""
    if not refused.any():
        return block
    whole = np.empty((len(refused), *block.shape[1:]))
    whole[~refused], whole[refused] = block, NOT_MADE_ROW[: block.shape[-1]]
    whole[refused, :, PLACE["outcome"]] = REFUSED_FLAG
    return whole


def part_folder(out: Path) -> Path:
    """Return the folder of the unfinished sweep whose result will be `out`."""
    return out.with_name(f"{out.name}.part")


def _chunk_file(folder: Path, number: int) -> Path:
    return folder / f"{number}.npy"


def _is_whole(path: Path) -> bool:
    """Tell whether a chunk is on disk as it was written: its SHA-256 stands behind it."""
    try:
        data = path.read_bytes()
    except OSError:
        return False
    return len(data) > _DIGEST_BYTES and hashlib.sha256(data[:-_DIGEST_BYTES]).digest() == data[-_DIGEST_BYTES:]


_DIGEST_BYTES = hashlib.sha256().digest_size


def _keep(folder: Path, number: int, block: Block) -> None:
    """Put a chunk on disk, output by output, shape (outputs, rows, jumps); it gets its name once it is there."""
    being_written, stream = folder / f".{number}.npy", io.BytesIO()
    np.save(stream, np.moveaxis(block, -1, 0))
    with being_written.open("wb") as file:
        file.write(stream.getbuffer())
        file.write(hashlib.sha256(stream.getbuffer()).digest())
        file.flush()
        os.fsync(file.fileno())
    being_written.rename(_chunk_file(folder, number))  # a name that a power cut takes back costs one chunk, so no sync


@contextlib.contextmanager
def _part_folder_alone(out: Path, identity: Identity) -> Iterator[Path]:
    """Open the folder of the unfinished sweep, or begin one, and let nobody else work on it meanwhile.

    Raises `UsageError` where another sweep was left there, or another program is at work.
    """
    folder = part_folder(out)
    busy = f"another program is working on {folder}: wait until it has finished, or give another --out."
    with contextlib.ExitStack() as held:
        try:
            folder.mkdir(exist_ok=True)
            (folder / LOCK).touch()
            held.enter_context(exclusive_lock(folder / LOCK, busy))
        except (FileNotFoundError, BookBusy) as error:  # it is at work, or has just removed the folder
            raise UsageError(busy) from error
        _check_same(folder, identity)
        for entry in folder.glob(".*"):
            _remove(entry)  # what was being written when a program died
        yield folder


def _check_same(folder: Path, identity: Identity) -> None:
    plan = folder / PLAN
    if plan.exists():
        there = json.loads(plan.read_text(encoding="utf-8"))
        if there != identity:
            raise UsageError(
                f"{folder} holds an unfinished sweep that differs in {differences(there, identity)}: give the command "
                "that began it, or another --out, or remove that folder."
            )
        return
    if any(not entry.name.startswith(".") and entry.name != LOCK for entry in folder.iterdir()):
        raise UsageError(f"{folder} is in the way and is no unfinished sweep: remove it, or give another --out.")
    write_json(plan, dict(identity))


def _remove_part_folder(folder: Path) -> None:
    """Remove an unfinished sweep that is open; the file that says what it is goes last, and then the lock."""
    for entry in folder.iterdir():
        if entry.name not in (PLAN, LOCK):
            _remove(entry)
    for name in (PLAN, LOCK):
        (folder / name).unlink(missing_ok=True)
    with contextlib.suppress(OSError):  # another program has a lock of its own there already: the folder is its now
        folder.rmdir()


def _remove(entry: Path) -> None:
    if entry.is_dir():
        shutil.rmtree(entry)
    else:
        entry.unlink()


LIBRARIES = {".nc": "netCDF4", ".zarr": "zarr"}
"""By the end of a file's name, the library that xarray writes it with."""


def _check_format(out: Path) -> None:
    if out.suffix not in LIBRARIES:
        raise UsageError(f"--out {out} does not say which format: end it in {' or '.join(LIBRARIES)}.")
    optional(LIBRARIES[out.suffix], f"a {out.suffix} file", "sweeps")


@contextlib.contextmanager
def _opened(out: Path) -> Iterator[xarray.Dataset]:
    import xarray

    with xarray.open_dataset(out, engine="zarr" if out.suffix == ".zarr" else "netcdf4") as dataset:
        yield dataset


def _is_there(out: Path, identity: Identity) -> bool:
    """Tell whether the file has this sweep; raises `UsageError` where it is there with something else."""
    if not out.exists():
        return False
    try:
        with _opened(out) as dataset:
            there = json.loads(dataset.attrs[IDENTITY])
    except (OSError, ValueError, KeyError) as error:
        raise UsageError(f"{out} is there already and is no sweep: give another --out, or remove it.") from error
    if there != identity:
        raise UsageError(
            f"{out} holds a sweep that differs in {differences(there, identity)}: give another --out, or remove it."
        )
    return True


def _summary_of(out: Path) -> Summary:
    """Count the jumps of a sweep that is done."""
    with _opened(out) as dataset:
        ends = dataset["outcome"].to_numpy()
        rose = dataset[NEVER_ROSE].to_numpy() != 1
        counts = {outcome: int(((ends == flag) & rose).sum()) for flag, outcome in OUTCOME_FLAGS}
        counts[NEVER_ROSE] = int((~rose).sum())
        flagged = {flag: int((dataset[flag] == 1).sum()) for flag in FLAGS}
        errors = dataset[SAMPLED_ERROR.name].to_numpy().ravel() if SAMPLED_ERROR.name in dataset else np.zeros(0)
        cost_j, at_play_j, ill = (
            dataset[name].to_numpy() for name in ("cost_J", "energy_at_play_J", "ill_conditioned")
        )
    small, free = small_cost(cost_j, at_play_j) & (ill == 1), (cost_j <= 0.0) & (ends == _CAME_DOWN) & rose
    found = {outcome: count for outcome, count in counts.items() if count}
    return Summary(
        found, flagged, int(small.sum()), int(free.sum()), int((~np.isnan(errors)).sum()), int((errors > 1.0).sum())
    )


def _dataset(sweep: Sweep, identity: Identity) -> xarray.Dataset:
    """Return what a sweep's file holds beside its outputs."""
    import xarray

    coordinates: dict[str, Any] = {}
    for axis in sweep.design.axes:
        dim = sweep.design.dim_of(axis)
        coordinates[axis.name] = (dim, axis.coordinates, {"units": axis.unit, "long_name": axis.meaning})
        if axis.parameter != axis.name:
            stands_for = {"units": "1", "long_name": f"{axis.parameter} that {axis.name} stands for, SI"}
            coordinates[axis.parameter] = (dim, axis.values, stands_for)
    if JUMP in sweep.dims:
        numbers = np.arange(1, sweep.scene.jumps + 1, dtype=np.int32)
        coordinates[JUMP] = (JUMP, numbers, {"units": "1", "long_name": "number of the jump, from 1"})
    scene, swept = sweep.scene, ", ".join(axis.name for axis in sweep.design.axes)
    attributes = {
        "title": f"{scene.title}: sweep of {swept}",
        "scene": scene.name,
        "scene_toml": write_scene(scene),
        "comment": f"The scene holds what was not swept; {swept} stand in the coordinates. Numbers are in SI units.",
        "effects": " ".join(name for name in EFFECTS if name in scene.effects),
        "accuracy": sweep.accuracy,
        "sampling": sweep.design.description,
        "assumed": json.dumps({name: scene.values[name].why for name in sweep.assumed}, ensure_ascii=False),
        "set_by_user": json.dumps({name: scene[name] for name in scene.set_by_user}),
        **({REFUSED: sweep.why_refused} if sweep.why_refused else {}),
        "simulator_fingerprint": identity["simulator"],
        "labbook_version": sweep.labbook,
        IDENTITY: json.dumps(dict(identity), ensure_ascii=False),
    }
    return xarray.Dataset(coords=coordinates, attrs=attributes)


def _outputs(sweep: Sweep, folder: Path) -> Iterator[xarray.Dataset]:
    """Yield the outputs of all chunks, as many at once as memory is for."""
    import xarray

    shape = tuple(sweep.dims.values())
    at_once = max(1, _MOST_NUMBERS // math.prod(shape))
    for start in range(0, len(sweep.outputs), at_once):
        some = slice(start, start + at_once)
        # Each chunk is mapped for as long as it is copied: what was read of a mapped file counts as memory
        copied = [
            np.array(np.load(_chunk_file(folder, number), mmap_mode="r")[some]) for number in range(len(sweep.chunks))
        ]
        variables = {}
        for output, numbers in zip(sweep.outputs[some], np.concatenate(copied, axis=1), strict=True):
            values = numbers.astype(output.kind, copy=False).reshape(shape)
            about: dict[str, Any] = {"units": output.unit, "long_name": output.meaning}
            about |= {"comment": output.comment} if output.comment else {}
            if output.flags:
                about["flag_values"] = np.array([value for value, _ in output.flags], np.int8)
                about["flag_meanings"] = " ".join(meaning for _, meaning in output.flags)
            variables[output.name] = (tuple(sweep.dims), values, about)
        yield xarray.Dataset(variables)


def _write(sweep: Sweep, identity: Identity, folder: Path, path: Path) -> None:
    """Write the file: the outputs, then what describes the sweep."""
    for dataset in itertools.chain(_outputs(sweep, folder), [_dataset(sweep, identity)]):
        if path.suffix == ".nc":
            plain = {name: {"_FillValue": None} for name in dataset.variables}
            dataset.to_netcdf(path, mode="a" if path.exists() else "w", engine="netcdf4", encoding=plain)
        else:
            shapes = {name: (min(_ZARR_BLOCK, value.shape[0]), *value.shape[1:]) for name, value in dataset.items()}
            in_blocks = {name: {"chunks": shape} for name, shape in shapes.items()}
            dataset.to_zarr(path, mode="a", zarr_format=2, consolidated=False, encoding=in_blocks)  # all readers know 2
    if path.suffix == ".zarr":
        import zarr

        zarr.consolidate_metadata(path, zarr_format=2)


CHUNKS_A_CORE, FEWEST_WAITING = 4, 32
"""Chunks under way at once: some for every core, and some for workers that join; they bound the memory taken here."""
CONNECT_WITHIN_S = 10


@dataclass(frozen=True, slots=True)
class Computing:
    """What chunks are submitted to, how many at once, and whether this process compiles the kernel for it."""

    executor: Executor
    at_once: int
    here: bool = True


@contextlib.contextmanager
def threads(count: int | None = None) -> Iterator[Computing]:
    """Compute on so many threads, one a core where no number is given."""
    n = count or cores()
    with ThreadPoolExecutor(n) as pool:
        try:
            yield Computing(pool, 2 * n)
        finally:
            pool.shutdown(cancel_futures=True)


@contextlib.contextmanager
def cluster(address: str) -> Iterator[Computing]:
    """Compute on the workers of the scheduler at an address such as tcp://127.0.0.1:8786.

    Raises `UsageError` where there is none, or where a worker has another labbook.
    """
    distributed = optional("distributed", "--scheduler", "sweeps")
    try:
        # a client that fails on this by itself is closed as Python ends, and complains then of a loop that has gone
        distributed.comm.get_address_host_port(address)
        client = distributed.Client(address, timeout=CONNECT_WITHIN_S, set_as_default=False)
    except (OSError, ValueError) as error:
        raise UsageError(
            f"no Dask scheduler answers at {address}: start one with `dask scheduler`, give its tcp:// address, or "
            "leave --scheduler out to use this machine."
        ) from error
    with client:
        for worker, version in client.run(simulator_here, on_error="return").items():
            if version != simulator_here():
                raise UsageError(
                    f"the worker at {worker} has another simulator ({version}): give it the same labbook, Python and "
                    "numba."
                )
        most = max(FEWEST_WAITING, CHUNKS_A_CORE * sum(client.ncores().values()))
        yield Computing(client.get_executor(pure=False), most, here=False)
