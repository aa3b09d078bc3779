"""The book that labbook 0.1.0 left, with its database at revision 0001 on either engine."""

from __future__ import annotations

import io
import json
import lzma
import re
import shutil
import subprocess
import tarfile
from pathlib import Path

import pyarrow as pa
import pytest

from tests.helpers.postgres import Cluster

DATA = Path(__file__).parents[1] / "labbook" / "book" / "data" / "book-0001"


def unpack(folder: Path, cluster: Cluster | None) -> dict[str, float | None]:
    """Lay the book out in a folder, on SQLite or on a new database of a server; returns what its reports printed."""
    _extract("book.tar.xz", folder)
    _extract("raw.tar.xz", folder)
    codec = pa.Codec("zstd", compression_level=1)
    for path in list((folder / "raw").iterdir()):
        data = path.read_bytes()
        path.unlink()
        kept = folder / "raw" / path.name[:2] / f"{path.name}.zst"
        kept.parent.mkdir(exist_ok=True)
        kept.write_bytes(memoryview(codec.compress(data)))
    if cluster is None:
        _extract("sqlite.tar.xz", folder)
    else:
        _into_postgres(folder, cluster)
    toml = folder / "labbook.toml"
    toml.write_text(re.sub("(?m)^run_pattern = .*\n", "", toml.read_text()))  # as its refusal asks
    printed: dict[str, float | None] = json.loads((folder / "printed.json").read_text())
    return printed


def _extract(name: str, folder: Path) -> None:
    with tarfile.open(fileobj=io.BytesIO(lzma.decompress((DATA / name).read_bytes()))) as archive:
        archive.extractall(folder, **({"filter": "data"} if hasattr(tarfile, "data_filter") else {}))  # Python 3.11.4


def _into_postgres(folder: Path, cluster: Cluster) -> None:
    psql = shutil.which("psql")
    if psql is None:
        pytest.skip("psql, which reads a dump, is not installed")
    _extract("postgresql.tar.xz", folder)
    name = cluster.fresh()
    server = ["-h", str(cluster.socket_folder), "-U", "labbook", "-d", name]
    subprocess.run([psql, "-q", "-v", "ON_ERROR_STOP=1", *server, "-f", str(folder / "dump.sql")], check=True)
    toml = folder / "labbook.toml"
    toml.write_text(f'{toml.read_text()}\n[database]\nurl = "{cluster.url(name)}"\n')
