"""A private PostgreSQL server for tests: its own cluster in a temporary folder, reached through a socket there."""

from __future__ import annotations

import contextlib
import os
import pwd
import shutil
import subprocess
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import count
from pathlib import Path

import psycopg
import sqlalchemy as sa

from tests.helpers.folders import folder_in_memory

ROLE = "labbook"
SERVER_USER = "postgres"
START_S = 30.0
ROOM_BYTES = 1 << 30
"""A database is hundreds of small files, and a test makes one."""


class NoServer(Exception):
    """PostgreSQL cannot be run here; the text says why."""


@dataclass
class Cluster:
    """A running server; databases are made from templates, which takes milliseconds."""

    socket_folder: Path
    _numbers: Iterator[int] = field(default_factory=count)

    def url(self, database: str) -> str:
        """The address of a database as labbook.toml states it."""
        return f"postgresql+psycopg://{ROLE}@/{database}?host={self.socket_folder}"

    def fresh(self, template: str = "template0") -> str:
        """Make a database of a new name, and return the name."""
        name = f"test_{next(self._numbers)}"
        self.make(name, template)
        return name

    def make(self, name: str, template: str = "template0") -> None:
        """Make a database that is empty, or a copy of another to which nobody is connected."""
        self._order(f'CREATE DATABASE "{name}" TEMPLATE "{template}" STRATEGY file_copy')

    def drop(self, database: str) -> None:
        """Remove a database, whoever is still connected to it."""
        self._order(f'DROP DATABASE IF EXISTS "{database}" WITH (FORCE)')

    def _order(self, statement: str) -> None:
        with psycopg.connect(host=str(self.socket_folder), user=ROLE, dbname="postgres", autocommit=True) as connection:
            connection.execute(statement.encode())


def cluster_of(url: str) -> tuple[Cluster, str]:
    """Return the server of an address that a `Cluster` gave, and the name of the database there."""
    parts = sa.make_url(url)
    assert parts.database is not None
    return Cluster(Path(str(parts.query["host"]))), parts.database


@contextlib.contextmanager
def running_cluster() -> Iterator[Cluster]:
    """Run a server until the end of the block; raises `NoServer` where there is none to run."""
    binaries = _binaries()
    as_user = _as_server_user()
    # a short path: the name of a socket holds 107 bytes
    folder = Path(tempfile.mkdtemp(prefix="labbook-pg-", dir=folder_in_memory(ROOM_BYTES)))
    try:
        if as_user:
            account = pwd.getpwnam(SERVER_USER)
            os.chown(folder, account.pw_uid, account.pw_gid)
        folder.chmod(0o755)
        data, log = folder / "data", folder / "server.log"
        _run([*as_user, str(binaries / "initdb"), "-D", str(data), "-U", ROLE, "-A", "trust", "-E", "UTF8",
              "--locale=C", "--no-sync", "--no-instructions"])  # fmt: skip
        options = {
            "listen_addresses": "''",
            "unix_socket_directories": f"'{folder}'",
            "fsync": "off",
            "full_page_writes": "off",
            "synchronous_commit": "off",
            "max_connections": "40",
            "shared_buffers": "32MB",
            "autovacuum": "off",
        }
        with (data / "postgresql.conf").open("a") as handle:
            handle.writelines(f"{name} = {value}\n" for name, value in options.items())
        with log.open("wb") as messages:
            server = subprocess.Popen(
                [*as_user, str(binaries / "postgres"), "-D", str(data)],
                stdout=subprocess.DEVNULL,
                stderr=messages,
                start_new_session=True,
            )
        try:
            _wait(server, folder, log)
            yield Cluster(folder)
        finally:
            subprocess.run(
                [*as_user, str(binaries / "pg_ctl"), "stop", "-D", str(data), "-m", "immediate", "-s"], check=False
            )
            server.wait(START_S)
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def _binaries() -> Path:
    versions = sorted(Path("/usr/lib/postgresql").glob("*/bin/initdb"), key=lambda path: int(path.parts[-3]))
    if versions:
        return versions[-1].parent
    found = shutil.which("initdb")
    if found is None:
        raise NoServer("no PostgreSQL server is installed (initdb was not found)")
    return Path(found).resolve().parent


def _as_server_user() -> list[str]:
    """PostgreSQL refuses to run as root."""
    if os.geteuid() != 0:
        return []
    try:
        pwd.getpwnam(SERVER_USER)
    except KeyError:
        raise NoServer(f"PostgreSQL does not run as root, and there is no user {SERVER_USER!r}") from None
    if shutil.which("runuser") is None:
        raise NoServer("PostgreSQL does not run as root, and there is no runuser")
    return ["runuser", "-u", SERVER_USER, "--"]


def _run(command: list[str]) -> None:
    done = subprocess.run(command, capture_output=True, text=True, check=False, cwd="/tmp")
    if done.returncode:
        raise NoServer(f"{' '.join(command)} failed: {done.stderr.strip()}")


def _wait(server: subprocess.Popen[bytes], folder: Path, log: Path) -> None:
    deadline = time.monotonic() + START_S
    while True:
        try:
            psycopg.connect(host=str(folder), user=ROLE, dbname="postgres").close()
        except psycopg.OperationalError as error:
            if server.poll() is not None or time.monotonic() > deadline:
                raise NoServer(f"PostgreSQL did not start ({error}): {log.read_text()[-500:]}") from error
            time.sleep(0.02)
        else:
            return
