#!/usr/bin/env python3
"""build.py COMMAND FOLDER: builds the documentation site in FOLDER/html. What the command and its JSON take comes from the
help of COMMAND and from the schemas, what the library has from its headers. Ends with 1 where a link leads nowhere, with 77
where what builds the site is not installed."""

import json
import pathlib
import shutil
import subprocess
import sys

import links
import pages

ROOT = pathlib.Path(__file__).resolve().parents[2]
BUILDERS = {"sphinx-build": "python3-sphinx, furo, python3-myst-parser", "doxygen": "doxygen"}
NOT_INSTALLED = 77
SUBCOMMANDS = ["align", "batch", "compare", "devices"]
SCHEMAS = ["align.schema.json", "batch.schema.json", "batch_summary.schema.json"]


def run(*command, **options):
    if subprocess.run(list(map(str, command)), **options).returncode:
        sys.exit(f"build.py: {command[0]} failed")


def help_of(command, *arguments):
    return subprocess.run([command, *arguments, "--help"], check=True, capture_output=True, text=True).stdout


def copy_pages(source):
    """The Markdown of the project and what it links to, in the places where it links to it."""
    shutil.rmtree(source, ignore_errors=True)
    shutil.copytree(ROOT / "docs", source / "docs", ignore=shutil.ignore_patterns("site", "__pycache__"))
    for name in ("BENCHMARK.md", "CHANGELOG.md", "CONTRIBUTING.md", "LICENSE"):
        shutil.copy(ROOT / name, source)
    shutil.copytree(ROOT / "samples", source / "samples")
    (source / "index.md").write_text((ROOT / "README.md").read_text() + (ROOT / "docs/site/contents.md").read_text())
    decisions = sorted(path.stem for path in (ROOT / "docs/decisions").glob("*.md"))
    (source / "docs/decisions.md").write_text(pages.decisions(decisions))


def write_reference(command, source):
    texts = {name: help_of(command, name) for name in SUBCOMMANDS}
    (source / "docs/options.md").write_text(pages.options(texts))
    schemas = {file: json.loads((ROOT / "docs" / file).read_text()) for file in SCHEMAS}
    (source / "docs/json.md").write_text(pages.keys(schemas))
    (source / "docs/api.md").write_text(pages.API)


def main():
    command, folder = (pathlib.Path(argument).resolve() for argument in sys.argv[1:3])
    missing = [packages for program, packages in BUILDERS.items() if not shutil.which(program)]
    if missing:
        print(f"build.py: not installed: {', '.join(missing)}; scripts/install-deps docs installs it")
        sys.exit(NOT_INSTALLED)
    source, html = folder / "source", folder / "html"
    shutil.rmtree(html, ignore_errors=True)
    copy_pages(source)
    write_reference(command, source)
    run("sphinx-build", "-W", "--keep-going", "-q", "-b", "html", "-d", folder / "doctrees", "-c", ROOT / "docs/site", source, html)
    settings = (ROOT / "docs/site/Doxyfile").read_text() + f"\nOUTPUT_DIRECTORY = {html}\n"
    run("doxygen", "-", cwd=ROOT, input=settings, text=True)
    broken = [f"{page.relative_to(html)}: {link} leads nowhere" for page, link in links.broken(html)
              if page.parent != html / "api"]  # Doxygen links to headings that it leaves out
    if broken:
        sys.exit("\n".join(broken))
    print(f"The site: {html / 'index.html'}")


if __name__ == "__main__":
    main()
