"""The fenced blocks of the project's pages."""

import pathlib
import re

ROOT = pathlib.Path(__file__).resolve().parents[3]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]


def blocks(page, language):
    """(line number, text) of each block of that language, without its indentation."""
    text = page.read_text()
    for match in re.finditer(rf"^( *)```{language}\n(.*?)^\1```$", text, re.MULTILINE | re.DOTALL):
        indented = match[2].splitlines(keepends=True)
        yield text.count("\n", 0, match.start()) + 2, "".join(line.removeprefix(match[1]) for line in indented)


def commands(block):
    """(command, the output that is shown) of a console block."""
    found = []
    for line in block.splitlines():
        if line.startswith("$ "):
            found.append([line[2:], []])
        else:
            found[-1][1].append(line)
    return found
