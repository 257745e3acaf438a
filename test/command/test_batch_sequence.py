"""Consecutive scans: each onto the one before, and the trajectory."""

import math
import os
import pathlib

from batches import POINTS, BatchTest
from command import INPUT, NOT_CONVERGED, motion, moved, pcd

SCANS = 12
# Where the scanner is, in the frame of scan 0; turns that add up to half a circle, so that every quaternion differs.
STEP = motion(3, (0.05, -0.04, 0.03))


def product(a, b):
    return [[sum(a[i][k] * b[k][j] for k in range(4)) for j in range(4)] for i in range(4)]


def inverse(m):
    rotation = [[m[j][i] for j in range(3)] for i in range(3)]
    shift = [-sum(rotation[i][k] * m[k][3] for k in range(3)) for i in range(3)]
    return [rotation[i] + [shift[i]] for i in range(3)] + [[0, 0, 0, 1]]


def poses(count):
    result = [motion(0, (0, 0, 0))]
    for _ in range(count - 1):
        result.append(product(result[-1], STEP))
    return result


class Sequence(BatchTest):
    def setUp(self):
        super().setUp()
        self.poses = poses(SCANS)
        for i, pose in enumerate(self.poses):
            self.write(f"scan_{i}.pcd", pcd([moved(inverse(pose), point) for point in POINTS], "binary"))
        self.pattern = self.path("scan_*.pcd")

    def rows(self, name, output="out"):
        text = pathlib.Path(self.path(output), name).read_text()
        return [[float(word) for word in line.split(" ")] for line in text.splitlines()]

    def test_trajectory(self):
        results, summary = self.batch("--sequence", self.pattern)
        scan = lambda i: self.path(f"scan_{i}.pcd")
        self.assertEqual([(results[i]["source"], results[i]["target"]) for i in range(SCANS - 1)],
                         [(scan(i + 1), scan(i)) for i in range(SCANS - 1)])
        self.assertEqual(results[9]["transform"], self.align(scan(10), scan(9))["transform"])
        trajectory = summary["trajectory"]
        self.assertEqual((trajectory["scans"], trajectory["poses"], trajectory["ends_before_pair"]), (SCANS, SCANS, None))
        self.assertEqual([os.path.basename(file) for file in trajectory["files"]],
                         ["trajectory.kitti.txt", "trajectory.tum.txt"])

        kitti, tum = self.rows("trajectory.kitti.txt"), self.rows("trajectory.tum.txt")
        self.assertEqual((len(kitti), len(tum)), (SCANS, SCANS))
        for i, (pose, row, line) in enumerate(zip(self.poses, kitti, tum)):
            for a, b in zip([value for matrix_row in pose[:3] for value in matrix_row], row):
                self.assertAlmostEqual(a, b, delta=2e-5)
            stamp, *position, x, y, z, w = line
            self.assertEqual((stamp, position), (i, [row[3], row[7], row[11]]))
            self.assertAlmostEqual(math.hypot(x, y, z, w), 1, delta=1e-12)
            rotation = [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w),
                        2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w),
                        2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]
            for a, b in zip(rotation, row[0:3] + row[4:7] + row[8:11]):
                self.assertAlmostEqual(a, b, delta=1e-12)
        self.assertEqual(kitti[0], [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0])

    def test_numbers_count(self):
        """scan_2 is before scan_10, with and without leading zeros."""
        results, _ = self.batch("--sequence", self.path("scan_*[012].pcd"), "--iterations", "1")
        self.assertEqual([os.path.basename(results[i]["source"]) for i in range(len(results))],
                         ["scan_1.pcd", "scan_2.pcd", "scan_10.pcd", "scan_11.pcd"][: len(results)])
        for name in ("b007.pcd", "b08.pcd", "b9.pcd", "b0010.pcd"):
            self.write(name, pcd(POINTS))
        results, _ = self.batch("--sequence", self.path("b*.pcd"), "--iterations", "1", output="zeros")
        self.assertEqual([os.path.basename(results[i]["source"]) for i in range(3)], ["b08.pcd", "b9.pcd", "b0010.pcd"])

    def test_the_trajectory_ends_before_a_pair_without_transform(self):
        self.write("scan_6.pcd", "broken")
        _, summary = self.batch("--sequence", self.pattern, code=NOT_CONVERGED)
        self.assertEqual((summary["failed"], summary["converged"]), (2, SCANS - 3))
        self.assertEqual((summary["trajectory"]["poses"], summary["trajectory"]["ends_before_pair"]), (6, 5))
        self.assertEqual((len(self.rows("trajectory.kitti.txt")), len(self.rows("trajectory.tum.txt"))), (6, 6))

    def test_resumed(self):
        self.batch("--sequence", self.pattern)
        before = {name: pathlib.Path(self.path("out"), name).read_text()
                  for name in ("trajectory.kitti.txt", "trajectory.tum.txt")}
        results = pathlib.Path(self.path("out/results.jsonl"))
        results.write_text("".join(results.read_text().splitlines(keepends=True)[::2]))
        _, summary = self.batch("--sequence", self.pattern, "--resume")
        self.assertEqual(summary["kept"], 6)
        for name, text in before.items():
            self.assertEqual(pathlib.Path(self.path("out"), name).read_text(), text)

    def test_too_few_scans(self):
        self.fail_with(INPUT, "batch", "--sequence", self.path("none_*.pcd"), "-o", self.path("out"),
                       names=["--sequence", "no file"])
        self.fail_with(INPUT, "batch", "--sequence", self.path("scan_0.pcd"), "-o", self.path("out"),
                       names=["--sequence", "only", "scan_0.pcd"])
