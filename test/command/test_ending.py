"""Exit code, words and numbers tell whether there is an answer."""

import math
import os
import random

from batches import BatchTest
from command import IDENTITY, NOT_CONVERGED, motion, moved, pcd, surface

POINTS = surface()
MOTION = motion(3, (0.05, -0.08, 0.04))
TARGET = [moved(MOTION, point) for point in POINTS]


def room(turn=0.0, shift=(0.0, 0.0)):
    """What a scanner that turns in one plane sees of a room with two pillars."""
    points = []
    for i in range(240):
        angle = 2 * math.pi * i / 240
        c, s = math.cos(angle), math.sin(angle)
        distance = min(3 / max(abs(c), 1e-9), 2 / max(abs(s), 1e-9))
        if i % 40 < 5:
            distance *= 0.6 + 0.01 * (i // 40)
        x, y = c * distance, s * distance
        points.append((math.cos(turn) * x - math.sin(turn) * y + shift[0],
                       math.sin(turn) * x + math.cos(turn) * y + shift[1], 0.0))
    return points


def scattered(count, seed):
    generator = random.Random(seed)
    return [tuple(generator.random() for _ in range(3)) for _ in range(count)]


def jittered(points, by, seed):
    generator = random.Random(seed)
    return [tuple(value + generator.gauss(0, by) for value in point) for point in points]


class Endings(BatchTest):
    def setUp(self):
        super().setUp()
        self.number = 0

    def cloud(self, points):
        self.number += 1
        return self.write(f"cloud_{self.number}.pcd", pcd(points))

    def no_answer(self, source, target, *arguments, ending, says, verdict="wrong"):
        """Neither align nor a batch calls it converged, and neither writes what is no answer."""
        arguments = (*arguments, "--once")
        output = self.path("aligned.pcd")
        done = self.fail_with(
            NOT_CONVERGED, "align", source, target, *arguments, "--json", "-", "-o", output, names=[source, *says])
        result = self.checked(done.stdout)
        self.assertEqual((result["ending"], result["verdict"], result["converged"]), (ending, verdict, False))
        self.assertFalse(os.path.exists(output))
        for words in says:
            self.assertIn(words, result["why"])
        text = self.run_command("align", source, target, *arguments).stdout
        self.assertNotIn("result     converged", text)
        self.assertIn("\nresult     " + result["why"] + "\n", text)

        rows = [(os.path.basename(source), os.path.basename(target))]
        results, summary = self.batch(self.manifest(rows), *arguments, "--force", code=NOT_CONVERGED)
        self.assertEqual((results[0]["status"], results[0]["why"]), ("not converged", result["why"]))
        self.assertEqual((summary["converged"], summary["at_the_limit"], summary["not_converged"]), (0, 0, 1))
        self.assertEqual(summary["unsuccessful"][0]["why"], result["why"])
        again = self.run_command("batch", self.manifest(rows), "-o", self.path("out"), *arguments, "--resume")
        self.assertEqual(again.returncode, NOT_CONVERGED, again)
        self.assertIn(result["why"], again.stdout)
        return result, text

    def test_planes_that_leave_motions_free(self):
        seen, from_elsewhere = self.cloud(room()), self.cloud(room(0.03, (0.1, -0.05)))
        for search in ("pcl", "device"):
            result, text = self.no_answer(
                from_elsewhere, seen, "--metric", "plane", "--search", search, ending="undetermined", verdict="doubtful",
                says=["not determined", "3 only slide"])
            self.assertEqual((result["degenerate"], result["free_motions"]), ("sliding", 3))
            self.assertIn("\ndegenerate yes", text)
        floor = [(x, y, 0.0) for x, y, _ in POINTS]
        self.no_answer(self.cloud([(x, y, 0.1) for x, y, _ in floor]), self.cloud(floor), "--metric", "plane",
                       ending="undetermined", verdict="doubtful", says=["3 only slide"])

    def test_points_in_a_plane_determine_a_pose(self):
        result = self.align(self.cloud(room(0.03, (0.1, -0.05))), self.cloud(room()))
        self.assertEqual((result["ending"], result["degenerate"], result["why"]), ("converged", "none", None))
        square = [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (1.0, 1.0, 0.0)]
        result = self.align(self.cloud([(x + 0.1, y, z) for x, y, z in square]), self.cloud(square))
        self.assertEqual(result["ending"], "converged")

    def test_points_on_a_line_or_at_one_place(self):
        line = self.cloud([(0.1 * i, 0.2 * i, 0.3 * i) for i in range(50)])
        self.no_answer(line, line, ending="undetermined", verdict="doubtful", says=["one line"])
        spot = self.cloud([(1.0, 2.0, 3.0)] * 50)
        self.no_answer(spot, spot, ending="undetermined", verdict="doubtful", says=["one place"])

    def worsening(self):
        """Planes through points that are scattered all over lead away from a guess that was nearly right."""
        target = scattered(60, seed=4)
        return self.cloud(jittered(target, 0.004, seed=5)), self.cloud(target)

    def test_worse_at_the_limit(self):
        for search in ("pcl", "device"):
            result, text = self.no_answer(
                *self.worsening(), "--metric", "plane", "--iterations", "2", "--search", search, ending="got worse",
                says=["limit of 2 iterations", "farther from the target"])
            self.assertEqual(result["reason"], "iterations")
            self.assertIn("(got worse)", text)

    def test_what_got_worse_counts_apart_in_a_batch(self):
        rows = [(*(os.path.basename(file) for file in self.worsening()), "plane"), ("none.pcd", "none.pcd", "")]
        done = self.run_command("batch", self.manifest(rows, ("source", "target", "metric")), "-o", self.path("out"),
                                "--iterations", "2", "--once")
        self.assertIn("pairs      2: 0 converged, 1 without an answer (1 got worse), 1 failed\n", done.stdout)
        summary = self.summary()
        self.assertEqual((summary["not_converged"], summary["got_worse"], summary["failed"]), (1, 1, 1))
        again = self.run_command("batch", self.path("manifest.csv"), "-o", self.path("out"), "--iterations", "2", "--once",
                                 "--resume")
        self.assertIn("1 without an answer (1 got worse), 1 failed (2 were there already)\n", again.stdout)

    def test_a_point_far_from_all_others_does_not_decide(self):
        """It makes up the whole RMSE, of which only the rounding changes."""
        for far in (1e6, 2e10):
            source = self.cloud(POINTS + [(far, 0.0, 0.0)])
            for iterations in range(2, 9):
                result = self.align(source, self.cloud(TARGET), "--trim", "0.9", "--iterations", str(iterations))
                self.assertIn(result["ending"], ("at the limit", "converged"), (far, iterations))

    def test_the_limit_counts_apart(self):
        source, target = self.cloud(POINTS), self.cloud(TARGET)
        result = self.align(source, target, "--iterations", "2")
        self.assertEqual((result["ending"], result["reason"], result["why"]), ("at the limit", "iterations", None))
        text = self.succeed("align", source, target, "--iterations", "2", "-o", self.path("aligned.pcd"))
        self.assertIn("result     stopped at the limit of 2 iterations, before it converged\n", text)
        self.assertTrue(os.path.exists(self.path("aligned.pcd")))

        rows = [("cloud_1.pcd", "cloud_2.pcd", iterations) for iterations in ("2", "", "2")]
        manifest = self.manifest(rows, ("source", "target", "iterations"))
        text = self.succeed("batch", manifest, "-o", self.path("out"))
        self.assertEqual([self.results()[i]["status"] for i in range(3)], ["at the limit", "converged", "at the limit"])
        summary = self.summary()
        self.assertEqual([summary[key] for key in ("converged", "at_the_limit", "not_converged", "got_worse", "left")],
                         [1, 2, 0, 0, 0])
        self.assertIn("pairs      3: 1 converged, 2 at the limit, 0 without an answer, 0 failed\n", text)
        self.assertIn("cloud_1.pcd onto cloud_2.pcd: at the limit, 2 iterations, RMSE", text)
        again = self.succeed("batch", manifest, "-o", self.path("out"), "--resume", "--fail-fast")
        self.assertIn("1 converged, 2 at the limit", again)

    def test_a_grid_as_coarse_as_the_cloud(self):
        for metric in ("point", "plane"):
            result, _ = self.no_answer(
                self.cloud(POINTS), self.cloud(TARGET), "--leaf", "4", "--metric", metric, ending="too coarse",
                says=["--leaf", f"of the {len(POINTS)} points"])
            self.assertLessEqual(result["points"]["source"], 8)
        few = self.cloud(scattered(9, seed=1))
        self.assertEqual(self.align(few, few, "--leaf", "0.001")["ending"], "converged")

    def test_no_pairs_within_the_distance(self):
        far = self.cloud([(x, y, z + 7) for x, y, z in POINTS])
        for search in ("pcl", "device"):
            result, text = self.no_answer(
                self.cloud(POINTS), far, "--max-distance", "0.1", "--search", search, ending="too few pairs",
                says=["no answer: no pair within --max-distance 0.1", "the nearest source point is 6."])
            least = min(math.dist(p, (x, y, z + 7)) for p in POINTS for x, y, z in POINTS)
            self.assertAlmostEqual(result["nearest_distance"], least, places=5)
            self.assertEqual((result["degenerate"], result["inliers"], result["rmse"]), ("empty", 0, None))
            self.assertEqual(result["transform"], IDENTITY)
            self.assertIn("\ndegenerate yes: no points were matched, so nothing is determined\n", text)

    def test_fewer_pairs_than_needed(self):
        target = self.cloud(POINTS)
        for count, degenerate, words in [(1, "point", "1 pair, where 3 are needed"),
                                         (2, "line", "2 pairs, where 3 are needed")]:
            near = self.cloud([(x, y, z + 0.01) for x, y, z in POINTS[:count]])
            result, text = self.no_answer(
                near, target, ending="too few pairs", says=[words, "the nearest source point is 0.0"])
            self.assertEqual((result["degenerate"], result["inliers"]), (degenerate, count))
            self.assertRegex(text, f"\ndegenerate yes: {count} matched points?, where 3 are needed\n")
        far = [(x, y, z + 100) for x, y, z in POINTS]
        some = self.cloud([*POINTS[:2], *far])
        self.no_answer(some, target, "--max-distance", "0.5", ending="too few pairs",
                       says=["2 pairs within --max-distance 0.5, where 3 are needed; the nearest source point is 0 from"])

    def test_an_answer_has_no_nearest_distance(self):
        self.assertIsNone(self.align(self.cloud(POINTS), self.cloud(TARGET))["nearest_distance"])
