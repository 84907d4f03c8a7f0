# SPDX-License-Identifier: Apache-2.0
"""`python -m trackservo_report DIR`: reads a results folder, writes DIR/report.html and prints the result table."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from .load import InputError, load_results
from .markdown import differing_documents, update_document
from .page import write_page, write_picture
from .terminal import make_console, print_results


def main(arguments: list[str] | None = None) -> int:
    """0 when the report was written, whatever the results are; 1 when a document differs; 2 when the input cannot be used."""
    parser = argparse.ArgumentParser(prog="trackservo_report", description=__doc__)
    parser.add_argument("folder", type=Path, metavar="DIR", help="folder that 'sim_host experiments --out DIR' wrote")
    parser.add_argument(
        "--update", type=Path, nargs="+", default=[], metavar="FILE", help="also renew the marked tables of these documents"
    )
    parser.add_argument(
        "--check", type=Path, nargs="+", default=[], metavar="FILE", help="exit code 1 if the marked tables of these documents differ from the results"
    )
    parser.add_argument("--picture", type=Path, metavar="FILE", help="also write the picture of the first screen as an SVG file")
    options = parser.parse_args(arguments)
    folder: Path = options.folder
    page = folder / "report.html"
    try:
        results = load_results(folder)
        write_page(results, page)
        for document in options.update:
            update_document(results, document)
        if options.picture is not None:
            write_picture(results, options.picture)
        differing = differing_documents(results, options.check)
    except InputError as error:
        print(f"trackservo_report: {error}", file=sys.stderr)
        return 2
    except OSError as error:
        print(f"trackservo_report: {page}: cannot be written: {error.strerror}.", file=sys.stderr)
        return 2
    print_results(results, page, make_console())
    for document in differing:
        print(f"trackservo_report: {document}: its tables are not those of {folder}; run tools/update-docs results.", file=sys.stderr)
    return 1 if differing else 0


if __name__ == "__main__":
    sys.exit(main())
