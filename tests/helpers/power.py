"""A disk that loses power: what a command did to its files, and what may be left of that at any moment.

The writes, renames and syncs of a real process, SQLite's among them, are recorded by strace. They are played on a model
of a file system that promises what POSIX does and no more: a file's bytes are on the disk when the file was synced, a
name in a folder when the folder was. What was not synced yet when the power goes may be there, or not, or in part.
"""

from __future__ import annotations

import os
import random
import re
import shutil
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

CALLS = (
    "openat,open,creat,write,writev,pwrite64,pwritev,pwritev2,ftruncate,truncate,fallocate,fsync,fdatasync,rename,"
    "renameat,renameat2,unlink,unlinkat,mkdir,mkdirat,rmdir,link,linkat,symlink,symlinkat,sendfile,copy_file_range"
)
LARGEST_WRITE = 1 << 24
"""Bytes of one write that are recorded."""
_LINE = re.compile(r"(?P<pid>\d+) +(?P<call>\w+)\((?P<arguments>.*)\) += (?P<result>-?\d+)(?P<rest>.*)", re.DOTALL)
_UNFINISHED = re.compile(r"(\d+) +(\w+\(.*) <unfinished \.\.\.>")
_RESUMED = re.compile(r"(\d+) +<\.\.\. \w+ resumed>(.*)")
_SHARED_MEMORY = "-shm"
"""SQLite's notes for readers: written through memory, worth nothing after a power cut, and not looked at then."""


def strace(log: Path) -> list[str]:
    """The words to put before a command so that what it does to files is written to `log`, every byte of it."""
    program = shutil.which("strace")
    assert program is not None
    words = ["-f", "-y", "-xx", "--seccomp-bpf"]
    return [program, *words, "-s", str(LARGEST_WRITE), "-e", f"trace={CALLS}", "-o", str(log)]


@dataclass(frozen=True, slots=True)
class Call:
    """One system call that succeeded: its name, its arguments as strace wrote them, and what it returned."""

    name: str
    arguments: tuple[str, ...]
    result: int
    rest: str


def calls(log: str) -> Iterator[Call]:
    """Read what strace wrote; a call during which another process went on counts from its end."""
    begun: dict[str, str] = {}
    for line in log.splitlines():
        if unfinished := _UNFINISHED.fullmatch(line):
            begun[unfinished[1]] = unfinished[2]
            continue
        if resumed := _RESUMED.fullmatch(line):
            line = f"{resumed[1]} {begun.pop(resumed[1])}{resumed[2]}"
        found = _LINE.fullmatch(line)
        if found is not None and not found["result"].startswith("-"):
            yield Call(found["call"], tuple(found["arguments"].split(", ")), int(found["result"]), found["rest"])


Content = bytearray | dict[str, "Node"]
Step = tuple[int, bytes] | int | tuple[tuple[str, "Node | None"], ...]
"""Bytes written at a place, the size a file is cut to, or names that a folder gets or, with None, loses."""
Left = dict[str, bytes | None]
"""What is there after a power cut: bytes of files and None for folders, by path; parents before what is in them."""
Choice = Callable[["Node"], list[Step]]
"""Which of the unsynced steps of a file or folder the disk has when the power goes."""


@dataclass(eq=False)
class Node:
    """A file or folder: what is on the disk for sure, and what was done to it since."""

    synced: Content
    unsynced: list[Step] = field(default_factory=list)
    now: Content = field(init=False)

    def __post_init__(self) -> None:
        self.now = self.synced.copy()

    def do(self, step: Step) -> None:
        """Change it in memory."""
        self.unsynced.append(step)
        _take(self.now, step)

    def sync(self) -> None:
        """Bring all of it to the disk."""
        self.synced, self.unsynced = self.now.copy(), []

    def left(self, choose: Choice) -> Content:
        """What is there after the power came back."""
        content = self.synced.copy()
        for step in choose(self):
            _take(content, step)
        return content


def _take(content: Content, step: Step) -> None:
    if isinstance(content, dict):
        assert isinstance(step, tuple)
        for name, node in step:
            assert isinstance(name, str)
            content.pop(name, None)
            if isinstance(node, Node):
                content[name] = node
    elif isinstance(step, int):
        del content[step:]
        content.extend(bytes(step - len(content)))
    else:
        offset, data = step
        assert isinstance(offset, int)
        assert isinstance(data, bytes)
        content.extend(bytes(max(0, offset - len(content))))
        content[offset : offset + len(data)] = data


class Disk:
    """A folder and all in it, on a disk that has synced everything so far."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.root = _node_of(folder)
        self._offsets: dict[int, int] = {}

    def play(self, call: Call) -> bool:
        """Do what a call did; tells whether it changed or synced anything here."""
        if call.name in ("openat", "open", "creat"):
            return self._open(call)
        if call.name in ("fsync", "fdatasync", "write", "pwrite64", "ftruncate", "sendfile"):
            path = self._of_descriptor(call.arguments[0])
            return path is not None and self._with_descriptor(call, path)
        places = [place for place in self._places(call) if place is not None]
        if not places or (call.name.startswith("symlink") and self._places(call)[-1] is None):
            return False
        if call.name.startswith("rename"):
            assert len(places) == 2, call
            self._rename(*places)
        elif call.name.startswith("mkdir"):
            self._name(places[0], Node({}))
        elif call.name.startswith(("unlink", "rmdir")):
            self._name(places[0], None)
        else:
            raise AssertionError(f"{call.name} is not modelled")
        return True

    def syncs(self, call: Call) -> bool:
        """Tell whether a call syncs something here."""
        return call.name in ("fsync", "fdatasync") and self._of_descriptor(call.arguments[0]) is not None

    def left(self, choose: Choice) -> Left:
        """What is there when the power comes back."""
        found: Left = {}
        _gather(self.root, choose, ".", found)
        return found

    def _open(self, call: Call) -> bool:
        flags = call.arguments[2 if call.name == "openat" else 1].split("|")
        (place, *_) = self._places(call)
        if place is None or "O_TMPFILE" in flags:
            return False
        changed = False
        if "O_CREAT" in flags and self._find(place) is None:
            self._name(place, Node(bytearray()))
            changed = True
        node = self._at(place)
        if "O_TRUNC" in flags and node.now:
            node.do(0)
            changed = True
        assert "O_APPEND" not in flags, call
        self._offsets[call.result] = 0
        return changed

    def _with_descriptor(self, call: Call, path: Path) -> bool:
        descriptor = int(call.arguments[0].split("<")[0])
        node = self._at(path)
        if call.name in ("fsync", "fdatasync"):
            node.sync()
        elif call.name == "ftruncate":
            node.do(int(call.arguments[1]))
        else:
            offset = int(call.arguments[3]) if call.name == "pwrite64" else self._offsets[descriptor]
            data = self._sent(call) if call.name == "sendfile" else _bytes(call.arguments[1])[: call.result]
            node.do((offset, data))
            if call.name != "pwrite64":
                self._offsets[descriptor] = offset + len(data)
        return True

    def _sent(self, call: Call) -> bytes:
        """The bytes that one file gave to another."""
        source = self._of_descriptor(call.arguments[1])
        assert source is not None, call
        content = self._at(source).now
        assert isinstance(content, bytearray)
        start = int(call.arguments[2][1:].partition("]")[0])
        return bytes(content[start : start + call.result])

    def _places(self, call: Call) -> list[Path | None]:
        """The paths among a call's arguments, None for one outside the folder."""
        found: list[Path | None] = []
        base = ""
        for argument in call.arguments:
            if "<" in argument:
                base = os.fsdecode(_bytes(argument[argument.index("<") :]))
            elif argument.startswith('"'):
                found.append(self._inside(Path(base, os.fsdecode(_bytes(argument)))))
        return found

    def _of_descriptor(self, argument: str) -> Path | None:
        if "<" not in argument or argument.endswith("(deleted)"):
            return None
        return self._inside(Path(os.fsdecode(_bytes(argument[argument.index("<") :]))))

    def _inside(self, path: Path) -> Path | None:
        return path.relative_to(self.folder) if path.is_relative_to(self.folder) else None

    def _find(self, place: Path) -> Node | None:
        node = self.root
        for part in place.parts:
            assert isinstance(node.now, dict)
            if part not in node.now:
                return None
            node = node.now[part]
        return node

    def _at(self, place: Path) -> Node:
        node = self._find(place)
        assert node is not None, place
        return node

    def _name(self, place: Path, node: Node | None) -> None:
        if self._find(place.parent) is None:  # its maker was killed after the call, and before strace saw that end
            self._name(place.parent, Node({}))
        self._at(place.parent).do(((place.name, node),))

    def _rename(self, old: Path, new: Path) -> None:
        node = self._at(old)
        if old.parent == new.parent:
            self._at(old.parent).do(((old.name, None), (new.name, node)))
        else:
            self._name(old, None)
            self._name(new, node)


def _node_of(path: Path) -> Node:
    if path.is_dir():
        return Node({entry.name: _node_of(entry) for entry in path.iterdir()})
    return Node(bytearray(path.read_bytes()))


def _gather(node: Node, choose: Choice, place: str, found: Left) -> None:
    content = node.left(choose)
    if isinstance(content, dict):
        found[place] = None
        for name, entry in content.items():
            _gather(entry, choose, f"{place}/{name}", found)
    else:
        found[place] = bytes(len(content)) if place.endswith(_SHARED_MEMORY) else bytes(content)


def lay(left: Left, folder: Path) -> None:
    """Write what is left into a new folder."""
    for place, content in left.items():
        if content is None:
            (folder / place).mkdir()
        else:
            (folder / place).write_bytes(content)


def _bytes(text: str) -> bytes:
    r"""Read `"\x41\x42"` or `<\x41\x42>`."""
    return bytes.fromhex(text[1:].rstrip('">)').replace("\\x", ""))


def nothing_unsynced(_node: Node) -> list[Step]:
    """The disk has what was synced and nothing else."""
    return []


def names_only(node: Node) -> list[Step]:
    """The disk has all names, and of the files what was synced."""
    return node.unsynced if isinstance(node.now, dict) else []


def bytes_only(node: Node) -> list[Step]:
    """The disk has all bytes, and of the folders what was synced."""
    return [] if isinstance(node.now, dict) else node.unsynced


def everything(node: Node) -> list[Step]:
    """The disk has all that was done, as when a process is killed and the power stays."""
    return node.unsynced


def by_chance(seed: int) -> Choice:
    """Names up to some moment; of the writes any, some of them cut off or with their bytes still zero."""
    chance = random.Random(seed)

    def choose(node: Node) -> list[Step]:
        if isinstance(node.now, dict):
            return node.unsynced[: chance.randint(0, len(node.unsynced))]
        kept: list[Step] = []
        for step in node.unsynced:
            fate = chance.random()
            if isinstance(step, int):
                kept += [step] * (fate < 0.6)
                continue
            offset, data = step
            assert isinstance(offset, int)
            assert isinstance(data, bytes)
            if fate < 0.5:
                kept.append((offset, data))
            elif fate < 0.7:
                kept.append((offset, data[: chance.randint(0, len(data))]))
            elif fate < 0.8:
                kept.append((offset, bytes(len(data))))
        return kept

    return choose
