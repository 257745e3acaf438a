"""Whether to believe a pose: what is said of it, where, and what exit codes follow."""

import os
import pathlib

from batches import BatchTest
from command import NOT_CONVERGED, motion, moved, pcd, surface

POINTS = surface()
NEAR = [moved(motion(3, (0.05, -0.08, 0.04)), point) for point in POINTS]
FAR = [moved(motion(120, (0.0, 0.0, 0.0)), point) for point in POINTS]
# The shell of a box in which there is room for all of it.
BOX = [tuple(face if i == axis else (a, b)[i - (i > axis)] for i in range(3))
       for axis in range(3) for face in (-6, 6) for a in range(-6, 7, 2) for b in range(-6, 7, 2)]
FLOOR = [(0.1 * i, 0.1 * j, 0.0) for i in range(20) for j in range(20)]


class Verdicts(BatchTest):
    def setUp(self):
        super().setUp()
        for name, points in {
                "target.pcd": POINTS, "near.pcd": NEAR, "far.pcd": FAR, "box.pcd": BOX, "floor.pcd": FLOOR,
                "next_floor.pcd": [(x + 0.03, y + 0.02, z) for x, y, z in FLOOR]}.items():
            self.write(name, pcd(points))
        self.rows = {
            "good": ("near.pcd", "target.pcd"), "doubtful": ("next_floor.pcd", "floor.pcd"),
            "wrong": ("box.pcd", "target.pcd")}

    def pair(self, verdict):
        return [self.path(name) for name in self.rows[verdict]]

    def test_good(self):
        result = self.align(*self.pair("good"), "--strict")
        self.assertEqual((result["verdict"], result["reasons"], result["ending"]), ("good", [], "converged"))
        near = result["quality"]["source_near"]
        self.assertGreater(near["after"], 0.95)
        self.assertLessEqual(near["before"], near["after"])
        self.assertGreater(result["quality"]["target_near"]["after"], 0.95)
        self.assertLess(result["quality"]["surfaces"]["pull"], 0.3)
        self.assertGreater(result["times_ms"]["quality"], 0)
        text = self.succeed("align", *self.pair("good"))
        self.assertTrue(text.startswith("verdict    good\nresult     converged"))
        self.assertRegex(text, r"\nnear       within 0\.\d+, three spacings: \d+ % of the source's points, \d+ % at the")

    def test_doubtful_is_an_answer_but_not_with_strict(self):
        result = self.align(*self.pair("doubtful"))
        self.assertEqual((result["verdict"], result["converged"], result["why"]), ("doubtful", True, None))
        self.assertIn("hardly hold a motion along them", result["reasons"][0])
        text = self.succeed("align", *self.pair("doubtful"), "-o", self.path("moved.pcd"))
        self.assertTrue(text.startswith("verdict    doubtful: " + result["reasons"][0]))
        self.assertTrue(os.path.exists(self.path("moved.pcd")))

        done = self.fail_with(
            NOT_CONVERGED, "align", *self.pair("doubtful"), "--strict", "-o", self.path("strict.pcd"), "--json", "-",
            names=["next_floor.pcd onto", "the pose is doubtful: " + result["reasons"][0], "-o, --both and --matrix not written"])
        strict = self.checked(done.stdout)
        self.assertEqual((strict["ending"], strict["verdict"], strict["converged"]), ("doubtful", "doubtful", False))
        self.assertEqual(strict["transform"], result["transform"])
        self.assertFalse(os.path.exists(self.path("strict.pcd")))

    def test_wrong_is_no_answer(self):
        done = self.fail_with(
            NOT_CONVERGED, "align", *self.pair("wrong"), "-o", self.path("moved.pcd"), "--json", "-",
            names=["box.pcd onto", "the pose is wrong: "])
        result = self.checked(done.stdout)
        self.assertEqual((result["ending"], result["verdict"], result["converged"]), ("wrong", "wrong", False))
        self.assertIn("the pose is wrong: " + result["reasons"][0], result["why"])
        self.assertFalse(os.path.exists(self.path("moved.pcd")))

    def test_a_pose_that_is_found_is_good(self):
        far = self.path("far.pcd"), self.path("target.pcd")
        self.assertEqual(self.align(*far, "--once")["verdict"], "doubtful")
        self.assertEqual(self.align(*far, "--once", "--guess", "auto")["verdict"], "good")

    def test_advice(self):
        """Of what was not tried."""
        box, target = self.pair("wrong")

        def advice(*arguments):
            return self.checked(self.run_command("align", *arguments, "--once", "--json", "-").stdout)["advice"]

        self.assertEqual(advice(*self.pair("good")), [])
        self.assertEqual(advice(*self.pair("good"), "--max-distance", "1e-9"), [])
        spot = self.write("spot.pcd", pcd([(1.0, 2.0, 3.0)] * 50))
        self.assertEqual(advice(spot, spot), [])
        self.assertEqual(advice(*self.pair("good"), "--leaf", "50"), ["a smaller --leaf"])
        search = "without --once other starts are tried"
        self.assertEqual(advice(box, target), [search])
        self.assertNotIn(search, advice(box, target, "--guess", "auto"))
        limited = advice(box, target, "--iterations", "2", "--max-distance", "100")
        self.assertEqual(limited, [search, "--iterations allows more of them: these were the last allowed",
                                   "a smaller --max-distance: 100 leaves out no pair"])
        half = self.write("half.pcd", pcd(NEAR[:len(NEAR) * 2 // 3]))
        self.assertIn("--overlap auto takes clouds that overlap in part", advice(target, half))
        self.assertNotIn("--overlap auto takes clouds that overlap in part", advice(target, half, "--overlap", "auto"))
        text = self.run_command("align", box, target, "--once").stdout
        self.assertRegex(text, r"\Averdict    wrong: [^\n]+\ntry        without --once [^\n]+\nresult     no answer")

    def test_without_pairs_there_is_no_quality(self):
        source, target = self.pair("good")
        done = self.run_command("align", source, target, "--once", "--max-distance", "1e-9", "--json", "-")
        result = self.checked(done.stdout)
        self.assertEqual((result["verdict"], result["quality"], result["ending"]), ("wrong", None, "too few pairs"))
        self.assertEqual(["no answer: " + reason for reason in result["reasons"]], [result["why"]])

    def test_compare_tells_the_verdict(self):
        self.assertIn("\nverdict     of pcl_gpu_icp's: good\n", self.succeed("compare", *self.pair("good")))
        done = self.fail_with(NOT_CONVERGED, "compare", *self.pair("wrong"), names="ours: no answer: ")
        self.assertIn("\nverdict     of pcl_gpu_icp's: wrong: ", done.stdout)

    def test_two_poses_that_fit(self):
        """A bar with square ends, open at none, fits turned by half a turn as well."""
        bar = []
        for i in range(40):
            for j in range(12):
                x, t = 0.1 * i - 1.95, -0.5 + j / 11
                bar += [(x, t, 0.5), (x, t, -0.5), (x, 0.5, t), (x, -0.5, t)]
        source = self.write("bar.pcd", pcd([moved(motion(40, (1, 2, 3)), point) for point in bar]))
        done = self.run_command("align", source, self.write("bar_target.pcd", pcd(bar)), "--guess", "auto", "--json", "-")
        result = self.checked(done.stdout)
        self.assertEqual(result["verdict"], "doubtful")
        self.assertIn("two poses fit", result["reasons"][0])

    def test_batch(self):
        manifest = self.manifest(self.rows.values())
        results, summary = self.batch(manifest, code=NOT_CONVERGED)
        for place, verdict in enumerate(self.rows):
            alone = self.checked(self.run_command("align", *self.pair(verdict), "--json", "-").stdout)
            for key in ("verdict", "reasons", "quality", "ending"):
                self.assertEqual(results[place][key], alone[key])
        self.assertEqual([results[i]["status"] for i in range(3)], ["converged", "converged", "not converged"])
        self.assertEqual(summary["verdicts"], {"good": 1, "doubtful": 1, "wrong": 1})
        self.assertEqual([(each["pair"], each["verdict"], each["reasons"]) for each in summary["worst"]],
                         [(1, "doubtful", results[1]["reasons"])])
        self.assertEqual([each["pair"] for each in summary["unsuccessful"]], [2])

        again = self.run_command("batch", manifest, "-o", self.path("out"), "--resume")
        self.assertEqual(again.returncode, NOT_CONVERGED)
        self.assertIn("\nverdicts   1 good, 1 doubtful, 1 wrong\n", again.stdout)
        self.assertIn("next_floor.pcd onto floor.pcd: doubtful: ", again.stdout)
        for key in ("verdicts", "worst", "unsuccessful"):
            self.assertEqual(self.summary()[key], summary[key])

        _, strict = self.batch(manifest, "--strict", output="strict", code=NOT_CONVERGED)
        self.assertEqual([each["pair"] for each in strict["unsuccessful"]], [1, 2])
        self.assertEqual(strict["worst"], [])

    def test_the_worst_five_are_named(self):
        """By how little of them is on their target."""
        rows = []
        for i in range(7):
            kept = len(FLOOR) - 20 * i
            self.write(f"part_{i}.pcd", pcd(FLOOR[:kept]))
            rows.append(("floor.pcd", f"part_{i}.pcd"))
        results, summary = self.batch(self.manifest(rows))
        self.assertEqual(summary["verdicts"]["doubtful"], 7)
        named = [each["pair"] for each in summary["worst"]]
        self.assertEqual(len(named), 5)
        shares = [results[pair]["quality"]["source_near"]["after"] for pair in named]
        self.assertEqual(shares, sorted(shares))
        self.assertLessEqual(shares[-1], min(
            results[pair]["quality"]["source_near"]["after"] for pair in range(7) if pair not in named))

    def test_a_line_without_a_verdict_is_no_result(self):
        manifest = self.manifest([self.rows["good"]])
        self.batch(manifest)
        path = pathlib.Path(self.path("out"), "results.jsonl")
        path.write_text(path.read_text().replace('"verdict":"good"', '"verdict":"excellent"'))
        self.fail_with(3, "batch", manifest, "-o", self.path("out"), "--resume", names="results.jsonl:1")

    def test_scans_of_one_street_and_of_two_places(self):
        street, next_street, room = (self.shared(f"{name}.pcd")
                                     for name in ("lidar_street_0", "lidar_street_1", "rgbd_room_0"))
        done = self.run_command("align", next_street, street, "--search", "device", "--metric", "plane",
                                "--drop-zero-returns", "--strict", "--json", "-")
        self.assertEqual(self.checked(done.stdout)["verdict"], "good", done)
        done = self.run_command("align", next_street, room, "--search", "device", "--leaf", "0.1", "--json", "-")
        self.assertEqual((done.returncode, self.checked(done.stdout)["verdict"]), (NOT_CONVERGED, "wrong"))
