"""Files in: every kind that is read, and every lie that is found out in one line, exit 3."""

import os
import resource
import struct

from command import (
    INPUT, INTERNAL, SANITIZED, XYZ, XYZ_DOUBLE, CommandTest, motion, moved, numbers, pcd, pcd_header, ply, surface)

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
        self.refuse(b"\0" * 1000, "not a PCD or PLY file")
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

    def test_coordinates_that_are_no_reals(self):
        self.refuse(pcd([(1, 2, 3)] * 5, fields=[(n, "I", 4, 1) for n in "xyz"]), "field x is not one float or double")
        self.refuse(ply([(1, 2, 3)] * 5, properties=[("int", n) for n in "xyz"]), "field x is not one float or double")
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
            ("COUNT 1 1 1", "COUNT 1 1 0", "COUNT 0"),
            ("COUNT 1 1 1", "COUNT 1 1 99999999", "COUNT"),
            ("FIELDS x y z", "FIELDS", "FIELDS"),
            ("DATA ascii", "DATA morse", "DATA morse"),
            ("VIEWPOINT 0 0 0 1 0 0 0", "VIEWPOINT 0 0", "VIEWPOINT"),
        ]:
            with self.subTest(new):
                self.assertIn(old, header)
                self.refuse(header.replace(old, new) + body, why)

    def test_values_that_are_no_numbers(self):
        header = pcd_header(XYZ, 2, "ascii")
        self.refuse(header + "1 2 3\n4 five 6\n", "point 2, field y: 'five'")
        self.refuse(header + "1 2 3\n4 5,5 6\n", "point 2, field y: '5,5'")
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
            ("property float z", "property list uchar float z", "property z is a list"),
            ("comment test", "property float q", "property of no element"),
            ("comment test", "nonsense", "nonsense"),
            ("end_header", "end_footer", "end_footer"),
        ]:
            with self.subTest(new):
                self.assertIn(old, good)
                self.refuse(good.replace(old, new, 1), why)
        self.refuse("ply\nformat ascii 1.0\n", "does not end")

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


class GoodInputs(CommandTest):
    def aligned(self, source, target, *arguments):
        result = self.align(self.write("source.file", source), self.write("target.file", target), *arguments)
        self.assertTrue(result["converged"])
        return result

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
        after = "element face 1\nproperty list uchar int vertex_indices\n"
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
