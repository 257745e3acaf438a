"""Files out: every field kept, whole or not at all, and nothing overwritten unasked."""

import errno
import math
import os
import resource
import stat
import struct

from command import (
    IDENTITY, NOT_CONVERGED, OUTPUT, USAGE, XYZ, XYZ_DOUBLE, CommandTest, motion, moved, pcd, ply, read_pcd, read_ply,
    surface, turned)

POINTS = surface()
MOTION = motion(3, (0.05, -0.08, 0.04))
TARGET = [moved(MOTION, point) for point in POINTS]
NORMALS = [(math.sin(i), math.cos(i) * math.sin(2 * i), math.cos(i) * math.cos(2 * i)) for i in range(len(POINTS))]


def read(path, mode="r"):
    with open(path, mode) as file:
        return file.read()


class Cloud(CommandTest):
    def aligned(self, source, output="out.pcd", *arguments):
        """Aligns the content of a file and returns the name of the file written, and the transform."""
        path = self.path(output)
        target = self.write("target.pcd", pcd(TARGET))
        result = self.align(self.write("source.file", source), target, "-o", path, *arguments)
        return path, result["transform"]

    def assert_near(self, found, expected, tolerance=1e-5):
        self.assertEqual(len(found), len(expected))
        for p, q in zip(found, expected):
            self.assertLess(math.dist(p, q), tolerance)

    def test_every_field_is_kept(self):
        fields = [
            ("label", "U", 1, 1), *XYZ, ("normal_x", "F", 4, 1), ("normal_y", "F", 4, 1), ("normal_z", "F", 4, 1),
            ("curvature", "F", 4, 1), ("rgb", "F", 4, 1), ("intensity", "F", 4, 1), ("stamp", "F", 8, 1),
            ("histogram", "F", 4, 3), ("ring", "U", 2, 1), ("offset", "I", 4, 1)]
        colour = struct.unpack("<f", struct.pack("<I", 0x00804020))[0]
        points = [
            (i % 256, *p, *n, 0.5 * i, colour, 7.0 + i, 1e9 + i / 1024, 1.0, float(i), 3.0, 65535 - i, -i)
            for i, (p, n) in enumerate(zip(POINTS, NORMALS))]
        for encoding in ("ascii", "binary", "binary_compressed"):
            with self.subTest(encoding):
                output, transform = self.aligned(pcd(points, encoding, fields), "out.pcd", "--force")
                header, found = read_pcd(output)
                self.assertEqual(header["FIELDS"], [field[0] for field in fields])
                self.assertEqual(header["SIZE"], [str(field[2]) for field in fields])
                self.assertEqual(header["TYPE"], [field[1] for field in fields])
                self.assertEqual(header["COUNT"], [str(field[3]) for field in fields])
                self.assert_near([p[1:4] for p in found], [moved(transform, p) for p in POINTS])
                self.assert_near([p[4:7] for p in found], [turned(transform, n) for n in NORMALS])
                for p, q in zip(found, points):
                    self.assertEqual(p[:1] + p[8:9] + p[10:], q[:1] + q[8:9] + q[10:])
                    self.assertAlmostEqual(p[7], q[7], places=3)

    def test_double_coordinates_keep_their_digits(self):
        offset = (512345.678, 5403210.987, 312.3)
        source = [tuple(p[i] + offset[i] for i in range(3)) for p in POINTS]
        target = [tuple(p[i] + offset[i] for i in range(3)) for p in TARGET]
        result = self.align(
            self.write("s.pcd", pcd(source, "binary", XYZ_DOUBLE)), self.write("t.pcd", pcd(target, "binary", XYZ_DOUBLE)),
            "-o", self.path("out.pcd"))
        header, found = read_pcd(self.path("out.pcd"))
        self.assertEqual((header["SIZE"], header["TYPE"]), (["8"] * 3, ["F"] * 3))
        self.assert_near(found, target, 1e-4)
        self.assert_near(found, [moved(result["transform"], p) for p in source], 1e-8)

    def test_organised_clouds_stay_organised(self):
        nan = float("nan")
        points = list(POINTS)
        points[5] = points[77] = (nan, nan, nan)
        content = pcd(points, "binary", width=24, height=20, viewpoint="1 2 3 0.5 0.5 0.5 0.5")
        output, transform = self.aligned(content)
        header, found = read_pcd(output)
        self.assertEqual((header["WIDTH"], header["HEIGHT"]), (["24"], ["20"]))
        self.assert_pose(header["VIEWPOINT"], [1, 2, 3], [[0, 0, 1], [1, 0, 0], [0, 1, 0]], transform)
        for i, (p, q) in enumerate(zip(found, points)):
            if i in (5, 77):
                self.assertTrue(all(math.isnan(value) for value in p))
            else:
                self.assertLess(math.dist(p, moved(transform, q)), 1e-5)
        again, second = self.aligned(content, "out.ply")
        self.assertIn("obj_info num_cols 24", read_ply(again)[0])
        # and from that PLY file back to an organised PCD file
        third = self.path("third.pcd")
        self.succeed("align", again, again, "-o", third)
        self.assertEqual(read_pcd(third)[0]["HEIGHT"], ["20"])

    def test_points_that_are_not_finite_stay_as_they_are(self):
        nan, infinity = float("nan"), float("inf")
        points = list(POINTS)
        points[5], points[77] = (nan, 1.5, 2.5), (4.5, -infinity, 6.5)
        output, _ = self.aligned(pcd(points, "binary"))
        found = read_pcd(output)[1]
        self.assertTrue(math.isnan(found[5][0]))
        self.assertEqual((tuple(found[5][1:]), tuple(found[77])), ((1.5, 2.5), points[77]))

    def test_ply_to_ply(self):
        properties = [
            ("uchar", "blue"), ("float", "x"), ("float", "y"), ("float", "z"), ("float", "nx"), ("float", "ny"),
            ("float", "nz"), ("uchar", "green"), ("uchar", "alpha"), ("uchar", "red"), ("ushort", "ring")]
        points = [(3, *p, *n, 2, 200, 1, i) for i, (p, n) in enumerate(zip(POINTS, NORMALS))]
        for encoding in ("ascii", "binary_little_endian", "binary_big_endian"):
            with self.subTest(encoding):
                output, transform = self.aligned(ply(points, encoding, properties), "out.PLY", "--force")
                _, names, found = read_ply(output)
                self.assertEqual(
                    names, ["x", "y", "z", "nx", "ny", "nz", "ring", "red", "green", "blue", "alpha"])
                self.assert_near([p[:3] for p in found], [moved(transform, p) for p in POINTS])
                self.assert_near([p[3:6] for p in found], [turned(transform, n) for n in NORMALS])
                self.assertEqual([p[6] for p in found], list(range(len(POINTS))))
                self.assertEqual({p[7:] for p in found}, {(1, 2, 3, 200)})

    def test_ply_to_pcd_and_back(self):
        properties = [("double", "x"), ("double", "y"), ("double", "z"), ("float", "nx"), ("float", "ny"),
                      ("float", "nz"), ("uchar", "red"), ("uchar", "green"), ("uchar", "blue")]
        points = [(*p, *n, 10, 20, 30) for p, n in zip(POINTS, NORMALS)]
        output, transform = self.aligned(ply(points, "ascii", properties), "out.pcd")
        header, found = read_pcd(output)
        self.assertEqual(header["FIELDS"], "x y z normal_x normal_y normal_z rgb".split())
        self.assertEqual(header["TYPE"], ["F"] * 7)
        self.assertEqual(header["SIZE"], "8 8 8 4 4 4 4".split())
        self.assert_near([p[3:6] for p in found], [turned(transform, n) for n in NORMALS])
        self.assertEqual({struct.pack("<f", p[6]) for p in found}, {bytes([30, 20, 10, 0])})
        back = self.path("back.ply")
        self.succeed("align", output, output, "-o", back)
        _, names, found = read_ply(back)
        self.assertEqual(names, "x y z nx ny nz red green blue".split())
        self.assertEqual({p[6:] for p in found}, {(10, 20, 30)})

    def assert_pose(self, viewpoint, place, rows, transform):
        """The pose that a VIEWPOINT says must be that place and orientation, moved."""
        x, y, z, qw, qx, qy, qz = map(float, viewpoint)
        found = [[1 - 2 * (qy * qy + qz * qz), 2 * (qx * qy - qw * qz), 2 * (qx * qz + qw * qy)],
                 [2 * (qx * qy + qw * qz), 1 - 2 * (qx * qx + qz * qz), 2 * (qy * qz - qw * qx)],
                 [2 * (qx * qz - qw * qy), 2 * (qy * qz + qw * qx), 1 - 2 * (qx * qx + qy * qy)]]
        self.assert_near([(x, y, z)], [moved(transform, place)])
        self.assert_near(found, self.turned_rows(transform, rows))

    def turned_rows(self, transform, rows):
        return [[sum(transform[i][k] * rows[k][j] for k in range(3)) for j in range(3)] for i in range(3)]

    def test_viewpoint_that_is_not_there_is_the_default(self):
        for header in (b"VIEWPOINT 0 0 0 1 0 0 0\n", b""):
            content = pcd(POINTS, "binary").replace(b"VIEWPOINT 0 0 0 1 0 0 0\n", header)
            output, transform = self.aligned(content, "out.pcd", "--force")
            self.assert_pose(read_pcd(output)[0]["VIEWPOINT"], [0, 0, 0], IDENTITY[:3], transform)

    def test_viewpoint_is_the_camera_of_a_ply_file(self):
        """As PCL writes it: the rows of the orientation, and behind them what it leaves at zero, the size, zeros."""
        output, transform = self.aligned(pcd(POINTS, "binary", viewpoint="1 2 3 0.5 0.5 0.5 0.5"), "out.ply")
        camera = struct.unpack("<17f2i2f", read(output, "rb")[-84:])
        self.assert_near([camera[:3]], [moved(transform, (1, 2, 3))])
        rows = [camera[3:6], camera[6:9], camera[9:12]]
        self.assert_near(rows, self.turned_rows(transform, [[0, 0, 1], [1, 0, 0], [0, 1, 0]]))
        self.assertEqual(camera[12:], (0, 0, 0, 0, 0, len(POINTS), 1, 0, 0))
        self.assertIn(b"element camera 1\nproperty float view_px\n", read(output, "rb"))
        # and back
        back = self.path("back.pcd")
        again = self.align(output, output, "-o", back)
        self.assert_pose(read_pcd(back)[0]["VIEWPOINT"], camera[:3], rows, again["transform"])

    def test_camera_of_a_ply_file_moves(self):
        names = "view_px view_py view_pz x_axisx x_axisy x_axisz y_axisx y_axisy y_axisz z_axisx z_axisy z_axisz".split()
        after = "element camera 1\nproperty int id\n" + "".join(f"property float {name}\n" for name in names)
        after += "property float focal\n"
        pose = (1.5, 2, 3, 0, 0, 1, 1, 0, 0, 0, 1, 0)
        for encoding, body in [
            ("ascii", (" ".join(map(str, (7, *pose, 0.25))) + "\n").encode()),
            ("binary_little_endian", struct.pack("<i13f", 7, *pose, 0.25)),
            ("binary_big_endian", struct.pack(">i13f", 7, *pose, 0.25)),
        ]:
            with self.subTest(encoding):
                output, transform = self.aligned(ply(POINTS, encoding, after=after) + body, "out.ply", "--force")
                camera = struct.unpack("<i13f", read(output, "rb")[-56:])
                self.assertEqual((camera[0], camera[13]), (7, 0.25))
                self.assert_near([camera[1:4]], [moved(transform, (1.5, 2, 3))])
                self.assert_near([camera[4:7], camera[7:10], camera[10:13]],
                                 self.turned_rows(transform, [[0, 0, 1], [1, 0, 0], [0, 1, 0]]))

    def test_elements_and_comments_of_a_ply_file_are_kept(self):
        before = "comment CRS EPSG:32633\nobj_info made by hand\nelement material 2\nproperty uchar code\nproperty double w\n"
        after = ("element face 3\nproperty list uchar int vertex_indices\nproperty short tag\n"
                 "element edge 1\nproperty uint a\nproperty uint b\n")
        def body_before(order):
            return struct.pack(order + "BdBd", 1, 0.1, 2, 1e300)
        def body_after(order):
            return struct.pack(order + "B3ihB4ihBhII", 3, 0, 1, 2, -5, 4, 0, 1, 2, 3, 6, 0, 7, 8, 4294967295)
        for encoding, first, last in [
            ("ascii", b"1 0.1\n2 1e300\n", b"3 0 1 2 -5\n4 0 1 2 3 6\n0 7\n8 4294967295\n"),
            ("binary_little_endian", body_before("<"), body_after("<")),
            ("binary_big_endian", body_before(">"), body_after(">")),
        ]:
            with self.subTest(encoding):
                source = ply(POINTS, encoding, before=before, body_before=first, after=after) + last
                output, transform = self.aligned(source, "out.ply", "--force")
                content = read(output, "rb")
                start = content.index(b"end_header\n") + len(b"end_header\n")
                vertices = "element vertex 480\nproperty float x\nproperty float y\nproperty float z\n"
                comments, elements = before.split("element", 1)
                self.assertEqual(
                    content[:start].decode(),
                    f"ply\nformat binary_little_endian 1.0\ncomment test\n{comments}element{elements}{vertices}{after}end_header\n")
                data = content[start:]
                self.assertEqual(data[: len(body_before("<"))], body_before("<"))
                self.assertEqual(data[-len(body_after("<")) :], body_after("<"))
                found = data[len(body_before("<")) : -len(body_after("<"))]
                self.assert_near(list(struct.iter_unpack("<3f", found)), [moved(transform, p) for p in POINTS])

    def test_what_a_format_cannot_hold_is_named(self):
        faces = "element face 2\nproperty list uchar int vertex_indices\n"
        mesh = self.write("mesh.ply", ply(POINTS, after=faces) + b"3 0 1 2\n3 1 2 3\n")
        padded = self.write("padded.pcd", pcd([(*p, 0, 0) for p in POINTS], "binary", [*XYZ, ("_", "U", 1, 2)]))
        target = self.write("target.pcd", pcd(TARGET))
        for source, output, word in [(mesh, "mesh.pcd", "2 of element face"), (padded, "padded.ply", "the fields _")]:
            with self.subTest(output):
                done = self.run_command("align", source, target, "-o", self.path(output), "--json", "-")
                self.assertEqual(done.returncode, 0)
                [line] = self.checked(done.stdout)["warnings"]
                self.assertEqual(done.stderr, f"pcl_gpu_icp: warning: {line}\n")
                self.assertIn(self.path(output), line)
                self.assertIn(word, line)
                quiet = self.run_command("align", source, target, "-o", self.path(output), "--force", "--quiet")
                self.assertEqual((quiet.returncode, quiet.stdout, quiet.stderr), (0, "", ""))

    def test_padding_and_comments_of_a_pcd_file_are_kept(self):
        fields = [*XYZ, ("_", "U", 1, 4), ("ring", "U", 2, 1), ("_", "U", 1, 3)]
        points = [(*p, 1, 2, 3, 4, i, 5, 6, 7) for i, p in enumerate(POINTS)]
        source = pcd(points, "binary", fields).replace(b"VERSION", b"# scanned by hand\nVERSION")
        output, transform = self.aligned(source)
        header, data = read(output, "rb").split(b"DATA binary\n", 1) # PCL cannot read compressed ones
        self.assertIn(b"# scanned by hand\n", header)
        self.assertIn(b"FIELDS x y z _ ring _\nSIZE 4 4 4 1 2 1\nTYPE F F F U U U\nCOUNT 1 1 1 4 1 3\n", header)
        found = list(struct.iter_unpack("<3f4BH3B", data))
        self.assert_near([p[:3] for p in found], [moved(transform, p) for p in POINTS])
        self.assertEqual([p[3:] for p in found], [p[3:] for p in points])

    def test_bits_of_values_that_are_no_measurements_are_kept(self):
        """Colours that are NaN as floats, subnormals, labels of all ones."""
        fields = [*XYZ, ("rgb", "U", 4, 1), ("label", "U", 4, 1), ("stamp", "U", 8, 1)]
        as_float = [*XYZ, ("rgb", "F", 4, 1), ("label", "U", 4, 1), ("stamp", "F", 8, 1)]
        points = [(*p, 0xFFC0FFEE - i, 0xFFFFFFFF, 0x7FF4000000000001 + i) for i, p in enumerate(POINTS)]
        for encoding in ("binary", "binary_compressed"):
            header = pcd([], encoding, as_float, count=len(POINTS)).split(b"DATA")[0]
            content = header + b"DATA" + pcd(points, encoding, fields).split(b"DATA", 1)[1]
            for output in ("out.pcd",):
                path, _ = self.aligned(content, output, "--force")
                header_out, found = read_pcd(path)
                packed = [struct.pack("<fId", *p[3:]) for p in found]
                self.assertEqual(header_out["TYPE"], list("FFFFUF"))
                self.assertEqual(packed, [struct.pack("<IIQ", *p[3:]) for p in points])

    def test_labels_beyond_their_type_keep_their_bits(self):
        header = pcd([], "ascii", [*XYZ, ("label", "U", 4, 1), ("rgb", "I", 4, 1), ("ring", "U", 1, 1)], count=len(POINTS))
        rows = "".join("%r %r %r -1 4278255360 300\n" % p for p in POINTS).encode()
        source, target = self.write("s.pcd", header + rows), self.write("t.pcd", pcd(TARGET))
        done = self.run_command("align", source, target, "-o", self.path("out.pcd"), "--quiet")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertEqual({p[3:] for p in read_pcd(self.path("out.pcd"))[1]}, {(0xFFFFFFFF, 4278255360 - 2**32, 255)})

    def test_integer_coordinates_become_double(self):
        millimetres = [tuple(round(1000 * v) for v in p) for p in POINTS]
        source = self.write("s.pcd", pcd(millimetres, "binary", [(n, "I", 2, 1) for n in "xyz"]))
        target = self.write("t.pcd", pcd([tuple(1000 * v for v in p) for p in TARGET]))
        done = self.run_command("align", source, target, "-o", self.path("out.pcd"), "--json", "-")
        header, found = read_pcd(self.path("out.pcd"))
        self.assertEqual((header["SIZE"], header["TYPE"]), (["8"] * 3, ["F"] * 3))
        self.assert_near(found, [moved(self.checked(done.stdout)["transform"], p) for p in millimetres], 1e-6)

    def test_ply_has_no_8_byte_integers(self):
        source = self.write("s.pcd", pcd([(*p, 5) for p in POINTS], "binary", XYZ + [("stamp", "U", 8, 1)]))
        self.fail_with(OUTPUT, "align", source, source, "-o", self.path("out.ply"), names="stamp")
        self.assertEqual(os.listdir(self.directory), ["s.pcd"])
        self.succeed("align", source, source, "-o", self.path("out.pcd"))
        self.assertEqual({p[3] for p in read_pcd(self.path("out.pcd"))[1]}, {5})


class Both(CommandTest):
    """--both: the source, moved, in orange and the target in blue, as --png has them."""

    ORANGE, BLUE = 0xE69F00, 0x0072B2

    def both(self, source, target, name, *arguments):
        """The transform, and rows of x, y, z and a colour."""
        path = self.path(name)
        result = self.align(self.write("s.pcd", source), self.write("t.pcd", target), "--both", path, *arguments)
        if name.endswith(".pcd"):
            header, rows = read_pcd(path)
            self.assertEqual(header["FIELDS"], ["x", "y", "z", "rgb"])
            return result["transform"], [(*row[:3], struct.unpack("<I", struct.pack("<f", row[3]))[0]) for row in rows]
        _, names, rows = read_ply(path)
        self.assertEqual(names, ["x", "y", "z", "red", "green", "blue"])
        return result["transform"], [(*row[:3], row[3] << 16 | row[4] << 8 | row[5]) for row in rows]

    def assert_both(self, rows, transform, source, target, tolerance=1e-5):
        expected = [(*moved(transform, p), self.ORANGE) for p in source] + [(*p, self.BLUE) for p in target]
        self.assertEqual([row[3] for row in rows], [row[3] for row in expected])
        for row, point in zip(rows, expected):
            self.assertLess(math.dist(row[:3], point[:3]), tolerance)

    def test_both_formats(self):
        for name in ("both.pcd", "both.ply", "both.PLY"):
            transform, rows = self.both(pcd(POINTS), pcd(TARGET), name)
            self.assert_both(rows, transform, POINTS, TARGET)

    def test_every_point_that_is_one(self):
        nan, fields = float("nan"), [("label", "U", 1, 1), *XYZ]
        source = [(1, *p) for p in POINTS] + [(2, nan, 0.0, 0.0)] + [(3, 0.0, 0.0, 0.0)] * 30
        target = TARGET + [(0.0, 0.0, float("inf"))]
        transform, rows = self.both(pcd(source, "binary", fields), pcd(target, "binary"), "leaf.ply", "--leaf", "0.3",
                                    "--drop-zero-returns")
        self.assert_both(rows, transform, [p for p in POINTS if p != (0.0, 0.0, 0.0)], TARGET)

    def test_double_coordinates_keep_their_digits(self):
        shift = lambda points: [(x + 512345.678, y + 5403210.987, z + 312.3) for x, y, z in points]
        for name in ("utm.pcd", "utm.ply"):
            transform, rows = self.both(pcd(shift(POINTS), "binary", XYZ_DOUBLE), pcd(shift(TARGET), "binary", XYZ_DOUBLE),
                                        name)
            self.assert_both(rows, transform, shift(POINTS), shift(TARGET), 1e-8)

    def test_it_is_read_again(self):
        self.both(pcd(POINTS), pcd(TARGET), "both.ply")
        self.assertEqual(self.align(self.path("both.ply"), self.path("t.pcd"))["points"]["source"], 2 * len(POINTS))


class Files(CommandTest):
    def setUp(self):
        super().setUp()
        self.source = self.write("source.pcd", pcd(POINTS))
        self.target = self.write("target.pcd", pcd(TARGET))
        self.inputs = {"source.pcd", "target.pcd"}

    def files(self):
        return set(os.listdir(self.directory))

    def options(self, name="out"):
        return [
            ["-o", self.path(name + ".pcd")],
            ["-o", self.path(name + ".ply")],
            ["--both", self.path(name + ".pcd")],
            ["--both", self.path(name + ".ply")],
            ["--matrix", self.path(name + ".txt")],
            ["--json", self.path(name + ".json")],
        ]

    def test_matrix(self):
        result = self.align(self.source, self.target, "--matrix", self.path("m.txt"))
        lines = read(self.path("m.txt")).splitlines()
        self.assertEqual([[float(word) for word in line.split()] for line in lines], result["transform"])
        # It serves as a guess.
        again = self.align(self.source, self.target, "--guess", self.path("m.txt"))
        self.assertLess(again["rmse_before"], 1e-5)

    def test_json_file_leaves_the_summary_on_stdout(self):
        text = self.succeed("align", self.source, self.target, "--json", self.path("r.json"))
        self.assertIn("converged", text)
        self.checked(read(self.path("r.json")))

    def test_new_files_have_the_usual_permissions(self):
        self.succeed("align", self.source, self.target, "--json", self.path("r.json"), umask=0o027)
        self.assertEqual(stat.S_IMODE(os.stat(self.path("r.json")).st_mode), 0o640)

    def test_existing_files_are_kept_without_force(self):
        for arguments in self.options():
            with self.subTest(arguments):
                path = arguments[1]
                with open(path, "w") as file:
                    file.write("precious")
                os.chmod(path, 0o604)
                self.fail_with(OUTPUT, "align", self.source, self.target, *arguments, names=[path, "--force"])
                self.assertEqual(read(path), "precious")
                self.succeed("align", self.source, self.target, *arguments, "--force")
                self.assertNotEqual(read(path, "rb"), b"precious")
                self.assertEqual(stat.S_IMODE(os.stat(path).st_mode), 0o604)
                os.remove(path)
        self.fail_with(OUTPUT, "compare", self.source, self.target, "--json", self.source, names="--force")

    def test_in_place(self):
        before = read(self.source, "rb")
        self.fail_with(OUTPUT, "align", self.source, self.target, "-o", self.source, names=self.source)
        self.assertEqual(read(self.source, "rb"), before)
        self.succeed("align", self.source, self.target, "-o", self.source, "--force")
        for p, q in zip(read_pcd(self.source)[1], TARGET):
            self.assertLess(math.dist(p, q), 1e-4)

    def test_names_without_a_directory(self):
        names = {"out.pcd", "m.txt", "r.json"}
        arguments = ["-o", "out.pcd", "--matrix", "m.txt", "--json", "./r.json"]
        self.succeed("align", "source.pcd", "target.pcd", *arguments, cwd=self.directory)
        self.assertEqual(self.files(), self.inputs | names)
        self.fail_with(OUTPUT, "align", "source.pcd", "target.pcd", *arguments, names="-o out.pcd: exists",
                       cwd=self.directory)

    def test_symbolic_links_are_followed(self):
        os.mkdir(self.path("elsewhere"))
        os.symlink("elsewhere/real.json", self.path("link.json"))
        self.succeed("align", self.source, self.target, "--json", self.path("link.json"))
        self.assertTrue(os.path.islink(self.path("link.json")))
        self.checked(read(self.path("elsewhere/real.json")))

    def test_one_file_for_two_outputs(self):
        os.symlink(".", self.path("here"))
        for first, second in [("x.txt", "x.txt"), ("x.txt", "here/x.txt")]:
            self.fail_with(
                USAGE, "align", self.source, self.target, "--matrix", self.path(first), "--json", self.path(second),
                names=["--matrix", "--json"])
        self.fail_with(
            USAGE, "align", self.source, self.target, "-o", self.path("x.pcd"), "--json", self.path("x.pcd"),
            names=["-o", "--json"])
        self.fail_with(
            USAGE, "align", self.source, self.target, "-o", self.path("x.pcd"), "--both", self.path("x.pcd"),
            names=["-o", "--both"])

    def test_places_that_cannot_be_written(self):
        os.mkdir(self.path("directory.ply"))
        for arguments, why in [
            (["--matrix", self.path("none/m.txt")], "no directory"),
            (["--matrix", self.source + "/m.txt"], "source.pcd"),
            (["--json", self.path("none/r.json")], "no directory"),
            (["-o", self.path("none/out.pcd")], "no directory"),
            (["-o", self.path("directory.ply"), "--force"], "not a regular file"),
            (["--both", self.path("none/both.pcd")], "no directory"),
            (["--matrix", "/dev/null", "--force"], "not a regular file"),
            (["--matrix", self.path("x" * 300)], "name too long"),
        ]:
            with self.subTest(arguments):
                self.fail_with(OUTPUT, "align", self.source, self.target, *arguments, names=[arguments[0], why])
        self.assertTrue(os.path.exists("/dev/null"))

    def test_it_says_so_before_the_work(self):
        done = self.fail_with(OUTPUT, "align", self.path("no source"), self.path("no target"), "-o", self.source)
        self.assertEqual(done.stdout, "")

    def test_directory_without_permission(self):
        os.mkdir(self.path("locked"), 0o555)
        done = self.run_as_nobody("align", self.source, self.target, "--matrix", self.path("locked/m.txt"))
        self.assertEqual(done.returncode, OUTPUT, done)
        self.assertIn("Permission denied", done.stderr)

    def run_out_of_space(self, *arguments):
        """A limit that the cloud exceeds, and the files that PoCL keeps its kernels in do not."""
        places = surface(320, 240)
        random = os.urandom(64 * len(places))
        points = [(*p, *struct.unpack_from("<8Q", random, 64 * i)) for i, p in enumerate(places)]
        noise = [("noise", "U", 8, 8)]
        source = self.write("large.pcd", pcd(points, "binary", XYZ + noise))
        limit = 2 << 20
        done = self.fail_with(
            OUTPUT, "align", source, source, "--leaf", "1", *arguments, names=os.strerror(errno.EFBIG),
            preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit)))
        self.assertEqual(self.files(), self.inputs | {"large.pcd"})
        return done

    def test_no_partial_file_when_the_disk_is_full(self):
        self.assertIn("out.pcd", self.run_out_of_space("-o", self.path("out.pcd")).stderr)
        self.assertIn("both.ply", self.run_out_of_space("--both", self.path("both.ply")).stderr)

    def test_all_files_or_none(self):
        self.run_out_of_space(
            "--matrix", self.path("m.txt"), "--json", self.path("r.json"), "-o", self.path("out.pcd"))

    def test_standard_output_that_is_full(self):
        for arguments in (["align", self.source, self.target], ["align", self.source, self.target, "--json", "-"],
                          ["compare", self.source, self.target], ["devices"]):
            with self.subTest(arguments), open("/dev/full", "w") as full:
                done = self.run_command(*arguments, stdout=full)
                self.assertEqual(done.returncode, OUTPUT)
                self.assertEqual(done.stderr, "pcl_gpu_icp: standard output: No space left on device\n")

    def test_not_converged_writes_only_the_json(self):
        far = self.write("far.pcd", pcd([(x + 1000, y, z) for x, y, z in POINTS]))
        self.fail_with(
            NOT_CONVERGED, "align", self.source, far, "--once", "--max-distance", "1", "-o", self.path("out.pcd"),
            "--both", self.path("both.pcd"), "--matrix", self.path("m.txt"), "--json", self.path("r.json"), names=["no answer: no pair within", "not written"])
        self.assertEqual(self.files(), self.inputs | {"far.pcd", "r.json"})
        self.assertFalse(self.checked(read(self.path("r.json")))["converged"])
