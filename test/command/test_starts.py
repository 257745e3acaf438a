"""Where an alignment starts when nothing is said of it, and what it tries before it gives up."""

import math
import os

from batches import BatchTest
from command import NOT_CONVERGED, motion, moved, pcd, sampled_surface

HALF, ROOT = -0.5, 0.75**0.5
AWAY = [[1, 0, 0, 0], [0, HALF, -ROOT, 0], [0, ROOT, HALF, 0], [0, 0, 0, 1]]  # 120 degrees about x
NEAR = motion(8, (0.2, -0.15, 0.1))


class Starts(BatchTest):
    def setUp(self):
        super().setUp()
        wall = [(2.5, 0.02 * i - 1, 0.01 * (i * 37 % 100)) for i in range(100)]
        self.scene = sampled_surface(2000, seed=1) + wall
        scans = {
            "scene.pcd": self.scene,
            "turned.pcd": [moved(AWAY, point) for point in self.scene],
            "near.pcd": [moved(NEAR, point) for point in self.scene],
            "left.pcd": [point for point in sampled_surface(4000, seed=2) if point[0] < 0.2],
            "right.pcd": [moved(NEAR, point) for point in sampled_surface(4000, seed=1) if point[0] > -0.8],
            "line.pcd": [(0.01 * i, 0.02 * i, 0.03 * i) for i in range(300)]}
        for name, points in scans.items():
            self.write(name, pcd(points))

    def tried(self, source, target, *arguments):
        done = self.run_command("align", self.path(source), self.path(target), *arguments, "--json", "-")
        result = self.checked(done.stdout)
        [taken] = [start for start in result["tried"] if start["taken"]]
        self.assertEqual(taken["verdict"], result["verdict"])
        return result, [start["from"] for start in result["tried"]], taken["from"]

    def test_what_is_good_is_tried_once(self):
        result, tried, _ = self.tried("scene.pcd", "near.pcd")
        self.assertEqual((result["verdict"], tried), ("good", ["the guess"]))
        self.assertNotIn("\ntried ", self.succeed("align", self.path("scene.pcd"), self.path("near.pcd")))

    def test_what_is_turned_away_is_found(self):
        result, tried, taken = self.tried("scene.pcd", "turned.pcd")
        self.assertEqual((result["verdict"], taken), ("good", "a search"))
        self.assertEqual(tried, ["the guess", "what they have in common", "a search"])
        self.assert_maps(result["transform"], self.scene, [moved(AWAY, point) for point in self.scene], 1e-3)
        self.assertGreater(result["searched_guess"]["starts"], 1)
        once, _, _ = self.tried("scene.pcd", "turned.pcd", "--once")  # before is at the guess all the same
        for found in (lambda of: of["rmse_before"], lambda of: of["quality"]["source_near"]["before"]):
            self.assertEqual(found(result), found(once))
        text = self.succeed("align", self.path("scene.pcd"), self.path("turned.pcd"))
        self.assertRegex(text, r"\ntried      from the guess: wrong\n           from what they have in common: \w+\n"
                               r"           from a search: good, taken\n")

    def test_what_fits_in_several_ways_is_doubted(self):
        """Hills that are as they were after half a turn about y, and in part on others: any of these poses does well."""
        self.write("hills.pcd", pcd(sampled_surface(2000, seed=1)))
        for degrees in (120, 150, 180):
            with self.subTest(degrees=degrees):
                away = [moved(motion(degrees, (0, 0, 0)), point) for point in sampled_surface(2000, seed=101)]
                self.write("away.pcd", pcd(away))
                result, tried, _ = self.tried("hills.pcd", "away.pcd")
                self.assertIn("a search", tried)
                self.assertEqual(result["verdict"], "doubtful")
                self.assertRegex(result["reasons"][0], r"^two poses fit: another, 1[78]\d degrees")
                os.remove(self.path("away.pcd"))

    def test_a_guess_that_is_given_is_kept_to(self):
        result, tried, _ = self.tried("scene.pcd", "turned.pcd", "--guess", "1 0 0 0 0 1 0 0 0 0 1 0")
        self.assertEqual(tried, ["the guess", "what they have in common"])
        self.assertEqual(result["advice"][0], "--guess auto searches for where to start")

    def test_a_guess_about_another_origin(self):
        """As CloudCompare's console has it, where it shifted the clouds: nothing is determined, and a search is advised."""
        result, _, _ = self.tried(
            "scene.pcd", "turned.pcd", "--guess", "1 0 0 9000 0 1 0 9000 0 0 1 9000", "--metric", "plane")
        self.assertEqual(result["verdict"], "wrong")
        self.assertIn("--guess auto searches for where to start", result["advice"])

    def test_once_is_once(self):
        result, tried, _ = self.tried("scene.pcd", "turned.pcd", "--once")
        self.assertEqual((result["verdict"], tried), ("wrong", ["the guess"]))
        self.assertEqual(result["advice"][0], "without --once other starts are tried")

    def test_what_overlaps_in_part_is_found(self):
        common = [point for point in sampled_surface(300, seed=3) if -0.8 < point[0] < 0.2]
        where = [moved(NEAR, point) for point in common]
        for metric, close in (("point", 0.1), ("plane", 0.05)):
            with self.subTest(metric):
                result, tried, taken = self.tried("left.pcd", "right.pcd", "--metric", metric)
                self.assertEqual(tried[:2], ["the guess", "what they have in common"])
                self.assertEqual((taken, result["loss"]["function"]), (tried[1], "geman-mcclure"))
                self.assert_maps(result["transform"], common, where, close)
                once, _, _ = self.tried("left.pcd", "right.pcd", "--metric", metric, "--once")
                with self.assertRaises(AssertionError):
                    self.assert_maps(once["transform"], common, where, 10 * close)

    def test_what_overlaps_to_gicp(self):
        """Whose residuals are no distances."""
        common = [point for point in sampled_surface(300, seed=3) if -0.8 < point[0] < 0.2]
        result, _, _ = self.tried("left.pcd", "right.pcd", "--metric", "gicp", "--overlap", "auto", "--once")
        self.assertGreater(result["loss"]["scale"], 10 * result["quality"]["spacing"])
        self.assert_maps(result["transform"], common, [moved(NEAR, point) for point in common], 0.05)

    def test_the_loss_of_a_preset_gives_way_to_that_of_what_overlaps(self):
        common = [point for point in sampled_surface(300, seed=3) if -0.8 < point[0] < 0.2]
        where = [moved(NEAR, point) for point in common]
        result, tried, taken = self.tried("left.pcd", "right.pcd", "--preset", "lidar")
        self.assertEqual((taken, result["loss"]["function"]), ("what they have in common", "geman-mcclure"))
        self.assert_maps(result["transform"], common, where, 0.05)
        for loss in ("huber", "none"):
            given, tried, _ = self.tried(
                "left.pcd", "right.pcd", "--preset", "lidar", "--loss", loss, "--overlap", "auto", "--once")
            self.assertEqual(tried, ["what they have in common"])
            self.assertEqual(given["loss"] and given["loss"]["function"], "huber" if loss == "huber" else None)

    def test_what_is_not_determined_is_not_taken_from_elsewhere(self):
        result, _, taken = self.tried("line.pcd", "line.pcd", "--metric", "plane")
        self.assertEqual((taken, result["ending"]), ("the guess", "undetermined"))

    def test_a_batch_tries_the_same(self):
        rows = [("scene.pcd", "turned.pcd"), ("left.pcd", "right.pcd"), ("scene.pcd", "near.pcd")]
        results, _ = self.batch(self.manifest(rows))
        for place, pair in enumerate(rows):
            alone, _, _ = self.tried(*pair)
            for key in ("transform", "tried", "overlap", "searched_guess", "loss", "verdict"):
                self.assertEqual(results[place][key], alone[key])
        self.batch(self.manifest(rows), "--once", "--force", code=NOT_CONVERGED)

    def test_a_thousandth_of_the_spacing_ends_it(self):
        by_default, _, _ = self.tried("left.pcd", "near.pcd", "--once", "--iterations", "1000")
        to_the_end, _, _ = self.tried("left.pcd", "near.pcd", "--once", "--iterations", "1000", "--translation-epsilon", "0")
        self.assertEqual(by_default["reason"], "transform")
        self.assertNotEqual(to_the_end["reason"], "transform")
        self.assertLess(by_default["iterations"], to_the_end["iterations"])
        where_it_ends = [moved(to_the_end["transform"], point) for point in self.scene]
        self.assert_maps(by_default["transform"], self.scene, where_it_ends, 0.1 * to_the_end["quality"]["spacing"])
