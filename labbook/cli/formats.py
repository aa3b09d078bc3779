"""`labbook formats`: the file formats that can be read, labbook's own and those of plug-ins."""

from labbook.cli.common import JsonOption, columns, emit


def formats(as_json: JsonOption = False) -> None:
    """List the file formats, by what a file is recognised as one, and which plug-in a format comes from.

    Any other text with columns is read as delimited_log; what it does not say is declared with flags or a profile.

    Example: labbook formats
    """
    from ingest.formats.registry import described_formats, plugins

    found = described_formats()
    rows = [(each.name, str(each.version), each.plugin or "-", each.evidence, each.what) for each in found]
    faults = list(plugins().faults)
    more = "`--explain` of `labbook ingest` shows by what evidence a file was recognised, `--format` decides it."
    emit(
        {"formats": found, "faults": faults},
        [*columns(("format", "version", "plug-in", "recognised by", "what"), rows), more, *faults],
        as_json,
    )
