"""--png: a picture of the result, whatever it is."""

import os
import struct
import zlib

from command import IDENTITY, NOT_CONVERGED, OUTPUT, USAGE, CommandTest, motion, moved, numbers, pcd, surface

POINTS = surface()
SOURCE = [moved(motion(3, (0.05, -0.08, 0.04)), point) for point in POINTS]


def width_of(path):
    with open(path, "rb") as file:
        start = file.read(24)
    assert start[:8] == b"\x89PNG\r\n\x1a\n"
    return struct.unpack(">I", start[16:20])[0]


def pixels(path):
    """The rows of a PNG file of 8 bits a channel as cairo writes them: bytes of red, green, blue."""
    with open(path, "rb") as file:
        data = file.read()
    at, packed = 8, b""
    while at < len(data):
        size, kind = struct.unpack_from(">I4s", data, at)
        body = data[at + 8 : at + 8 + size]
        if kind == b"IHDR":
            assert tuple(body[8:10]) == (8, 2)
        elif kind == b"IDAT":
            packed += body
        at += 12 + size
    plain = zlib.decompress(packed)
    rows, step = [], 3 * width_of(path)
    for start in range(0, len(plain), step + 1):
        row, above = bytearray(plain[start + 1 : start + 1 + step]), rows[-1] if rows else bytes(step)
        for i in range(step):
            left, corner = (row[i - 3], above[i - 3]) if i >= 3 else (0, 0)
            nearest = min((left, above[i], corner), key=lambda value: abs(left + above[i] - corner - value))
            row[i] = (row[i] + (0, left, above[i], (left + above[i]) // 2, nearest)[plain[start]]) & 255
        rows.append(bytes(row))
    return rows


class Picture(CommandTest):
    def setUp(self):
        super().setUp()
        self.source, self.target = self.write("source.pcd", pcd(SOURCE)), self.write("target.pcd", pcd(POINTS))
        self.png = self.path("out.png")

    def test_clouds_before_and_after(self):
        self.succeed("align", self.source, self.target, "--png", self.png, "--quiet")
        self.assertEqual(width_of(self.png), 1600)
        rows = pixels(self.png)
        colours = {row[i : i + 3] for row in rows for i in range(0, len(row), 3)}
        self.assertLessEqual({bytes.fromhex(c) for c in ("ffffff", "00795a")}, colours)  # the paper, and "good"
        orange, blue = bytes.fromhex("e69f00"), bytes.fromhex("0072b2")
        near = lambda a, b: sum(abs(x - y) for x, y in zip(a, b)) < 120
        before, after = rows[len(rows) // 6 : len(rows) * 2 // 5], rows[len(rows) * 2 // 5 : len(rows) * 2 // 3]
        count = lambda part, colour: sum(near(row[i : i + 3], colour) for row in part for i in range(0, len(row), 3))
        for colour in (orange, blue):
            self.assertGreater(count(before, colour), 1.5 * count(after, colour))  # what is of both is grey

    def test_where_there_is_no_answer_too(self):
        far = self.write("far.pcd", pcd([(x + 50, y, z) for x, y, z in POINTS]))
        self.fail_with(
            NOT_CONVERGED, "align", far, self.target, "--max-distance", "1", "--once", "--png", self.png, "--matrix",
            self.path("matrix.txt"), "--quiet")
        self.assertEqual(width_of(self.png), 1600)
        self.assertFalse(os.path.exists(self.path("matrix.txt")))

    def test_any_name_and_any_place(self):
        name = self.path("<b>\"'\n\t\udcff & " + 30 * "long " + ".pcd")
        for points in ([POINTS[7]] * 3, [(x + 5e5, y + 5e6, z) for x, y, z in POINTS], [*POINTS, (1e17, -1e17, 1e17)]):
            with open(name, "wb") as file:
                file.write(pcd(points))
            done = self.run_command(
                "align", name, name, "--guess", *numbers(IDENTITY), "--png", self.png, "--force", "--quiet",
                errors="replace")
            self.assertIn(done.returncode, (0, NOT_CONVERGED), done)
            self.assertEqual(width_of(self.png), 1600)

    def test_nothing_is_overwritten(self):
        for code, arguments in (
                (OUTPUT, ("--png", self.source)), (USAGE, ("--png", self.png, "--json", self.png)),
                (OUTPUT, ("--png", self.path("nowhere/out.png")))):
            self.fail_with(code, "align", self.source, self.target, *arguments, names="--png")
        self.assertEqual(sorted(os.listdir(self.directory)), ["source.pcd", "target.pcd"])
