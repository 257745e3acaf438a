"""Files in: every kind that is read, and every lie that is found out in one line, exit 3."""

import math
import os
import resource
import struct
import subprocess

from command import (
    INPUT, INTERNAL, PLY_XYZ, SANITIZED, USAGE, XYZ, XYZ_DOUBLE, CommandTest, motion, moved, numbers, pcd, pcd_header, ply, read_pcd,
    read_ply, surface)

POINTS = surface()
MOTION = motion(3, (0.05, -0.08, 0.04))
TARGET = [moved(MOTION, point) for point in POINTS]
NAN = float("nan")


class BadInputs(CommandTest):
    def refuse(self, content, *why):
        """Refused as the source and as the target, with the file named."""
        good = self.write("good.pcd", pcd(POINTS))
        bad = self.write("bad.file", content)
        self.fail_with(INPUT, "align", bad, good, names=[bad, *why])
        self.fail_with(INPUT, "align", good, bad, names=[bad, *why])
        self.fail_with(INPUT, "compare", bad, good, names=[bad, *why])

    def test_not_a_readable_file(self):
        good = self.write("good.pcd", pcd(POINTS))
        self.fail_with(INPUT, "align", self.path("none.pcd"), good, names=["none.pcd", "No such file"])
        self.fail_with(INPUT, "align", good, self.directory, names=[str(self.directory), "is a directory"])
        os.mkfifo(self.path("pipe.pcd"))
        self.fail_with(INPUT, "align", self.path("pipe.pcd"), good, names=["pipe.pcd", "not a regular file"])

    def test_unreadable_file(self):
        good = self.write("good.pcd", pcd(POINTS))
        os.chmod(good, 0)
        done = self.run_as_nobody("align", good, good)
        self.assertEqual((done.returncode, done.stderr), (INPUT, f"pcl_gpu_icp: {good}: Permission denied\n"))

    def test_no_cloud_file(self):
        self.refuse(b"", "is empty")
        self.refuse(b"hello\n", "not a PCD or PLY file")
        self.refuse(b"\0" * 1000, "a format that is not read")
        self.refuse(os.urandom(5000), "")
        self.refuse(pcd(POINTS).split(b"DATA")[0], "no DATA line")

    def test_no_points(self):
        self.refuse(pcd([]), "no points")
        self.refuse(pcd([(NAN, NAN, NAN)] * 10), "10 are not finite")
        self.refuse(ply([]), "no points")

    def test_zero_returns_only(self):
        zeros = self.write("zeros.pcd", pcd([(0.0, 0.0, 0.0)] * 7))
        self.fail_with(INPUT, "align", zeros, zeros, "--drop-zero-returns", names=[zeros, "7 are zero returns"])

    def test_missing_coordinates(self):
        for missing in range(3):
            fields = [field for i, field in enumerate(XYZ) if i != missing]
            self.refuse(pcd([(1.0, 2.0)] * 5, fields=fields), "no field " + "xyz"[missing])
        self.refuse(ply([(1.0, 2.0)] * 5, properties=[("float", "x"), ("float", "y")]), "no field z")

    def test_coordinates_that_are_not_one_number(self):
        self.refuse(pcd([(1.0, 2.0, 3.0, 4.0)] * 5, fields=[("x", "F", 4, 2)] + XYZ[1:]), "field x")

    def test_header_promises_more_points_than_there_are(self):
        for encoding in ("ascii", "binary", "binary_compressed"):
            with self.subTest(encoding):
                self.refuse(pcd(POINTS, encoding, count=len(POINTS) + 1), "header promises")
                self.refuse(pcd(POINTS, encoding, count=4000000000), "")
                self.refuse(pcd(POINTS, encoding, count=300000000), "header promises")
        for encoding in ("ascii", "binary_little_endian", "binary_big_endian"):
            with self.subTest(encoding):
                self.refuse(ply(POINTS, encoding, count=len(POINTS) + 1), "header promises")
                self.refuse(ply(POINTS, encoding, count=4000000000), "")

    def test_fewer_points_promised_than_there_are(self):
        self.refuse(pcd(POINTS, count=len(POINTS) - 1), "more points than")

    def test_truncated(self):
        for encoding in ("ascii", "binary", "binary_compressed"):
            whole = pcd(POINTS, encoding)
            for cut in (100, 2000):
                with self.subTest(encoding=encoding, cut=cut):
                    self.refuse(whole[:-cut], "")
        for encoding in ("ascii", "binary_little_endian"):
            with self.subTest(encoding):
                self.refuse(ply(POINTS, encoding)[:-100], "")

    def test_corrupt_compressed_data(self):
        whole = pcd(POINTS, "binary_compressed")
        start = whole.index(b"compressed\n") + len(b"compressed\n")
        packed, plain = struct.unpack_from("<II", whole, start)
        body = whole[start + 8 :]
        self.refuse(whole[:start] + struct.pack("<II", packed, plain + 1) + body, "promises")
        self.refuse(whole[:start] + struct.pack("<II", packed + 1, plain) + body, "ends after")
        self.refuse(whole[:start] + struct.pack("<II", packed, plain) + b"\xff" * packed, "corrupt")
        self.refuse(whole[:start] + struct.pack("<II", 5, plain) + body, "corrupt")
        self.refuse(whole[:start], "")

    def test_header_that_contradicts_itself(self):
        header = pcd_header(XYZ, 2, "ascii")
        body = "1 2 3\n4 5 6\n"
        for old, new, why in [
            ("WIDTH 2", "WIDTH 3", "POINTS"),
            ("WIDTH 2", "WIDTH -2", "WIDTH"),
            ("WIDTH 2", "WIDTH many", "WIDTH"),
            ("POINTS 2", "POINTS 1e9", "POINTS"),
            ("SIZE 4 4 4", "SIZE 4 4", "SIZE has 2 entries"),
            ("SIZE 4 4 4", "SIZE 3 4 4", "SIZE 3"),
            ("TYPE F F F", "TYPE F F", "TYPE has 2 entries"),
            ("TYPE F F F", "TYPE Q F F", "TYPE Q"),
            ("COUNT 1 1 1", "COUNT 1 1 0", "more values than there are fields"),
            ("COUNT 1 1 1", "COUNT 0 0 0", "points of no bytes"),
            ("COUNT 1 1 1", "COUNT 1 1 -1", "COUNT"),
            ("COUNT 1 1 1", "COUNT 1 1 99999999", "1048576 bytes each"),
            ("WIDTH 2", "WIDTH 18446744073709551615\nHEIGHT 2", "beyond 64 bits"),
            ("WIDTH 2", "WIDTH 4294967296\nHEIGHT 4294967296", "POINTS"),
            ("FIELDS x y z", "FIELDS", "FIELDS"),
            ("DATA ascii", "DATA morse", "DATA morse"),
            ("VIEWPOINT 0 0 0 1 0 0 0", "VIEWPOINT 0 0", "VIEWPOINT"),
            ("VIEWPOINT 0 0 0 1 0 0 0", "VIEWPOINT 0 0 0 1 0 0 north", "VIEWPOINT"),
        ]:
            with self.subTest(new):
                self.assertIn(old, header)
                self.refuse(header.replace(old, new).replace("HEIGHT 2\nHEIGHT 1", "HEIGHT 2") + body, why)

    def test_values_that_are_no_numbers(self):
        header = pcd_header(XYZ, 2, "ascii")
        self.refuse(header + "1 2 3\n4 five 6\n", "point 2, field y: 'five'")
        self.refuse(header + "1 2 3\n4 5,5 6\n", "point 2, field y: '5,5'")
        self.refuse(header + "0,1 0,2 0,3\n4 5 6\n", "field x: '0,1'", "decimal commas: tr , . < ")
        self.refuse(header + "1,2,3\n4,5,6\n", "field x: '1,2,3'", "commas between values: tr , ' ' < ")
        self.refuse(header + "1 2 3\n4 0x 6\n", "'0x'")
        self.refuse(header + "1 2 3\n4 1.#Q 6\n", "'1.#Q'")
        self.refuse(header + "1 2 3\n4 nano 6\n", "'nano'")
        self.refuse(header + "1 2 3.25\n4 5\n", "point 2, field z: is missing")
        self.refuse(header + "1 2 3 4\n4 5 6\n", "point 1 has more values")
        self.refuse("ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n"
                    "end_header\n1 two 3\n", "vertex 1, property y: 'two'")

    def test_ply_headers(self):
        good = ply(POINTS).decode()
        for old, new, why in [
            ("format ascii 1.0", "format morse 1.0", "morse"),
            ("format ascii 1.0\n", "", "no format"),
            ("element vertex 480", "element vertex many", "vertex"),
            ("element vertex", "element corner", "no element vertex"),
            ("property float z", "property quad z", "quad"),
            ("property float z", "property list uchar float z", "property z"),
            ("property float z", "property list float float z", "length is no integer"),
            ("property float z", "property float z\nproperty uchar", "element vertex has a property without a name"),
            ("comment test", "property float q", "property of no element"),
            ("end_header", "end_footer", "does not end"),
        ]:
            with self.subTest(new):
                self.assertIn(old, good)
                self.refuse(good.replace(old, new, 1), why)
        self.refuse("ply\nformat ascii 1.0\n", "does not end")

    def test_sizes_that_wrap_32_bits(self):
        """Fields of 2^32 bytes altogether, before which there may be three of coordinates."""
        names = ["a"] * 8192
        for first, encoding, body in [
            ([], "binary", b"\0" * 64),
            (["x", "y", "z"], "binary", struct.pack("<12f", *range(12))),
            (["x", "y", "z"], "binary_compressed", struct.pack("<II", 50, 48) + b"\x1f" + b"\0" * 49),
            (["x", "y", "z"], "ascii", b"1 2 3\n"),
        ]:
            fields = [(name, "F", 4, 1) for name in first] + [(name, "F", 8, 65536) for name in names]
            for count in (1, 4):
                with self.subTest(encoding=encoding, first=first, count=count):
                    self.refuse(pcd_header(fields, count, encoding).encode() + body, "1048576 bytes each")
        many = [(f"f{i}", "U", 1, 1) for i in range(4097)]
        self.refuse(pcd_header(many, 1, "binary").encode() + b"\0" * 5000, "more than 4096 fields")
        properties = [("uchar", f"f{i}") for i in range(4097)]
        self.refuse(ply([], "binary_little_endian", properties, count=1) + b"\0" * 5000, "more than 4096 fields")

    def test_promises_beyond_the_file_take_no_memory(self):
        if SANITIZED:
            self.skipTest("a sanitizer's own memory is beyond the limit")
        good = self.write("good.pcd", pcd(POINTS))
        limit = lambda: resource.setrlimit(resource.RLIMIT_AS, (1 << 30, 1 << 30))
        wide = [*XYZ, ("histogram", "F", 8, 100000)]
        faces = "element face 4000000000\nproperty list uint int vertex_indices\n"
        little = "binary_little_endian"
        contents = [
            *(pcd(POINTS, encoding, count=count)
              for encoding in ("ascii", "binary", "binary_compressed") for count in (300000000, 10**12)),
            *(ply(POINTS, encoding, count=count) for encoding in ("ascii", little) for count in (4 * 10**9, 10**18)),
            pcd_header(wide, 5000, "binary").encode() + b"\0" * 1000,
            pcd_header(wide, 5000, "binary_compressed").encode() + struct.pack("<II", 100, 5000 * 800012) + b"\0" * 100,
            ply(POINTS, little, before=faces, body_before=struct.pack("<I", 2**32 - 1)),
            ply(POINTS, "ascii", before=faces, body_before=b"4294967295 1 2 3\n"),
        ]
        for number, content in enumerate(contents):
            with self.subTest(number):
                bad = self.write("bad.file", content)
                self.fail_with(INPUT, "align", good, bad, names=bad, preexec_fn=limit)

    def test_ply_ends_within_an_element_before_the_vertices(self):
        before = "element junk 3\nproperty list uchar int values\n"
        self.refuse(ply(POINTS, "binary_little_endian", before=before, body_before=b"\xff"), "")

    def test_guess_file_that_is_no_rigid_transform(self):
        cloud = self.write("a.pcd", pcd(POINTS))
        self.fail_with(INPUT, "align", cloud, cloud, "--guess", self.path("none.txt"), names="none.txt")
        self.fail_with(INPUT, "align", cloud, cloud, "--guess", "", names="No such file")
        for content in ("", "1 0 0", "1 0 0 0\n" * 4, "1 0 0 x\n" * 4, "2 0 0 0 0 2 0 0 0 0 2 0 0 0 0 1"):
            guess = self.write("guess.txt", content)
            self.fail_with(INPUT, "align", cloud, cloud, "--guess", guess, names=guess)

    def test_one_line_even_for_a_name_with_a_line_break(self):
        self.fail_with(INPUT, "align", self.path("two\nlines.pcd"), self.path("none.pcd"), names="two lines.pcd")

    def test_larger_than_memory(self):
        if SANITIZED:
            self.skipTest("a sanitizer's allocator aborts where the real one throws")
        with open(self.path("sparse.pcd"), "wb") as file:
            file.truncate(8 << 30)
        limit = lambda: resource.setrlimit(resource.RLIMIT_AS, (2 << 30, 2 << 30))
        self.fail_with(INTERNAL, "align", self.path("sparse.pcd"), self.path("sparse.pcd"), preexec_fn=limit,
                       names="out of memory")


class ForeignFiles(CommandTest):
    """Files of other formats, and the command that makes clouds of them."""

    ROWS = "".join("%r %r %r\n" % point for point in POINTS)

    def refuse(self, name, content, *words):
        good = self.write("good.pcd", pcd(POINTS))
        path = self.write(name, content)
        return self.fail_with(INPUT, "align", path, good, names=[path, *words]).stderr.rstrip("\n")

    def test_what_it_looks_like(self):
        for name, content, *words in [
            ("a.pcd.gz", b"\x1f\x8b\x08" + os.urandom(99), "gzip", "gunzip -k "),
            ("a.ply", b"BZh91AY" + os.urandom(99), "bzip2", "bunzip2 -k "),
            ("a.pcd", b"\xfd7zXZ\0" + os.urandom(99), "xz", "unxz -k "),
            ("a.pcd", b"\x28\xb5\x2f\xfd" + os.urandom(99), "zstd", "zstd -d "),
            ("a.zip", b"PK\x03\x04" + os.urandom(99), "zip", "unzip "),
            ("a.laz", b"LASF" + bytes(100) + b"\x81" + bytes(271), "LAZ", "laspy decompress "),
            ("a.e57", b"ASTM-E57" + bytes(99), "E57", "pip install pye57"),
            ("a.pcd", "version https://git-lfs.github.com/spec/v1\noid sha256:00\nsize 123\n", "Git LFS", "git lfs pull"),
            ("a.pcd", "<!DOCTYPE html>\n<html><body>404</body></html>\n", "HTML", "download"),
            ("a.pcd", '{"message": "Not Found"}\n', "JSON"),
            ("a.obj", "# Blender\nmtllib a.mtl\n" + "".join("v %r %r %r\n" % p for p in POINTS), "OBJ", "pcl_obj2pcd "),
            ("a.stl", "solid x\nendsolid x\n", "STL", "pcl_converter "),
            ("a.stl", bytes(80) + struct.pack("<I", 1) + bytes(50), "STL", "pcl_converter "),
            ("a.pcd", "FIELDS x y z\n".encode("utf-16"), "UTF-16", "iconv "),
        ]:
            with self.subTest(name=name, words=words):
                self.refuse(name, content, *words)

    def test_the_command_makes_a_cloud(self):
        """Of meshes in text a header makes a cloud: the command that is printed is run."""
        for name, content in [
            ("points.off", f"OFF\n{len(POINTS)} 1 0\n{self.ROWS}3 0 1 2\n"),
            ("points.off", f"OFF\n# by hand\n\n{len(POINTS)} 0 0\n{self.ROWS}"),
            ("my points.off", f"OFF\n{len(POINTS)} 0 0\n{self.ROWS}"),
            ("it's.off", f"OFF\n{len(POINTS)} 0 0\n{self.ROWS}"),
        ]:
            with self.subTest(name):
                line = self.refuse(name, content, "looks like", ": (printf ")
                command = line[line.index(": (printf ") + 2 :]
                subprocess.run(command, shell=True, check=True, cwd=self.directory)
                made = command.rsplit(" > ", 1)[1]
                made = subprocess.run(f"printf %s {made}", shell=True, check=True, capture_output=True, text=True).stdout
                self.assertTrue(made.endswith(".pcd"))
                result = self.align(made, self.write("target.pcd", pcd(TARGET)))
                self.assertEqual(result["points"]["source"], len(POINTS))
                self.assert_maps(result["transform"], POINTS, TARGET, 1e-4)
                os.remove(made)


class GoodInputs(CommandTest):
    def aligned(self, source, target, *arguments, warnings=()):
        """The alignment must give as many warnings as there are words, each with its word."""
        source, target = self.write("source.file", source), self.write("target.file", target)
        done = self.run_command("align", source, target, *arguments, "--json", "-")
        self.assertEqual(done.returncode, 0, done)
        result = self.checked(done.stdout)
        self.assertTrue(result["converged"])
        self.assertEqual(done.stderr, "".join(f"pcl_gpu_icp: warning: {line}\n" for line in result["warnings"]))
        self.assertEqual(len(result["warnings"]), len(warnings), result["warnings"])
        for line, word in zip(result["warnings"], warnings):
            self.assertIn(word, line)
        return result

    def assert_read(self, content, warnings=(), points=POINTS, tolerance=1e-4):
        """As those points, which are a part of POINTS."""
        result = self.aligned(content, pcd(TARGET), warnings=warnings)
        self.assertEqual(result["points"]["source"], len(points))
        self.assert_maps(result["transform"], POINTS, TARGET, tolerance)
        return result

    def test_texts(self):
        """As they are in batch, compare and for both clouds: what of them is read is told in cloud_files_test."""
        rows = lambda points, separator: "".join(separator.join(map(repr, p)) + "\n" for p in points)
        source = self.write("source.csv", "X;Y;Z\n" + rows(POINTS, ";"))
        target = self.write("target.xyz", rows([(*p, 0.5) for p in TARGET], " "))
        guessed = f"pcl_gpu_icp: warning: {target}: its 4 columns have no names; the first three are taken as x, y and z\n"
        for arguments in (["align", source, target, "-o", self.path("out.ply")], ["compare", source, target],
                          ["align", target, source, "--quiet"]):
            done = self.run_command(*arguments)
            self.assertEqual((done.returncode, done.stderr), (0, "" if "--quiet" in arguments else guessed), done)
        _, names, points = read_ply(self.path("out.ply"))
        self.assertEqual(names, ["x", "y", "z"])
        for point, expected in zip(points, TARGET):
            self.assertLess(math.dist(point, expected), 1e-4)
        self.assert_read(rows(POINTS, "\t"))

    def test_standard_input(self):
        """What it holds is told from its content."""
        target = self.write("target.pcd", pcd(TARGET))
        file = self.write("source.file", pcd(POINTS))
        transform = self.align(file, target)["transform"]
        text = "".join("%r %r %r\n" % p for p in POINTS)
        for content in (pcd(POINTS).decode(), ply(POINTS).decode(), text):
            with self.subTest(content[:10]):
                result = self.checked(self.succeed("align", "-", target, "--json", "-", input=content))
                self.assertEqual(result["source"], "-")
                self.assertEqual(result["transform"], transform)
        self.succeed("align", target, "-", "--both", self.path("both.ply"), input=text)
        self.assertEqual(len(read_ply(self.path("both.ply"))[2]), 2 * len(POINTS))
        self.succeed("compare", "-", target, input=text)

    def test_standard_input_that_is_no_cloud(self):
        target = self.write("target.pcd", pcd(TARGET))
        self.fail_with(USAGE, "align", "-", "-", names=["TARGET", "standard input"], input="1 2 3\n")
        self.fail_with(INPUT, "align", "-", target, names="-: is empty", input="")
        self.fail_with(INPUT, "align", target, "-", names=["-: line 2: y: 'b' is not a number\n"], input="1 2 3\n1 b 3\n")
        for content, end in [("X;Y;Z\n1,5;2;3\n", "decimal commas: tr , .\n"), ("#ROSBAG V2.0\n", "a ROS bag\n")]:
            done = self.fail_with(INPUT, "align", "-", target, input=content)
            self.assertTrue(done.stderr.endswith(end), done.stderr)

    def test_a_file_named_as_standard_input(self):
        """Its name in a manifest is no argument."""
        target = self.write("target.pcd", pcd(TARGET))
        self.write("-", pcd(POINTS))
        self.write("pairs.csv", "source,target\n-,target.pcd\n")
        self.succeed("align", "./-", target, cwd=self.directory)
        done = self.run_command("batch", "pairs.csv", "-o", "out", cwd=self.directory)
        self.assertEqual(done.returncode, 0, done)

    def test_scans_of_kitti(self):
        source, target = (self.write(name, b"".join(struct.pack("<4f", *p, 0.5) for p in points))
                          for name, points in (("000001.bin", POINTS), ("000000.bin", TARGET)))
        result = self.align(source, target, "-o", self.path("out.pcd"))
        self.assert_maps(result["transform"], POINTS, TARGET, 1e-4)
        header, points = read_pcd(self.path("out.pcd"))
        self.assertEqual(header["FIELDS"], ["x", "y", "z", "intensity"])
        self.assertEqual({point[3] for point in points}, {0.5})

    def test_las(self):
        """As surveys are: centimetres in integers, about a corner of the area."""
        corner = (512345, 5403210, 312)

        def las(points):
            header = struct.pack(
                "<4s20xBB68xHIIBHI20x6d6d", b"LASF", 1, 2, 227, 227, 0, 0, 20, len(points), *3 * [0.0001], *corner, *6 * [0])
            return header + b"".join(
                struct.pack("<3iHBBbBH", *(round(p * 10000) for p in point), 40000, 9, 5, 0, 0, 0) for point in points)

        far = lambda points: [tuple(round(p[i], 4) + corner[i] for i in range(3)) for p in points]
        source, target = self.write("source.las", las(POINTS)), self.write("target.las", las(TARGET))
        result = self.align(source, target, "-o", self.path("out.pcd"))
        self.assert_maps(result["transform"], far(POINTS), far(TARGET), 5e-4)
        header, points = read_pcd(self.path("out.pcd"))
        self.assertEqual(header["FIELDS"], ["x", "y", "z", "intensity", "classification"])
        self.assertEqual({point[3:] for point in points}, {(40000, 5)})

    def test_vtk(self):
        start = f"# vtk DataFile Version 3.0\ntitle\n%s\nDATASET POLYDATA\nPOINTS {len(POINTS)} %s\n"
        cells = f"VERTICES 1 {len(POINTS) + 1}\n"
        self.assert_read(start % ("ASCII", "float") + "".join("%r %r %r\n" % p for p in POINTS) + cells)
        for name, kind in (("float", "f"), ("double", "d")):
            body = b"".join(struct.pack(">3" + kind, *p) for p in POINTS)
            self.assert_read((start % ("BINARY", name)).encode() + body + b"\n" + cells.encode() + bytes(99))

    def test_texts_far_from_the_origin(self):
        offset = (512345.678, 5403210.987, 312.3)
        far = lambda points: [tuple(round(p[i] + offset[i], 4) for i in range(3)) for p in points]
        rows = lambda points: "".join("%.4f,%.4f,%.4f\n" % point for point in points)
        result = self.aligned(rows(far(POINTS)), rows(far(TARGET)))
        self.assert_maps(result["transform"], far(POINTS), far(TARGET), 5e-4)

    def test_pcd_headers_as_they_are(self):
        header, rows = pcd(POINTS).decode().split("DATA ascii\n")
        count = len(POINTS)
        size = f"WIDTH {count}\nHEIGHT 1\n"
        for name, changed, *warnings in [
            ("lower-case key words", header.lower()),
            ("lower-case types", header.replace("TYPE F F F", "TYPE f f f")),
            ("field names in capitals", header.replace("x y z", "X Y Z")),
            ("blank lines first", "\n  \n" + header), ("byte order mark", "\ufeff" + header),
            ("tabs", header.replace(" ", "\t")), ("blanks at the ends", header.replace("\n", "  \n")),
            ("no COUNT", header.replace("COUNT 1 1 1\n", "")), ("no VERSION", header.replace("VERSION 0.7\n", "")),
            ("no VIEWPOINT", header.replace("VIEWPOINT 0 0 0 1 0 0 0\n", "")),
            ("no WIDTH and HEIGHT", header.replace(size, "")), ("no HEIGHT", header.replace("HEIGHT 1\n", "")),
            ("no WIDTH", header.replace(f"WIDTH {count}\nHEIGHT 1\n", "HEIGHT 20\n")),
            ("no POINTS", header.replace(f"POINTS {count}\n", "")),
            ("no sizes at all", header.replace(size, "").replace(f"POINTS {count}\n", "")),
            ("three numbers of VIEWPOINT", header.replace("VIEWPOINT 0 0 0 1 0 0 0", "VIEWPOINT 0 0 0")),
            ("commas in VIEWPOINT", header.replace("VIEWPOINT 0 0 0 1 0 0 0", "VIEWPOINT 0,0,0,1,0,0,0")),
            ("VIEWPOINT nan", header.replace("VIEWPOINT 0", "VIEWPOINT nan"), "VIEWPOINT is not finite"),
            ("a word of their own", header + "SCANNER Model X\n", "SCANNER"),
        ]:
            with self.subTest(name):
                self.assert_read(changed + "DATA ascii\n" + rows, warnings)
        for encoding in ("binary", "binary_compressed"):
            with self.subTest(encoding):
                content = pcd(POINTS, encoding).replace(size.encode(), b"")
                self.assert_read(content.replace(f"POINTS {count}\n".encode(), b""))

    def test_line_ends(self):
        for ends in ("\r\n", "\r"):
            for content in (pcd(POINTS), ply(POINTS)):
                with self.subTest(ends=ends, start=content[:5]):
                    self.assert_read(content.replace(b"\n", ends.encode()))
                    self.assert_read(content.rstrip(b"\n").replace(b"\n", ends.encode()))
            for content, end in [(pcd(POINTS, "binary"), b"DATA binary\n"),
                                 (pcd(POINTS, "binary_compressed"), b"DATA binary_compressed\n"),
                                 (ply(POINTS, "binary_little_endian"), b"end_header\n")]:
                with self.subTest(ends=ends, end=end):
                    header, body = content.split(end, 1)
                    self.assert_read((header + end).replace(b"\n", ends.encode()) + body)

    def test_data_that_look_like_a_line_end(self):
        """The first byte of binary data behind a header whose lines end with a carriage return is a line feed."""
        fields = [("ring", "U", 1, 1), *XYZ]
        body = [(10, *p) for p in POINTS]
        header, data = pcd(body, "binary", fields).split(b"DATA binary\n", 1)
        self.assert_read((header + b"DATA binary\n").replace(b"\n", b"\r") + data)
        header, data = ply(body, "binary_little_endian", [("uchar", "ring"), *PLY_XYZ]).split(b"end_header\n", 1)
        self.assert_read((header + b"end_header\n").replace(b"\n", b"\r") + data)

    def test_padding(self):
        fields = [*XYZ, ("_", "U", 1, 4), ("intensity", "F", 4, 1), ("_", "U", 1, 0), ("ring", "U", 2, 1), ("_", "U", 1, 15)]
        points = [(*p, *[0] * 4, 0.5, 7, *[0] * 15) for p in POINTS]
        for encoding in ("ascii", "binary", "binary_compressed"):
            with self.subTest(encoding):
                self.assert_read(pcd(points, encoding, fields))

    def test_values_as_they_are_spelled(self):
        spellings = {
            "nan": ["nan", "NaN", "-nan", "NAN", "nan(ind)", "-nan(ind)", "nan(snan)", "1.#QNAN", "-1.#IND", "1.#IND00",
                    "1.#SNAN", "-1.#QNAN0", "None", "null", "NULL"],
            "inf": ["inf", "-inf", "Infinity", "-INFINITY", "1.#INF", "-1.#INF00", "1e39", "-1e400", "1d999"],
            "zero": ["1e-50", "4.9e-324", "1e-400", "-0", "+0", ".0", "0.", "0x0p0", "0d0", "-1e-9999",
                     "0E+00"],
        }
        for kind, words in spellings.items():
            for content in (pcd, ply):
                with self.subTest(kind=kind, format=content.__name__):
                    row = "0.0 0.0 0.0\n"
                    whole = content([*POINTS, *[(0.0, 0.0, 0.0)] * len(words)]).decode()
                    self.assertTrue(whole.endswith(row * len(words)))
                    rows = "".join(f"{word} {word} {word}\n" for word in words)
                    result = self.aligned(whole[: -len(row * len(words))] + rows, pcd(TARGET),
                                          warnings=["exactly (0, 0, 0)"] if kind == "zero" else [])
                    dropped = result["points"]["dropped"]["source"]["non_finite"]
                    self.assertEqual(dropped, 0 if kind == "zero" else len(words))

    def test_numbers_in_other_spellings(self):
        spelled = [(f"+{x!r}" if x >= 0 else repr(x), y.hex(), ("%.17e" % z).replace("e", "D")) for x, y, z in POINTS]
        for content in (pcd, ply):
            header = content([(0, 0, 0)], count=len(POINTS)).decode()[: -len("0 0 0\n")]
            self.assert_read(header + "".join("%s %s %s\n" % point for point in spelled))

    def test_values_that_their_type_does_not_hold(self):
        for kind, size, words, warned in [
            ("U", 4, ["3.0", "7", "1e3"], []), ("U", 4, ["-1", "3.5", "nan"], ["field extra"]),
            ("U", 1, ["256", "-1"], ["field extra"]), ("I", 4, ["4294967295", "4278255360"], ["field extra"]),
            ("I", 8, ["1e30"], ["field extra"]), ("U", 8, ["18446744073709551615"], []), ("F", 4, ["1e-42", "1e99"], []),
        ]:
            with self.subTest(kind=kind, size=size, words=words):
                header = pcd_header([*XYZ, ("extra", kind, size, 1)], len(POINTS), "ascii")
                rows = "".join("%r %r %r %s\n" % (*p, words[i % len(words)]) for i, p in enumerate(POINTS))
                self.assert_read(header + rows, warned)

    def test_integer_coordinates(self):
        millimetres = [tuple(round(1000 * value) for value in point) for point in POINTS]
        target = pcd([tuple(1000 * value for value in point) for point in TARGET])
        contents = [pcd(millimetres, encoding, [(n, "I", size, 1) for n in "xyz"])
                    for encoding in ("ascii", "binary", "binary_compressed") for size in (2, 4, 8)]
        contents += [ply(millimetres, encoding, [("int", n) for n in "xyz"]) for encoding in ("ascii", "binary_big_endian")]
        for content in contents:
            result = self.aligned(content, target, warnings=["coordinates are integers"])
            self.assert_maps(
                result["transform"], millimetres, [tuple(1000 * v for v in point) for point in TARGET], 2.0)

    def test_ply_headers_as_they_are(self):
        for name, old, new, *warnings in [
            ("blank behind ply", "ply\n", "ply \n"), ("tab behind ply", "ply\n", "ply\t\n"),
            ("blank line first", "ply\n", "\nply\n"), ("byte order mark", "ply\n", "\ufeffply\n"),
            ("byte order mark in the data", "end_header\n", "end_header\n\ufeff"),
            ("no word comment", "comment test", "Created by a modeller 2.47"),
            ("capitals", "element vertex", "ELEMENT Vertex"), ("names in capitals", "property float x", "property float X"),
            ("tabs and blanks", "property float y", "property\tfloat   y \t"),
            ("obj_info", "comment test", "obj_info made by hand"),
        ]:
            with self.subTest(name):
                content = ply(POINTS).decode()
                self.assertIn(old, content)
                self.assert_read(content.replace(old, new, 1), warnings)

    def test_ply_properties_as_they_are(self):
        for kind, value in [("bool", "1"), ("int64", "7"), ("uint64", "18446744073709551615"), ("float64", "1e300")]:
            with self.subTest(kind):
                content = ply([(*p, 5) for p in POINTS], properties=[*PLY_XYZ, ("int", "extra")]).decode()
                self.assert_read(content.replace("property int extra", f"property {kind} extra").replace(" 5\n", f" {value}\n"))

    def test_ply_rows_that_go_on_in_the_next_line(self):
        content = ply(POINTS).decode()
        header, rows = content.split("end_header\n")
        faces = "element face 2\nproperty list uchar int vertex_indices\n"
        self.assert_read(header + "end_header\n" + rows.replace(" ", "\n"))
        self.assert_read(header + faces + "end_header\n" + rows.replace(" ", "\n", 3 * len(POINTS)) + "3 0\n1 2\n3\n1 2 3\n")
        words = rows.split()
        self.assert_read(header + "end_header\n" + "".join(
            " ".join(words[i : i + 2]) + "\n" for i in range(0, len(words), 2)))

    def test_ply_lists_of_vertices_are_skipped(self):
        header = "property list uchar int view\nproperty float quality\n"
        ascii_rows = "".join("%r %r %r 2 5 6 0.5\n" % p for p in POINTS).encode()
        for encoding, order in [("ascii", ""), ("binary_little_endian", "<"), ("binary_big_endian", ">")]:
            with self.subTest(encoding):
                body = ascii_rows if not order else b"".join(struct.pack(order + "fffBiif", *p, 2, 5, 6, 0.5) for p in POINTS)
                content = ply([], encoding, after=header, count=len(POINTS)) + body
                self.assert_read(content, ["property view of its vertices is a list"])

    def test_ply_elements_behind_the_vertices_that_end_early(self):
        after = "element face 9\nproperty list uchar int vertex_indices\n"
        for encoding in ("ascii", "binary_little_endian"):
            self.assert_read(ply(POINTS, encoding, after=after), ["element face"])

    def test_every_encoding_gives_the_same_transform(self):
        contents = [
            lambda points: pcd(points, "ascii"),
            lambda points: pcd(points, "binary"),
            lambda points: pcd(points, "binary_compressed"),
            lambda points: pcd(points, "ascii").replace(b"\n", b"\r\n"),
            lambda points: pcd(points, "binary") + b"padding at the end",
            lambda points: ply(points, "binary_little_endian"),
            lambda points: ply(points, "binary_big_endian"),
        ]
        transforms = []
        for content in contents:
            result = self.aligned(content(POINTS), content(TARGET))
            transforms.append(result["transform"])
            self.assert_maps(result["transform"], POINTS, TARGET, 1e-4)
        for transform in transforms[1:]:
            self.assertEqual(transform, transforms[0])

    def test_old_header_without_sizes(self):
        rows = "".join("%r %r %r\n" % point for point in POINTS)
        result = self.aligned(f"# comment\nCOLUMNS x y z\nPOINTS {len(POINTS)}\nDATA ascii\n{rows}", pcd(TARGET))
        self.assert_maps(result["transform"], POINTS, TARGET, 1e-4)

    def test_ascii_spellings_of_nan(self):
        rows = "".join("%r %r %r\n" % point for point in POINTS) + "nan nan nan\n-nan 1 2\nNaN 1 2\ninf 1 2\n-inf 1 2\n"
        result = self.aligned(pcd_header(XYZ, len(POINTS) + 5, "ascii") + rows, pcd(TARGET))
        self.assertEqual(result["points"]["dropped"]["source"]["non_finite"], 5)
        self.assert_maps(result["transform"], POINTS, TARGET, 1e-4)

    def test_ply_with_other_elements(self):
        before = "element junk 2\nproperty list uchar int values\nproperty float weight\n"
        after = "element face 0\nproperty list uchar int vertex_indices\n"
        for encoding, body in [
            ("ascii", b"3 7 8 9 0.5\n0 0.5\n"),
            ("binary_little_endian", struct.pack("<BiiifBf", 3, 7, 8, 9, 0.5, 0, 0.5)),
            ("binary_big_endian", struct.pack(">BiiifBf", 3, 7, 8, 9, 0.5, 0, 0.5)),
        ]:
            with self.subTest(encoding):
                source = ply(POINTS, encoding, before=before, body_before=body, after=after)
                result = self.aligned(source, pcd(TARGET))
                self.assert_maps(result["transform"], POINTS, TARGET, 1e-4)

    def test_double_coordinates_far_from_the_origin(self):
        offset = (512345.678, 5403210.987, 312.3)
        source = [tuple(p[i] + offset[i] for i in range(3)) for p in POINTS]
        target = [tuple(p[i] + offset[i] for i in range(3)) for p in TARGET]
        for encoding in ("ascii", "binary", "binary_compressed"):
            with self.subTest(encoding):
                result = self.aligned(
                    pcd(source, encoding, fields=XYZ_DOUBLE), pcd(target, encoding, fields=XYZ_DOUBLE))
                self.assert_maps(result["transform"], source, target, 1e-4)
        doubles = [("double", name) for name in "xyz"]
        result = self.aligned(ply(source, "binary_little_endian", doubles), ply(target, "ascii", doubles))
        self.assert_maps(result["transform"], source, target, 1e-4)

    def test_guess_between_two_frames(self):
        offset = (512345.678, 5403210.987, 312.3)
        target = [tuple(p[i] + offset[i] for i in range(3)) for p in TARGET]
        guess = motion(0, offset)
        result = self.aligned(pcd(POINTS), pcd(target, fields=XYZ_DOUBLE), "--guess", *numbers(guess))
        self.assert_maps(result["transform"], POINTS, target, 1e-4)

    def test_doubles_beyond_float_are_dropped(self):
        far = POINTS + [(1e300, 0.0, 0.0), (0.0, -1e39, 0.0)]
        result = self.aligned(pcd(far, fields=XYZ_DOUBLE), pcd(TARGET))
        self.assertEqual(result["points"]["dropped"]["source"]["non_finite"], 2)
        self.assert_maps(result["transform"], POINTS, TARGET, 1e-4)
