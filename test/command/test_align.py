"""What align computes, says and exits with."""

import functools
import math
import os
import re
import subprocess

from command import (
    COMMAND, DEVICE, IDENTITY, NOT_CONVERGED, SCHEMA, XYZ_DOUBLE, CommandTest, motion, moved, numbers, pcd, read_schema,
    surface)

POINTS = surface()
MOTION = motion(3, (0.05, -0.08, 0.04))
TARGET = [moved(MOTION, point) for point in POINTS]


class Align(CommandTest):
    def setUp(self):
        super().setUp()
        self.source = self.write("source.pcd", pcd(POINTS, "binary"))
        self.target = self.write("target.pcd", pcd(TARGET, "binary"))

    def test_json(self):
        result = self.align(self.source, self.target)
        self.assertEqual((result["source"], result["target"]), (self.source, self.target))
        self.assert_maps(result["transform"], POINTS, TARGET, 1e-4)
        self.assertEqual(result["transform"][3], [0, 0, 0, 1])
        self.assertTrue(result["converged"])
        self.assertEqual(result["reason"], "transform")
        self.assertEqual(result["inliers"], len(POINTS))
        self.assertEqual(result["points"]["source"], len(POINTS))
        self.assertEqual(result["points"]["target"], len(TARGET))
        self.assertEqual(result["degenerate"], "none")
        self.assertLess(result["rmse"], 1e-5)
        self.assertGreater(result["rmse_before"], 0.05)
        self.assertLess(result["fitness_score"], 1e-10)
        times = result["times_ms"]
        self.assertGreaterEqual(times["total"], times["align"])
        self.assertEqual(list(times)[-1], "total")

    def test_what_repeats_the_run(self):
        guess = motion(2.5, (0.04, -0.07, 0.03))
        result = self.align(self.source, self.target, "--guess", *numbers(guess))
        self.assertEqual(result["version"], os.environ["PCL_GPU_ICP_VERSION"])
        self.assertEqual(result["arguments"], [COMMAND, "align", self.source, self.target, "--guess", *numbers(guess),
                                               "--json", "-"])
        for row, given in zip(result["guess"], guess):
            for value, expected in zip(row, given):
                self.assertAlmostEqual(value, expected, places=12)
        self.assertEqual(self.align(self.source, self.target)["guess"], IDENTITY)
        found = self.align(self.source, self.target, "--guess", "auto")
        self.assertNotEqual(found["guess"], IDENTITY)
        self.assertEqual(self.align(self.source, self.target, "--threads", "1", "--search", "pcl")["threads"], 1)
        odd = os.fsencode(self.directory) + b"/\xff.pcd"
        with open(odd, "wb") as file:
            file.write(pcd(POINTS))
        done = subprocess.run([COMMAND, "align", odd, odd, "--json", "-"], capture_output=True, check=True)
        self.assertTrue(self.checked(done.stdout.decode())["arguments"][2].endswith("/\ufffd.pcd"))

    def test_every_number_has_a_unit(self):
        schema = read_schema(SCHEMA)

        def check(node, unit, where):
            unit = node.get("unit", unit)
            if "$ref" in node:
                check(functools.reduce(dict.get, node["$ref"].split("/")[1:], schema), unit, where)
            types = node.get("type", [])
            if {"number", "integer"} & set([types] if isinstance(types, str) else types):
                self.assertIsNotNone(unit, where)
            for name, child in node.get("properties", {}).items():
                check(child, unit, f"{where}.{name}")
            for key in ("items", "additionalProperties"):
                if isinstance(node.get(key), dict):
                    check(node[key], unit, f"{where}[]")

        check(schema, None, "result")

    def test_summary(self):
        text = self.succeed("align", self.source, self.target)
        result = self.align(self.source, self.target)
        self.assertTrue(text.startswith("verdict    good\nresult     converged after "))
        shift = math.dist((0, 0, 0), [row[3] for row in result["transform"][:3]])
        self.assertIn(f"\nmotion     shifts by {shift:.6g} along (", text)
        for expected in [
            f"{self.source}: 480 points, 480 used\n",
            f"{self.target}: 480 points, 480 used\n",
            result["device"]["name"],
            "pipeline fused",
            f"converged after {result['iterations']} iterations",
            "(improved)",
            "\npairs      480, 100 % of the source's points\n",
            " (mean squared distance to the nearest target point), its root ",
            "degenerate no\n",
            "search",
            "searched",
        ]:
            self.assertIn(expected, text)
        self.assertRegex(text, r"\ntimes      \d+\.\d ms: read \d+\.\d, device \d+\.\d, align \d+\.\d, fitness \d+\.\d\n\Z")
        self.assertNotIn("device_match", text)

    def test_every_time_with_verbose(self):
        lines = self.succeed("align", self.source, self.target, "--verbose").split("\ntimes      ")[1].splitlines()
        indents = {line.split()[0]: len(line) - len(line.lstrip()) for line in lines[1:]}
        self.assertEqual(lines[0].split()[0], "total")
        self.assertEqual({indents[what] for what in ("read", "device", "align", "fitness")}, {13})
        self.assertEqual({indents[what] for what in ("start", "tree", "search")}, {15})
        self.assertEqual(indents["device_match"], 17)
        names = list(indents)
        self.assertLess(names.index("align"), names.index("tree"))
        self.assertLess(names.index("tree"), names.index("fitness"))
        self.assertEqual(set(names) | {"total"}, set(self.align(self.source, self.target)["times_ms"]))

    def test_a_motion_in_words(self):
        turn = motion(90, (0, 0, 3))
        guess = " ".join(str(value) for row in turn[:3] for value in row)
        turned = self.write("turned.pcd", pcd([moved(turn, point) for point in POINTS], "binary", XYZ_DOUBLE))
        text = self.succeed("align", self.source, turned, "--guess", guess)
        self.assertIn("\nmotion     shifts by 3 along (0, 0, 1), turns by 90 degrees about (0.27, 0.53, 0.8)\n", text)
        self.assertNotIn("-0.0000000000", text)

    def test_a_motion_of_what_is_far_from_the_origin_is_that_of_its_middle(self):
        corner = (433000, 5411000, 200)
        far = lambda points: [tuple(p + c for p, c in zip(point, corner)) for point in points]
        about = lambda point: tuple(m + c for m, c in zip(moved(MOTION, [p - c for p, c in zip(point, corner)]), corner))
        source = self.write("far.pcd", pcd(far(POINTS), "binary", XYZ_DOUBLE))
        target = self.write("turned.pcd", pcd([about(point) for point in far(POINTS)], "binary", XYZ_DOUBLE))
        text = self.succeed("align", source, target)
        shift = re.search(r"\nmotion     shifts the source's middle by (\S+) along .*, turns by (\S+) degrees about", text)
        middle = [sum(axis) / len(POINTS) for axis in zip(*POINTS)]
        self.assertAlmostEqual(float(shift[1]), math.dist(moved(MOTION, middle), middle), places=4)
        self.assertAlmostEqual(float(shift[2]), 3, places=3)
        self.assertNotIn(" -0 ", text)

    def test_same_bits_on_every_run(self):
        first, second = (self.align(self.source, self.target) for _ in range(2))
        self.assertEqual(first["transform"], second["transform"])

    def test_an_alignment_that_changes_nothing(self):
        self.assertIn("(unchanged)", self.succeed("align", self.source, self.source))

    def test_every_point_is_accounted_for(self):
        nan = float("nan")
        zeros = [(0.0, 0.0, 0.0)] * 11
        source = self.write("s.pcd", pcd(POINTS + zeros + [(nan, 1.0, 1.0)] * 3))
        target = self.write("t.pcd", pcd(TARGET + zeros + [(1.0, nan, 1.0)] * 4 + TARGET[:5]))
        result = self.align(source, target, "--drop-zero-returns")
        # POINTS[0] is itself at the origin.
        self.assertEqual(
            result["points"],
            {
                "source": 479,
                "target": 480,
                "dropped": {
                    "source": {"non_finite": 3, "zero_returns": 12, "downsampled": 0, "coincident": 0},
                    "target": {"non_finite": 4, "zero_returns": 11, "downsampled": 0, "coincident": 5},
                },
            },
        )
        text = self.succeed("align", source, target, "--drop-zero-returns")
        self.assertIn("494 points, 479 used (dropped: 3 not finite, 12 zero returns)", text)
        self.assertIn("5 coincident with another)", text)
        kept = self.align(source, target, "--quiet", "--drop-zero-returns=false")
        self.assertEqual(kept["points"]["source"], 491)

    def test_no_correspondences(self):
        far = self.write("far.pcd", pcd([(x + 1000, y, z) for x, y, z in POINTS]))
        arguments = ["align", self.source, far, "--once", "--max-distance", "1", "--json", "-"]
        done = self.fail_with(NOT_CONVERGED, *arguments, names=[self.source, far, "no answer: no pair within"])
        result = self.checked(done.stdout)
        self.assertFalse(result["converged"])
        self.assertEqual(result["reason"], "no correspondences")
        self.assertEqual(result["transform"], IDENTITY)
        self.assertEqual(result["inliers"], 0)
        self.assertIsNone(result["rmse"])
        self.assertIsNone(result["rmse_before"])

    def test_a_name_that_is_no_utf8(self):
        name = bytes(self.directory) + b"/\xff.pcd"
        with open(name, "wb") as file:
            file.write(pcd(POINTS))
        result = self.checked(self.succeed("align", os.fsdecode(name), self.target, "--json", "-"))
        self.assertTrue(result["source"].endswith("\ufffd.pcd"))


class Devices(CommandTest):
    def setUp(self):
        super().setUp()
        self.cloud = self.write("cloud.pcd", pcd(POINTS))

    def test_a_selection_that_matches_nothing(self):
        self.fail_with(DEVICE, "align", self.cloud, self.cloud, "--device", "nosuch", names="nosuch")
        self.fail_with(DEVICE, "compare", self.cloud, self.cloud, "--device", "nosuch", names="nosuch")
        self.fail_with(DEVICE, "align", self.cloud, self.cloud, environment={"PCL_GPU_ICP_DEVICE": "nosuch"},
                       names="nosuch")

    def test_no_opencl_at_all(self):
        none = {"OCL_ICD_VENDORS": self.path("")}
        self.fail_with(DEVICE, "align", self.cloud, self.cloud, environment=none, names="pocl-opencl-icd")
        self.fail_with(DEVICE, "compare", self.cloud, self.cloud, environment=none, names="pocl-opencl-icd")


class RealScans(CommandTest):
    def test_street(self):
        result = self.align(
            self.shared("lidar_street_0.pcd"), self.shared("lidar_street_1.pcd"), "--drop-zero-returns", "--leaf", "0.5",
            "--max-distance", "1", "--iterations", "40")
        self.assertEqual(result["points"]["dropped"]["source"]["zero_returns"], 5032)
        self.assertEqual(result["points"]["dropped"]["target"]["zero_returns"], 5107)
        self.assertLess(result["rmse"], result["rmse_before"])
        # The inverse of lidar_street_T_0_1.txt, to what point-to-point ICP can do here.
        for i, expected in enumerate((-0.4868, -0.1011, 0.0141)):
            self.assertAlmostEqual(result["transform"][i][3], expected, delta=0.1)

    def test_utm_terrain(self):
        terrain = self.shared("terrain_utm.pcd")
        result = self.align(terrain, terrain, "--iterations", "3", "--quiet")
        self.assertEqual(result["rmse_before"], 0)
        self.assertLess(result["rmse"], 1e-6)
