"""Runs the built command, and the clouds that its tests are made of."""

import functools
import json
import math
import os
import pathlib
import pty
import random
import shutil
import struct
import subprocess
import tempfile
import threading
import unittest

COMMAND = os.environ["PCL_GPU_ICP_COMMAND"]
SCHEMA = pathlib.Path(os.environ["PCL_GPU_ICP_SCHEMA"])
SANITIZED = os.environ.get("PCL_GPU_ICP_SANITIZED") == "1"

# What a first start on a slow machine says.
SLOW_START = "pcl_gpu_icp: compiling kernels for this device, once: later starts do without\n"

SUCCESS, NOT_CONVERGED, USAGE, INPUT, DEVICE, OUTPUT, INTERNAL = 0, 1, 2, 3, 4, 5, 70


class CommandTest(unittest.TestCase):
    """Each test has a directory of its own."""

    def setUp(self):
        self.directory = pathlib.Path(tempfile.mkdtemp(prefix="pcl_gpu_icp_test_"))
        self.addCleanup(shutil.rmtree, self.directory)

    def path(self, name):
        return str(self.directory / name)

    def write(self, name, content):
        """Writes a file, bytes or text, and returns its name."""
        path = self.directory / name
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return str(path)

    def run_command(self, *arguments, environment=None, **settings):
        done = subprocess.run(
            [COMMAND, *map(str, arguments)],
            **({} if "input" in settings else {"stdin": subprocess.DEVNULL}),
            stdout=settings.pop("stdout", subprocess.PIPE),
            stderr=settings.pop("stderr", subprocess.PIPE),
            env={**os.environ, **(environment or {})},
            text=True,
            timeout=300,
            **settings,
        )
        if done.stderr:
            done.stderr = done.stderr.replace(SLOW_START, "")
        return done

    def succeed(self, *arguments, **settings):
        done = self.run_command(*arguments, **settings)
        self.assertEqual((done.returncode, done.stderr), (SUCCESS, ""), done)
        return done.stdout

    def fail_with(self, code, *arguments, names=(), **settings):
        """The command must end with that code and one line on stderr that has every one of the names in it."""
        done = self.run_command(*arguments, **settings)
        self.assertEqual(done.returncode, code, done)
        self.assertRegex(done.stderr, r"\Apcl_gpu_icp: [^\n]+\n\Z")
        for name in [names] if isinstance(names, str) else names:
            self.assertIn(name, done.stderr)
        return done

    def align(self, *arguments):
        """Aligns and returns the JSON, checked against the schema."""
        return self.checked(self.succeed("align", *arguments, "--json", "-"))

    def checked(self, text, schema_file=SCHEMA):
        result = json.loads(text, parse_constant=lambda constant: self.fail(f"{constant} is not JSON"))
        schema = read_schema(schema_file)
        errors = schema_errors(result, schema, schema, "result")
        self.assertEqual(errors, [])
        return result

    def on_terminal(self, *arguments, code=SUCCESS, stdout_too=False):
        """Standard output, where that is no terminal, and what a terminal on stderr saw."""
        controller, terminal = pty.openpty()
        seen = bytearray()

        def read():
            try:
                while chunk := os.read(controller, 4096):
                    seen.extend(chunk)
            except OSError:  # how Linux says that the other side is closed
                pass

        reader = threading.Thread(target=read)
        reader.start()
        done = self.run_command(*arguments, stderr=terminal, **({"stdout": terminal} if stdout_too else {}))
        os.close(terminal)
        reader.join()
        os.close(controller)
        self.assertEqual(done.returncode, code)
        return done.stdout, seen.decode()

    def assert_maps(self, transform, source, target, tolerance):
        for p, q in zip(source, target):
            self.assertLess(math.dist(moved(transform, p), q), tolerance)

    def shared(self, name):
        path = pathlib.Path(os.environ["PCL_GPU_ICP_SHARED_DATA"]) / name
        if not path.exists():
            self.skipTest(f"{path} is not there: set PCL_GPU_ICP_SHARED_DATA to the folder with the real scans")
        return str(path)

    def run_as_nobody(self, *arguments):
        """As a user whom permissions bind, which they do not root."""
        if os.geteuid() != 0:
            return self.run_command(*arguments)
        os.chmod(self.directory, 0o755)
        try:
            return self.run_command(*arguments, user=65534, group=65534, extra_groups=[])
        except PermissionError:
            self.skipTest("run as root from a folder that other users cannot enter")


@functools.lru_cache
def read_schema(path):
    return json.loads(path.read_text())


def schema_errors(value, schema, root, where):
    """What of JSON Schema the documented schema uses."""
    if "$ref" in schema:
        file, _, path = schema["$ref"].partition("#/")
        node = root = read_schema(SCHEMA.with_name(file)) if file else root
        for key in path.split("/"):
            node = node[key]
        return schema_errors(value, node, root, where)
    if "anyOf" in schema:
        tried = [schema_errors(value, choice, root, where) for choice in schema["anyOf"]]
        return min(tried, key=len)
    python_types = {
        "object": dict, "array": list, "string": str, "boolean": bool, "integer": int, "number": (int, float),
        "null": type(None)}
    allowed = schema.get("type", [])
    allowed = [allowed] if isinstance(allowed, str) else allowed
    if allowed and not any(
        isinstance(value, python_types[name]) and (name == "boolean" or not isinstance(value, bool)) for name in allowed
    ):
        return [f"{where} is {value!r}, not {allowed}"]
    errors = []
    if "enum" in schema and value not in schema["enum"]:
        errors.append(f"{where} is {value!r}, not one of {schema['enum']}")
    if "minimum" in schema and value is not None and value < schema["minimum"]:
        errors.append(f"{where} is {value!r}, below {schema['minimum']}")
    if isinstance(value, list):
        if not schema.get("minItems", 0) <= len(value) <= schema.get("maxItems", len(value)):
            errors.append(f"{where} has {len(value)} items")
        for i, item in enumerate(value):
            errors += schema_errors(item, schema["items"], root, f"{where}[{i}]")
    if isinstance(value, dict):
        properties = schema.get("properties", {})
        errors += [f"{where} has no {key}" for key in schema.get("required", []) if key not in value]
        for key, item in value.items():
            if key in properties:
                errors += schema_errors(item, properties[key], root, f"{where}.{key}")
            elif schema.get("additionalProperties") is False:
                errors.append(f"{where} has an undocumented {key}")
            elif isinstance(schema.get("additionalProperties"), dict):
                errors += schema_errors(item, schema["additionalProperties"], root, f"{where}.{key}")
    return errors


# ------------------------------------------------------------------------------------------------------------ geometry

IDENTITY = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]


def motion(degrees, translation):
    """A rotation about (1, 2, 3) and a translation."""
    length = math.sqrt(14)
    x, y, z = 1 / length, 2 / length, 3 / length
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    d = 1 - c
    return [
        [c + x * x * d, x * y * d - z * s, x * z * d + y * s, translation[0]],
        [y * x * d + z * s, c + y * y * d, y * z * d - x * s, translation[1]],
        [z * x * d - y * s, z * y * d + x * s, c + z * z * d, translation[2]],
        [0, 0, 0, 1],
    ]


def moved(matrix, point):
    return tuple(sum(row[i] * point[i] for i in range(3)) + row[3] for row in matrix[:3])


def turned(matrix, vector):
    return tuple(sum(row[i] * vector[i] for i in range(3)) for row in matrix[:3])


def numbers(matrix):
    return [repr(float(value)) for row in matrix for value in row]


def surface(columns=24, rows=20):
    """A bumpy surface a few units wide, row by row, with no symmetry that could mislead an alignment."""
    return [
        (0.25 * i, 0.25 * j, 0.4 * math.sin(0.9 * 0.25 * i) * math.cos(1.3 * 0.25 * j) + 0.02 * i * 0.25 * j * 0.25)
        for j in range(rows)
        for i in range(columns)
    ]


# ----------------------------------------------------------------------------------------------------------- PCD files

XYZ = [("x", "F", 4, 1), ("y", "F", 4, 1), ("z", "F", 4, 1)]
XYZ_DOUBLE = [("x", "F", 8, 1), ("y", "F", 8, 1), ("z", "F", 8, 1)]
FORMATS = {("F", 4): "f", ("F", 8): "d", ("U", 1): "B", ("I", 1): "b", ("U", 2): "H", ("I", 2): "h", ("U", 4): "I",
           ("I", 4): "i", ("U", 8): "Q", ("I", 8): "q"}


def sampled_surface(count, seed):
    """Points of a smooth hilly surface, sampled at random."""
    generator = random.Random(seed)
    points = []
    for _ in range(count):
        x, y = generator.uniform(-2, 2), generator.uniform(-2, 2)
        points.append((x, y, 0.4 * math.sin(1.7 * x) * math.cos(1.3 * y) + 0.2 * x * y))
    return points


def pcd_header(fields, count, encoding, width=None, height=1, viewpoint="0 0 0 1 0 0 0"):
    column = lambda i: " ".join(str(field[i]) for field in fields)
    return (
        f"# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS {column(0)}\nSIZE {column(2)}\n"
        f"TYPE {column(1)}\nCOUNT {column(3)}\nWIDTH {width or count}\nHEIGHT {height}\nVIEWPOINT {viewpoint}\n"
        f"POINTS {count}\nDATA {encoding}\n"
    )


def pcd(points, encoding="ascii", fields=XYZ, **header):
    """The content of a PCD file; a point is the flat sequence of its values."""
    start = pcd_header(fields, header.pop("count", len(points)), encoding, **header).encode()
    if encoding == "ascii":
        return start + "".join(" ".join(repr(v) for v in point) + "\n" for point in points).encode()
    packing = "<" + "".join(FORMATS[kind, size] * count for _, kind, size, count in fields)
    rows = b"".join(struct.pack(packing, *point) for point in points)
    if encoding == "binary":
        return start + rows
    columns, at, step = [], 0, struct.calcsize(packing)
    for _, _, size, count in fields:
        columns += [rows[i * step + at : i * step + at + size * count] for i in range(len(points))]
        at += size * count
    plain = b"".join(columns)
    packed = b"".join(bytes([len(plain[i : i + 32]) - 1]) + plain[i : i + 32] for i in range(0, len(plain), 32))
    return start + struct.pack("<II", len(packed), len(plain)) + packed


def lzf_decompressed(data):
    out, i = bytearray(), 0
    while i < len(data):
        control = data[i]
        i += 1
        if control < 32:
            out += data[i : i + control + 1]
            i += control + 1
            continue
        length = control >> 5
        if length == 7:
            length += data[i]
            i += 1
        start = len(out) - ((control & 31) << 8) - data[i] - 1
        i += 1
        for k in range(length + 2):
            out.append(out[start + k])
    return bytes(out)


def read_pcd(path):
    """Header words and points of a binary_compressed PCD file, each point the flat tuple of its values."""
    content = pathlib.Path(path).read_bytes()
    start = content.index(b"DATA binary_compressed\n") + len(b"DATA binary_compressed\n")
    lines = [line.split() for line in content[:start].decode().splitlines() if not line.startswith("#")]
    header = {words[0]: words[1:] for words in lines}
    fields = list(
        zip(header["FIELDS"], header["TYPE"], map(int, header["SIZE"]), map(int, header["COUNT"])))
    count = int(header["POINTS"][0])
    packed, plain = struct.unpack_from("<II", content, start)
    data = lzf_decompressed(content[start + 8 : start + 8 + packed])
    assert len(data) == plain, (len(data), plain)
    columns, at = [], 0
    for _, kind, size, repeat in fields:
        step = size * repeat
        columns.append(
            [struct.unpack_from("<" + FORMATS[kind, size] * repeat, data, at + i * step) for i in range(count)])
        at += step * count
    return header, [sum(values, ()) for values in zip(*columns)]


# ----------------------------------------------------------------------------------------------------------- PLY files

PLY_FORMATS = {"float": "f", "double": "d", "uchar": "B", "int": "i", "uint": "I", "ushort": "H", "short": "h",
               "char": "b"}
PLY_XYZ = [("float", "x"), ("float", "y"), ("float", "z")]


def ply(points, encoding="ascii", properties=PLY_XYZ, before="", body_before=b"", after="", count=None):
    header = f"ply\nformat {encoding} 1.0\ncomment test\n{before}"
    header += f"element vertex {len(points) if count is None else count}\n"
    header += "".join(f"property {kind} {name}\n" for kind, name in properties) + after + "end_header\n"
    if encoding == "ascii":
        return header.encode() + body_before + "".join(" ".join(map(repr, p)) + "\n" for p in points).encode()
    packing = ("<" if "little" in encoding else ">") + "".join(PLY_FORMATS[kind] for kind, _ in properties)
    return header.encode() + body_before + b"".join(struct.pack(packing, *point) for point in points)


def read_ply(path):
    """Header lines, property names and points of a binary little-endian PLY file, behind which only a camera may be."""
    content = pathlib.Path(path).read_bytes()
    start = content.index(b"end_header\n") + len(b"end_header\n")
    header = content[:start].decode().splitlines()
    camera = header.index("element camera 1") if "element camera 1" in header else len(header)
    properties = [line.split()[1:] for line in header[:camera] if line.startswith("property ")]
    packing = "<" + "".join(PLY_FORMATS[kind] for kind, _ in properties)
    count = next(int(line.split()[2]) for line in header if line.startswith("element vertex"))
    step = struct.calcsize(packing)
    camera_size = 4 * sum(line.startswith("property ") for line in header[camera:])
    assert len(content) == start + count * step + camera_size
    points = [struct.unpack_from(packing, content, start + i * step) for i in range(count)]
    return header, [name for _, name in properties], points
