"""`ro-crate-metadata.json` of a capsule: what it holds, of whom and since when, as RO-Crate 1.1 and `.eln` have it.

Every file but this one is an entity with its size and SHA-256; folders are entities with the files in them.
"""

from __future__ import annotations

import json
import re
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import PurePosixPath
from typing import Any
from urllib.parse import quote, unquote

import msgspec

from data_schema.errors import InputRefused
from labbook.export.archive import ASK_AGAIN, Member

METADATA = "ro-crate-metadata.json"
RO_CRATE = "https://w3id.org/ro/crate/1.1"
_CONTEXT = f"{RO_CRATE}/context"
_SPDX = "https://spdx.org/licenses/"
NO_LICENSE = "#no-license"
_SHA256 = re.compile(r"[0-9a-f]{64}")

FORMATS: Mapping[str, str] = {
    ".bib": "application/x-bibtex",
    ".csv": "text/csv",
    ".html": "text/html",
    ".json": "application/json",
    ".jsonl": "application/jsonl",
    ".md": "text/markdown",
    ".parquet": "application/vnd.apache.parquet",
    ".pdf": "application/pdf",
    ".svg": "image/svg+xml",
    ".tex": "application/x-tex",
    ".toml": "application/toml",
    ".zst": "application/zstd",
}
"""Media types by the ending of a name; a file without a known one is text."""

DESCRIPTIONS: Mapping[str, str] = {
    "VERIFY.md": "What this is, and how to check it",
    "SHA256SUMS": "The hash of each file, as sha256sum --check reads it",
    "journal.jsonl": "Every statement of a person, a line each, chained by hashes",
    "labbook.toml": "The configuration of the study that was in force",
    "data_dictionary.csv": "What each column of the tables means",
    "datapackage.json": "The tables as a Frictionless data package",
    "analysis.json": "What was decided about the analysis, when and by whom, and what departs from it",
    "origin.json": "What was left out of the book's journal for sharing, and where that ends",
    "report/numbers.json": "The report's numbers, unrounded, and what each rests on",
    "report/report.html": "The report",
}
FOLDERS: Mapping[str, str] = {
    "raw": "The files of the instruments, byte for byte, each compressed by zstd and named after its SHA-256",
    "signals": "The samples that were read from them",
    "tables": "What was measured, as tables",
    "report": "The report, with its figures and tables",
}


@dataclass(frozen=True, slots=True)
class About:
    """What a crate says of itself: the study, its people by initials, the licence, and where it comes from.

    `head` is the hash of the journal's last entry, which was stated at `at_utc`; `version` that of labbook. `license`
    is an SPDX identifier or an address, None where none was given.
    """

    name: str
    description: str
    people: Mapping[str, str]
    license: str | None
    entries: int
    head: str
    at_utc: str
    version: str


def crate_bytes(about: About, members: Iterable[Member]) -> bytes:
    """Write the metadata of a crate with these files; the same for the same."""
    files = {one.path: one for one in members}
    parts: dict[str, list[str]] = defaultdict(list)
    for path in sorted(files):
        place = PurePosixPath(path)
        top = place.parts[0] if len(place.parts) > 1 else ""
        parts[top].append(path)
    folders = [folder for folder in parts if folder]
    authors = [{"@id": _person_id(initials)} for initials in about.people]
    license_id = _license_id(about.license)
    day = about.at_utc[:10]
    graph: list[dict[str, Any]] = [
        {
            "@id": METADATA,
            "@type": "CreativeWork",
            "about": {"@id": "./"},
            "conformsTo": {"@id": RO_CRATE},
            "dateCreated": about.at_utc,
            "sdPublisher": {"@id": "#labbook"},
            "version": "1.0",
        },
        {
            "@id": "./",
            "@type": "Dataset",
            "name": about.name,
            "description": about.description,
            "datePublished": day,
            "dateModified": about.at_utc,
            "license": {"@id": license_id},
            "author": authors,
            "identifier": f"urn:sha256:{about.head}",
            "size": str(sum(one.n_bytes for one in files.values())),
            "hasPart": [*({"@id": _id(path)} for path in parts[""]), *({"@id": f"./{one}/"} for one in folders)],
        },
        *(
            {
                "@id": f"./{folder}/",
                "@type": "Dataset",
                "name": folder,
                "description": FOLDERS.get(folder, folder),
                "hasPart": [{"@id": _id(path)} for path in parts[folder]],
            }
            for folder in folders
        ),
        *(_file(files[path]) for path in sorted(files)),
        *(
            {"@id": _person_id(initials), "@type": "Person", "name": name, "alternateName": initials}
            for initials, name in about.people.items()
        ),
        _license(about.license),
        {
            "@id": "#labbook",
            "@type": "Organization",
            "name": "labbook",
            "description": f"Written by labbook {about.version} (the Python package robot-labbook)",
        },
    ]
    return (json.dumps({"@context": _CONTEXT, "@graph": graph}, indent=1, ensure_ascii=False) + "\n").encode()


def _file(one: Member) -> dict[str, Any]:
    place = PurePosixPath(one.path)
    described = DESCRIPTIONS.get(one.path) or FOLDERS.get(place.parts[0])
    return {
        "@id": _id(one.path),
        "@type": "File",
        "name": place.name,
        **({"description": described} if described else {}),
        "encodingFormat": FORMATS.get(place.suffix, "text/plain"),
        "contentSize": str(one.n_bytes),
        "sha256": one.sha256,
    }


def _id(path: str) -> str:
    return f"./{quote(path)}"


def _person_id(initials: str) -> str:
    return f"#person-{quote(initials, safe='')}"


def _license_id(given: str | None) -> str:
    if given is None:
        return NO_LICENSE
    return given if "://" in given else f"{_SPDX}{quote(given)}.html"


def _license(given: str | None) -> dict[str, Any]:
    said = "All rights are with its authors: ask them before you use it." if given is None else f"Licence: {given}"
    return {
        "@id": _license_id(given),
        "@type": "CreativeWork",
        "name": given or "no licence was given",
        "description": said,
    }


@dataclass(frozen=True, slots=True)
class StatedFile:
    """How many bytes a crate states for a file, and their SHA-256."""

    n_bytes: int
    sha256: str


class _Node(msgspec.Struct, frozen=True):
    """What is read of an entity."""

    id: str = msgspec.field(name="@id", default="")
    type: str | list[str] = msgspec.field(name="@type", default="")
    size: str | int | None = msgspec.field(name="contentSize", default=None)
    sha256: str | None = None


class _Graph(msgspec.Struct, frozen=True):
    nodes: list[_Node] = msgspec.field(name="@graph")


def stated_files(metadata: bytes) -> dict[str, StatedFile]:
    """Return the files that a crate states, by their paths below its folder.

    Raises `InputRefused` where it is not the JSON of a crate, or states a file twice or without size or hash.
    """
    try:
        nodes: Sequence[_Node] = msgspec.json.decode(metadata, type=_Graph).nodes
    except (msgspec.DecodeError, msgspec.ValidationError, UnicodeDecodeError, RecursionError) as error:
        raise InputRefused(f"{METADATA} in the archive cannot be read ({error}): {ASK_AGAIN}.") from error
    found: dict[str, StatedFile] = {}
    for node in nodes:
        if node.type != "File" and "File" not in list(node.type):
            continue
        path = unquote(node.id).removeprefix("./")
        digits = str(node.size)
        if path in found or not _SHA256.fullmatch(node.sha256 or "") or not re.fullmatch("[0-9]{1,15}", digits):
            raise InputRefused(
                f"{METADATA} in the archive states {path[:200]!r} twice, or without its size or SHA-256: {ASK_AGAIN}."
            )
        found[path] = StatedFile(int(digits), node.sha256 or "")
    return found
