"""Stock PCL and the plugin side by side."""

import json
import math
import os

from command import COMMAND, NOT_CONVERGED, USAGE, CommandTest, motion, moved, pcd, sampled_surface, surface

POINTS = surface()
MOTION = motion(3, (0.05, -0.08, 0.04))
TARGET = [moved(MOTION, point) for point in POINTS]
RUN_KEYS = {"converged", "reason", "iterations", "time_ms", "rmse", "fitness_score", "transform"}


class Compare(CommandTest):
    def setUp(self):
        super().setUp()
        self.source = self.write("source.pcd", pcd(POINTS))
        self.target = self.write("target.pcd", pcd(TARGET))

    def test_json(self):
        result = json.loads(self.succeed("compare", self.source, self.target, "--json", "-"))
        self.assertEqual(result["version"], os.environ["PCL_GPU_ICP_VERSION"])
        self.assertEqual(result["arguments"], [COMMAND, "compare", self.source, self.target, "--json", "-"])
        self.assertEqual(set(result["stock"]), RUN_KEYS)
        self.assertEqual(set(result["plugin"]), RUN_KEYS | {"start_ms", "verdict", "reasons"})
        self.assertTrue(result["agree"])
        self.assertEqual(result["tolerance"], {"degrees": 0.01, "metres": 0.001})
        for run in (result["stock"], result["plugin"]):
            self.assertTrue(run["converged"])
            self.assert_maps(run["transform"], POINTS, TARGET, 1e-4)
            self.assertLess(run["rmse"], 1e-4)
            self.assertAlmostEqual(run["rmse"] ** 2, run["fitness_score"], delta=1e-12)
        self.assertAlmostEqual(result["speedup"], result["stock"]["time_ms"] / result["plugin"]["time_ms"])
        centroid = [sum(p[i] for p in POINTS) / len(POINTS) for i in range(3)]
        for found, expected in zip(result["centroid"], centroid):
            self.assertAlmostEqual(found, expected, places=5)
        images = [moved(result[name]["transform"], centroid) for name in ("stock", "plugin")]
        self.assertAlmostEqual(result["difference"]["metres"], math.dist(*images), delta=1e-6)

    def test_summary(self):
        text = self.succeed("compare", self.source, self.target, "--iterations", "5")
        for expected in ("pcl_gpu_icp", "iterations", "reason", "RMSE", "fitness", "speed", "degrees", "within"):
            self.assertIn(expected, text)

    def test_difference_beyond_the_tolerances(self):
        # Two roundings of one rotation are never the same in all digits.
        arguments = ["compare", self.source, self.target, "--iterations", "7"]
        done = self.fail_with(
            NOT_CONVERGED, *arguments, "--tolerance-degrees", "1e-30", "--tolerance-distance", "1e-30",
            names=[self.source, self.target, "tolerances"])
        self.assertIn("more than", done.stdout)
        self.fail_with(NOT_CONVERGED, *arguments, "--tolerance-degrees", "1e-30", names="tolerances")
        self.succeed(*arguments, "--tolerance-degrees", "1", "--tolerance-distance", "1")

    def test_metric_plane(self):
        source = self.write("hills.pcd", pcd(sampled_surface(1500, seed=2)))
        target = self.write("more_hills.pcd", pcd([moved(MOTION, point) for point in sampled_surface(3000, seed=1)]))
        arguments = ["compare", source, target, "--iterations", "8"]
        by_planes, by_points = (
            json.loads(self.succeed(*arguments, "--metric", metric, "--json", "-")) for metric in ("plane", "point"))
        self.assertEqual((by_planes["metric"], by_points["metric"]), ("plane", "point"))
        for name in ("stock", "plugin"):
            images = [moved(run[name]["transform"], run["centroid"]) for run in (by_planes, by_points)]
            self.assertGreater(math.dist(*images), 2e-3, "the other metric has not got as far")
        self.assertIn("\nmetric      plane\n", self.succeed(*arguments, "--metric", "plane"))

    def test_metric_symmetric(self):
        source = self.write("hills.pcd", pcd(sampled_surface(1500, seed=2)))
        target = self.write("more_hills.pcd", pcd([moved(MOTION, point) for point in sampled_surface(3000, seed=1)]))
        report = json.loads(self.succeed("compare", source, target, "--metric", "symmetric", "--iterations", "8",
                                         "--json", "-"))
        self.assertEqual(report["metric"], "symmetric")
        self.assertLess(report["plugin"]["iterations"], 9)

    def test_metric_gicp(self):
        source = self.write("hills.pcd", pcd(sampled_surface(1500, seed=2)))
        target = self.write("more_hills.pcd", pcd([moved(MOTION, point) for point in sampled_surface(3000, seed=1)]))
        report = json.loads(self.succeed("compare", source, target, "--metric", "gicp", "--json", "-",
                                         "--tolerance-degrees", "0.2", "--tolerance-distance", "0.01"))
        self.assertEqual(report["metric"], "gicp")
        self.fail_with(USAGE, "compare", source, target, "--metric", "gicp", "--trim", "0.9", names=["gicp", "--trim"])
        for name in ("stock", "plugin"):
            self.assertGreater(report[name]["iterations"], 1)
            self.assertLess(math.dist(moved(report[name]["transform"], report["centroid"]),
                                      moved(MOTION, report["centroid"])), 0.01)

    def test_stock_without_an_answer(self):
        """Where a plane leaves motions free stock's six equations are singular, and what follows from that ends PCL."""
        square = [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (1.0, 1.0, 0.0)]
        circle = [(math.cos(i / 9) * (2 + 0.3 * math.sin(i)), math.sin(i / 9) * 2, 0.0) for i in range(57)]
        floor = [(x, y, 0.0) for x, y, _ in POINTS]
        for points in (square, circle, floor):
            source = self.write("flat_source.pcd", pcd([(x + 0.01, y, z + 0.1) for x, y, z in points]))
            target = self.write("flat_target.pcd", pcd(points))
            arguments = ["compare", source, target, "--metric", "plane"]
            done = self.fail_with(NOT_CONVERGED, *arguments, names=[source, target, "stock: no answer: "])
            self.assertRegex(done.stdout, r"\ntime +no answer +[0-9.]+ ms\n")
            self.assertRegex(done.stdout, r"\niterations +no answer +\d+\n")
            self.assertIn("\nstock: no answer: ", done.stdout)
            done = self.fail_with(NOT_CONVERGED, *arguments, "--json", "-", names="stock: no answer")
            result = json.loads(done.stdout)
            self.assertEqual([result[key] for key in ("stock", "speedup", "difference", "agree")],
                             [None, None, None, False])
            self.assertTrue(result["stock_failure"])
            self.assertAlmostEqual(result["plugin"]["transform"][2][3], -0.1, places=5)

    def test_stock_that_takes_too_long(self):
        arguments = ["compare", self.source, self.target, "--stock-limit", "1e-9", "--json", "-"]
        done = self.fail_with(NOT_CONVERGED, *arguments, names="stock: no answer: no end within 1e-09 s")
        result = json.loads(done.stdout)
        self.assertTrue(result["plugin"]["converged"])

    def test_the_settings_reach_both(self):
        arguments = ["--iterations", "3", "--max-distance", "0.2", "--trim", "0.5", "--reciprocal", "--pipeline", "staged"]
        result = json.loads(self.succeed("compare", self.source, self.target, *arguments, "--json", "-"))
        self.assertEqual((result["stock"]["iterations"], result["plugin"]["iterations"]), (3, 3))
        self.assertEqual((result["stock"]["reason"], result["plugin"]["reason"]), ("iterations", "iterations"))
        self.assertEqual(result["pipeline"], "staged")
        epsilon = ["--translation-epsilon", "1", "--rotation-epsilon", "90"]
        result = json.loads(self.succeed("compare", self.source, self.target, *epsilon, "--json", "-"))
        self.assertEqual((result["stock"]["reason"], result["plugin"]["reason"]), ("transform", "transform"))

    def test_neither_converges(self):
        far = self.write("far.pcd", pcd([(x + 1000, y, z) for x, y, z in POINTS]))
        self.fail_with(NOT_CONVERGED, "compare", self.source, far, "--max-distance", "1", names="no correspondences")

    def test_a_preset_whose_loss_stock_has_not_is_refused_by_its_name(self):
        self.fail_with(USAGE, "compare", self.source, self.target, "--preset", "lidar",
                       names=["--preset lidar", "--loss huber", "--loss none leaves its --metric plane"])
        self.succeed("compare", self.source, self.source, "--preset", "object", "--loss", "none")

    def test_real_scans(self):
        self.succeed("compare", self.shared("bunny_0.pcd"), self.shared("bunny_45.pcd"), "--iterations", "30")
