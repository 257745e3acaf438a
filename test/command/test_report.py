"""--report: one page that shows a result in a browser, whatever it is and whatever files are called."""

import math
import os

from batches import BatchTest
from browser import IS_INSTALLED, close_all, opened
from command import (
    IDENTITY, NOT_CONVERGED, OUTPUT, USAGE, XYZ_DOUBLE, CommandTest, motion, moved, pcd, sampled_surface, surface)

POINTS = surface()
SOURCE = [moved(motion(3, (0.05, -0.08, 0.04)), point) for point in POINTS]
FLOOR = [(0.1 * i, 0.1 * j, 0.0) for i in range(20) for j in range(20)]

tearDownModule = close_all


class ReportTest(CommandTest):
    def setUp(self):
        super().setUp()
        if not IS_INSTALLED:
            self.skipTest("chromium is not installed, or chromium-driver or python3-selenium")
        self.page = self.path("report.html")

    def cloud(self, name, points):
        return self.write(name, pcd(points, "binary"))

    def assert_sound(self, page):
        """Nothing asked for, nothing to complain of, nothing beside the screen."""
        self.assertEqual((page.requests(), page.console(), page.is_too_wide()), ([], [], False))


class Alignment(ReportTest):
    def report(self, source=SOURCE, target=POINTS, *arguments):
        self.succeed(
            "align", self.cloud("source.pcd", source), self.cloud("target.pcd", target), "--report", self.page, "--quiet",
            *arguments)

    def test_before_and_after_from_all_sides(self):
        self.report()
        page = opened(self.page)
        self.assertEqual(page.text(".chip"), "good")
        self.assertEqual(page.text("[data-id=title]"), "source.pcd onto target.pcd")
        after = page.seen()
        self.assertGreater(min(after["source"], after["target"]), 100)
        page.press("b")
        page.wait_for("document.querySelector('.scene').scene.time == 0")
        before = page.seen()
        self.assertNotEqual(before["picture"], after["picture"])
        page.press(" ")
        page.wait_for("document.querySelector('.scene').scene.time == 1")
        self.assertEqual(page.seen()["picture"], after["picture"])
        pictures = {after["picture"]}
        for key in "123":
            page.press(key)
            pictures.add(page.seen()["picture"])
        page.press("r")
        self.assertEqual((len(pictures), page.seen()["picture"]), (4, after["picture"]))
        page.press("d")
        by_distance = page.seen()
        self.assertLess(max(by_distance["source"], by_distance["target"]), 20)
        page.press("d")
        page.click("[data-do=before]")
        page.wait_for("document.querySelector('.scene').scene.time == 0")
        self.assertEqual(page.seen()["picture"], before["picture"])
        self.assert_sound(page)
        for name in ("total", "align", "search"):
            self.assertIn(name, page.text("[data-id=times]"))
        self.assertIn(f"--report {self.page}", page.text("[data-id=command]"))
        self.assertEqual(page.run("return floats(run.pairs[0].errors).length"), page.run("return run.pairs[0].result.iterations"))

    def test_the_numbers_are_those_of_the_files(self):
        offset = (512345.678, 5403210.987, 312.3)
        source, target = ([tuple(a + b for a, b in zip(point, offset)) for point in points] for points in (SOURCE, POINTS))
        names = [self.write(name, pcd(points, "binary", XYZ_DOUBLE)) for name, points in
                 (("source.pcd", source), ("target.pcd", target))]
        result = self.align(*names, "--report", self.page)
        page = opened(self.page)
        found = page.run("""
            const [pair] = run.pairs, list = (block) => Array.from(floats(block));
            return { source: list(pair.source.block), target: list(pair.target.block), centre: pair.centre,
                     poses: pair.poses.map((pose) => ({ matrix: pose.matrix, distances: list(pose.block) })),
                     counts: pair.histogram.counts, result: pair.result };""")
        for key in ("version", "arguments"):  # of the run, which the page tells of elsewhere
            del result[key]
        self.assertEqual(found["result"], result)
        points = lambda numbers: [tuple(numbers[i : i + 3]) for i in range(0, len(numbers), 3)]
        in_file = lambda point: tuple(a + b for a, b in zip(point, found["centre"]))
        for shown, point in zip(points(found["target"]), target):
            self.assertLess(math.dist(in_file(shown), point), 1e-6)
        for pose, counts, matrix in zip(found["poses"], found["counts"], (IDENTITY, result["transform"])):
            self.assertEqual(sum(counts), len(source))
            for shown, distance, point in zip(points(found["source"]), pose["distances"], source):
                place = moved(matrix, point)
                self.assertLess(math.dist(in_file(moved(pose["matrix"], shown)), place), 1e-6)
                self.assertAlmostEqual(distance, min(math.dist(place, other) for other in target), delta=1e-6)

    def test_on_a_phone(self):
        self.report()
        page = opened(self.page, 390)
        self.assertGreater(page.seen()["source"], 100)
        self.assert_sound(page)

    def test_names_are_text(self):
        folder = self.directory / "<script>hacked=1<"
        folder.mkdir()
        names = [folder / "script><!--<script>.pcd", folder / "\"'&amp;\n\\\udcff\u202e.pcd"]
        for name, points in zip(names, (SOURCE, POINTS)):
            name.write_bytes(pcd(points, "binary"))
        self.succeed("align", *names, "--report", self.page, "--quiet")
        page = opened(self.page)
        self.assertEqual(
            page.text("[data-id=title]"), "script><!--<script>.pcd onto \"'&amp;\n\\\ufffd\u202e.pcd")
        self.assertIn("<script>hacked=1</script><!--<script>.pcd", page.text("[data-id=points]"))
        self.assertIsNone(page.run("return window.hacked"))
        self.assertGreater(page.seen()["source"], 100)
        self.assert_sound(page)

    def test_no_answer_undetermined_and_no_webgl(self):
        floor = self.cloud("floor.pcd", FLOOR)
        self.fail_with(
            NOT_CONVERGED, "align", self.cloud("next.pcd", [(x + 0.03, y, z) for x, y, z in FLOOR]), floor, "--metric",
            "plane", "--report", self.page, "--matrix", self.path("matrix.txt"), "--quiet")
        self.assertFalse(os.path.exists(self.path("matrix.txt")))
        page = opened(self.page)
        self.assertIn("no answer", page.text("[data-id=reasons]"))
        self.assertIn("not determined", page.text("[data-id=uncertainty]"))
        self.assertGreater(page.seen()["undetermined"], 100)
        page.press("u")
        self.assertEqual(page.seen()["undetermined"], 0)
        self.assert_sound(page)
        page = opened(self.page, flags=["--disable-3d-apis"])
        self.assertIn("No 3-D view", page.text(".view"))
        self.assertIn("--metric plane", page.text("[data-id=command]"))

    def test_no_pairs(self):
        self.fail_with(
            NOT_CONVERGED, "align", self.cloud("far.pcd", [(x + 5e6, y, z) for x, y, z in POINTS]),
            self.cloud("target.pcd", [*POINTS, (1e17, 0, 0)]), "--max-distance", "1", "--once", "--report", self.page,
            "--quiet")
        page = opened(self.page)
        self.assertEqual(page.text(".chip"), "wrong")
        self.assert_sound(page)

    def test_what_lies_on_the_target_is_seen(self):
        """Whatever a step too short to be taken leaves between them, which differs by processor."""
        for below in (0, 1e-7, 3e-4):
            with self.subTest(below=below):
                self.report([(x, y, z - below) for x, y, z in FLOOR], FLOOR, "--motions", "planar", "--force")
                self.assertGreater(opened(self.page).seen()["source"], 100)

    def test_many_points_are_thinned(self):
        self.report(sampled_surface(120000, 1), sampled_surface(130000, 2), "--iterations", "3", "--search", "device")
        self.assertLess(os.path.getsize(self.page), 8e6)
        page = opened(self.page)
        self.assertIn("100,000 of 120,000 points of the source, drawn at random", page.text("[data-id=shown]"))
        self.assertIn("100,000 of 130,000 points of the target", page.text("[data-id=shown]"))
        self.assertGreater(page.seen()["source"], 100)

    def test_nothing_is_overwritten(self):
        source, target = self.cloud("source.pcd", SOURCE), self.cloud("target.pcd", POINTS)
        for code, arguments in (
                (OUTPUT, ("--report", source)), (USAGE, ("--report", self.page, "--json", self.page))):
            self.fail_with(code, "align", source, target, *arguments, names="--report")
        self.assertEqual(sorted(os.listdir(self.directory)), ["source.pcd", "target.pcd"])

    def test_where_it_started_from(self):
        wall = [(2.5, 0.02 * i - 1, 0.01 * (i * 37 % 100)) for i in range(100)]
        scene = sampled_surface(2000, seed=1) + wall
        about_x = [[1, 0, 0, 0], [0, -0.5, -0.75**0.5, 0], [0, 0.75**0.5, -0.5, 0], [0, 0, 0, 1]]
        self.report(scene, [moved(about_x, point) for point in scene])
        self.assertRegex(opened(self.page).text("[data-id=numbers]"),
                         r"started from the guess \(\w+\), what they have in common \(\w+\), a search \(good, taken\)")

    def test_the_other_pose_that_fits(self):
        axes = range(-10, 11)
        faces = [(x / 10, y / 10, s) for x in axes for y in axes for s in (-1, 1)]
        cube = faces + [(x, s, y) for x, y, s in faces] + [(s, x, y) for x, y, s in faces]
        self.report(cube, cube, "--guess", "auto")
        page = opened(self.page)
        self.assertEqual(page.text(".chip"), "doubtful")
        self.assertIn("two poses fit", page.text("[data-id=reasons]"))
        self.assertEqual(page.text("[data-id=results]"), "afterthe other that fitsboth")
        seen = page.seen()
        self.assertEqual(seen["second"], 0)
        page.click("[data-id=results] button:nth-child(2)")
        other = page.seen()
        self.assertEqual(other["source"], 0)
        self.assertGreater(other["second"], 100)
        self.assert_sound(page)


class Comparison(ReportTest):
    def test_both_results(self):
        self.succeed(
            "compare", self.cloud("source.pcd", SOURCE), self.cloud("target.pcd", POINTS), "--report", self.page, "--quiet")
        page = opened(self.page)
        self.assertIn("The transforms differ by", page.text("[data-id=comparison-note]"))
        both = page.seen()
        page.press("b")
        page.wait_for("document.querySelector('.scene').scene.time == 0")
        self.assertGreater(page.seen()["target"], 100)
        page.press("a")
        page.wait_for("document.querySelector('.scene').scene.time == 1")
        for choice, colour, other in ((1, "source", "second"), (2, "second", "source")):
            page.click(f"[data-id=results] button:nth-child({choice})")
            alone = page.seen()
            self.assertEqual(alone[other], 0)
            self.assertGreater(alone[colour], 100)
            self.assertNotEqual(alone["picture"], both["picture"])
        self.assert_sound(page)

    def test_without_an_answer_of_stock(self):
        done = self.run_command(
            "compare", self.cloud("source.pcd", SOURCE), self.cloud("target.pcd", POINTS), "--stock-limit", "0.000001",
            "--report", self.page, "--quiet")
        self.assertEqual(done.returncode, NOT_CONVERGED, done)
        page = opened(self.page)
        self.assertIn("Stock PCL has no answer: ", page.text("[data-id=comparison-note]"))
        self.assertGreater(page.seen()["source"], 100)
        self.assert_sound(page)


class Batch(ReportTest, BatchTest):
    def column(self, page, number):
        return page.run(f"""return [...document.querySelectorAll('.pairs tbody td:nth-child({number})')]
                                .map((cell) => cell.textContent)""")

    def test_the_worst_first_and_each_pair(self):
        box = [tuple(face if i == axis else (a, b)[i - (i > axis)] for i in range(3))
               for axis in range(3) for face in (-6, 6) for a in range(-6, 7, 2) for b in range(-6, 7, 2)]
        self.cloud("box.pcd", box)
        rows = self.pairs(12) + [("box.pcd", "scan_0.pcd"), ("<img src=x onerror=hacked=1>.pcd", "scan_0.pcd")]
        self.batch(self.manifest(rows), "--once", "--report", self.page, "--quiet", code=NOT_CONVERGED)
        self.assertLess(os.path.getsize(self.page), 8e6)
        page = opened(self.page)
        self.assertEqual(self.column(page, 2)[:2], ["13", "12"])
        self.assertEqual(self.column(page, 3)[:3], ["failed", "wrong", "good"])
        self.assertEqual(self.column(page, 4)[0], rows[13][0])
        self.assertIsNone(page.run("return window.hacked"))
        page.click(".pairs thead th:nth-child(2)")
        self.assertEqual(self.column(page, 2), [str(i) for i in range(10)])
        page.click(".pairs thead th:nth-child(2)")
        self.assertEqual(self.column(page, 2), [str(i) for i in range(13, 3, -1)])
        page.run("$('.pairs').DataTable().search('wrong').draw()")
        self.assertEqual(self.column(page, 2), ["12"])
        page.run("$('.pairs').DataTable().search('').draw()")
        for pair in (5, 4, 12, 7, 5):  # one view after the other, in the place of the one before
            page.run(f"document.querySelector('.pairs tr[data-pair=\"{pair}\"]').click()")
            self.assertEqual(
                page.text("article [data-id=title]"), f"{rows[pair][0]} onto {rows[pair][1]}")
            self.assertGreater(page.seen()["source"], 20)
        page.run("document.querySelector('.pairs tr[data-pair=\"13\"]').click()")
        self.assertIn("No such file", page.text("[data-id=chosen]"))
        self.assert_sound(page)
        page = opened(self.page, 390)
        self.assert_sound(page)

    def test_trajectory_resume_and_many_pairs(self):
        self.scans(4)
        pattern = self.path("scan_*.pcd")
        self.batch("--sequence", pattern, "--quiet")
        for arguments, shown in (("--resume",), 0), (("--force",), 3):
            self.batch("--sequence", pattern, "--report", self.page, "--quiet", *arguments)
            page = opened(self.page)
            self.assertEqual(page.run("return run.trajectory.length"), 4)
            self.assertIn("4 of 4 scans", page.text("[data-id=trajectory-note]"))
            self.assertIn(f"{shown} of 3 pairs have their clouds here", page.text("[data-id=pairs-note]"))
            self.assert_sound(page)

    def test_nothing_of_a_batch_is_overwritten(self):
        manifest = self.manifest(self.pairs(1))
        self.fail_with(OUTPUT, "batch", manifest, "-o", self.path("out"), "--report", manifest, names="--report")
        self.fail_with(
            USAGE, "batch", manifest, "-o", self.path("out"), "--report", self.path("out/summary.json"),
            names="--report")
