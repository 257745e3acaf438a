"""Pages of the site that follow from the program: Markdown from the help of the command and from JSON schemas."""

import re

GROUP = re.compile(r"^(\S.*):$")
ENTRY = re.compile(r"^ {2}(\S.*?)(?: {2,}(\S.*))?$")
MORE = re.compile(r"^ {3,}(\S.*)$")

API = """# API reference

Made from the public headers by Doxygen:

- <a href="../api/annotated.html">classes and structs</a>
- <a href="../api/files.html">headers</a>
- <a href="../api/namespacepcl__gpu__icp.html">everything in the namespace pcl_gpu_icp</a>

[In a program](in-a-program.md) shows how they go together.
"""


def escaped(text):
    return re.sub(r"([\\`*_<>\[\]{}|])", r"\\\1", text)


def entries(text):
    """Of a help text: (group, entry, description), and (None, None, text) for a paragraph outside of groups."""
    group, found, continues = None, [], False
    for line in text.splitlines():
        if match := GROUP.match(line):
            group = match[1]
        elif group and (match := ENTRY.match(line)):
            found.append([group, match[1], match[2] or ""])
        elif group and found and (match := MORE.match(line)):
            found[-1][2] = f"{found[-1][2]} {match[1]}".strip()
        elif line and continues and not line.startswith("Usage: "):
            found[-1][2] += f" {line}"
        elif line:
            group = None
            found.append([None, None, line])
        continues = bool(line) and group is None and not line.startswith("Usage: ")
    return found


def entry_lines(entry, description):
    if entry.endswith(":"):  # an example and what it is for
        return ["", escaped(entry), "", f"    {description}"]
    return ["", "````{option} " + entry.replace(",-", ", -"), escaped(description), "````"]


def options(texts):
    """Of the help of each subcommand."""
    lines = ["# Every option", "", "As `--help` has it."]
    for name, text in texts.items():
        lines += ["", f"## {name}", "", f"```{{program}} pcl_gpu_icp {name}", "```"]
        last = None
        for group, entry, description in entries(text):
            if group and group != last:
                lines += ["", f"### {group}"]
            last = group
            if group:
                lines += entry_lines(entry, description)
            elif description.startswith("Usage: "):
                lines += ["", f"    {description[len('Usage: '):]}"]
            else:
                lines += ["", escaped(description)]
    return "\n".join(lines) + "\n"


def kind(schema):
    """Its type, in a word or two."""
    if "enum" in schema:
        return ", ".join(json_text(value) for value in schema["enum"])
    if "const" in schema:
        return json_text(schema["const"])
    kinds = schema.get("type", "")
    return " or ".join(kinds) if isinstance(kinds, list) else kinds


def json_text(value):
    return f'"{value}"' if isinstance(value, str) else str(value)


class Schemas:
    """Of docs/NAME.schema.json, by the names of their files."""

    def __init__(self, files):
        self.files = files

    def resolved(self, schema, file):
        """Without a $ref of its own, and the file that what is in it stands in."""
        while "$ref" in schema:
            name, _, path = schema["$ref"].partition("#")
            file = name or file
            target = self.files[file]
            for part in filter(None, path.split("/")):
                target = target[part]
            schema = {**target, **{key: value for key, value in schema.items() if key != "$ref"}}
        return schema, file

    def rows(self, schema, file, path=""):
        """(key, type, description) of what a schema of objects has, outside in."""
        schema, file = self.resolved(schema, file)
        for key, value in schema.get("properties", {}).items():
            full = f"{path}.{key}" if path else key
            target, _ = self.resolved(value, file)
            yield full, kind(target), target.get("description", "")
            yield from self.rows(value, file, full)
        if isinstance(schema.get("items"), dict):
            yield from self.rows(schema["items"], file, path + "[]")


def keys(files):
    """Of each schema, by the name of its file, what its output has."""
    schemas = Schemas(files)
    names = ", ".join(f"[{file}]({file})" for file in files)
    lines = ["# Every key of the JSON", "", f"As the schemas have it: {names}."]
    for file, schema in files.items():
        lines += ["", f"## {schema['title']}", "", escaped(schema.get("description", ""))]
        for variant in schema.get("anyOf", [schema]):
            if "$ref" in variant:
                lines += ["", f"### {variant['$ref'].rsplit('/', 1)[-1].capitalize()}"]
            variant, at = schemas.resolved(variant, file)
            lines += ["", "| key | what it is |", "|---|---|"]
            lines += [f"| `{key}` | {'. '.join(filter(None, [f'*{escaped(type_)}*', escaped(text)]))} |"
                      for key, type_, text in schemas.rows(variant, at)]
    return "\n".join(lines) + "\n"


def decisions(names):
    """The contents of docs/decisions."""
    return "\n".join(["# Decisions", "", "Why things are as they are.", "", "```{toctree}", *(f"decisions/{name}" for name in names), "```", ""])
