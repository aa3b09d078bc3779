from pathlib import Path

import pytest

from data_schema.disk import NETWORK_FILE_SYSTEMS, file_system_of, refuse_network_drive
from data_schema.errors import UsageError


@pytest.fixture
def mounts(tmp_path: Path) -> Path:
    """A table of mounts as a lab's computer has it, with `tmp_path` standing for the root of its disk."""
    table = tmp_path / "mounts"
    lines = [
        f"/dev/sda1 {tmp_path} ext4 rw,relatime 0 0",
        f"nas:/lab {tmp_path}/lab nfs4 rw,vers=4.2 0 0",
        f"/dev/sdb1 {tmp_path}/lab/local xfs rw 0 0",
        f"//nas/my\\040share {tmp_path}/my\\040share cifs rw 0 0",
        f"/dev/sdc1 {tmp_path}/covered ext4 rw 0 0",
        f"ada@rig:/data {tmp_path}/covered fuse.sshfs rw 0 0",
    ]
    table.write_text("\n".join(lines) + "\n")
    return table


@pytest.mark.parametrize(
    ("folder", "kind"),
    [
        *(("book", "ext4"), ("lab", "nfs4"), ("lab/book", "nfs4"), ("laboratory/book", "ext4")),
        *(("lab/local/book", "xfs"), ("my share/book", "cifs"), ("covered/book", "fuse.sshfs")),
    ],
)
def test_the_longest_mount_point_above_a_file_decides(mounts: Path, folder: str, kind: str) -> None:
    path = mounts.parent / folder / "labbook.db"
    assert file_system_of(path, mounts) == kind
    if kind in NETWORK_FILE_SYSTEMS:
        with pytest.raises(UsageError, match=f"network drive .{kind}.*local disk.*PostgreSQL"):
            refuse_network_drive(path, mounts)
    else:
        refuse_network_drive(path, mounts)


def test_a_link_to_a_network_drive_is_one(mounts: Path) -> None:
    (mounts.parent / "lab").mkdir()
    (mounts.parent / "link").symlink_to(mounts.parent / "lab")
    assert file_system_of(mounts.parent / "link" / "labbook.db", mounts) == "nfs4"


def test_a_system_without_a_table_of_mounts_is_trusted(tmp_path: Path) -> None:
    assert file_system_of(tmp_path, tmp_path / "missing") is None
    refuse_network_drive(tmp_path, tmp_path / "missing")
