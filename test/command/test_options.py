"""Each option of align does what its help says."""

import json
import math
import os
import pathlib

from command import (
    INPUT, NOT_CONVERGED, USAGE, XYZ_DOUBLE, CommandTest, motion, moved, numbers, pcd, read_pcd, sampled_surface, surface)

POINTS = surface()
MOTION = motion(3, (0.05, -0.08, 0.04))
TARGET = [moved(MOTION, point) for point in POINTS]
OVERLAP = 200  # the halves of the surface share this many points


class Options(CommandTest):
    def setUp(self):
        super().setUp()
        self.source = self.write("source.pcd", pcd(POINTS))
        self.target = self.write("target.pcd", pcd(TARGET))
        middle = (len(POINTS) + OVERLAP) // 2
        self.half_source = self.write("half_source.pcd", pcd(POINTS[:middle]))
        self.half_target = self.write("half_target.pcd", pcd(TARGET[-middle:]))

    def test_guess(self):
        turn = motion(120, (5, -4, 3))
        turned_target = self.write("turned.pcd", pcd([moved(turn, point) for point in POINTS]))
        lost = self.align(self.source, turned_target, "--once")
        self.assertGreater(lost["rmse"], 0.01)
        guess = motion(119, (5.02, -4.02, 3.01))
        as_file = self.write("guess.txt", "\n".join(" ".join(numbers([row])) for row in guess))
        console = self.write("console.txt", "".join(f"[14:09:{29 + i}] " + " ".join(numbers([row])) + "\n"
                                                    for i, row in enumerate(guess)))  # CloudCompare's
        for arguments in (
            ["--guess", *numbers(guess)],
            ["--guess", as_file],
            ["--guess", console],
            ["--guess", ",".join(numbers(guess))],
            ["--guess=" + " ".join(numbers(guess))],
        ):
            found = self.align(self.source, turned_target, *arguments)
            self.assertLess(found["rmse_before"], 0.2)
            self.assert_maps(found["transform"], POINTS, [moved(turn, point) for point in POINTS], 1e-4)
        first = self.succeed("align", "--guess", *numbers(guess), self.source, turned_target, "--json", "-")
        self.assertEqual(self.checked(first)["transform"], found["transform"])

    def test_guess_with_few_digits_gives_a_rotation(self):
        rounded = [[round(value, 4) for value in row] for row in MOTION]
        done = self.run_command(
            "align", self.source, self.target, "--guess", *numbers(rounded), "--iterations", "1", "--json", "-")
        self.assertIn("warning: --guess: written with few digits", done.stderr)
        rows = self.checked(done.stdout)["transform"]
        for i in range(3):
            for j in range(3):
                dot = sum(rows[i][k] * rows[j][k] for k in range(3))
                self.assertAlmostEqual(dot, i == j, delta=1e-6)

    def test_max_distance(self):
        result = self.align(self.half_source, self.half_target, "--max-distance", "0.2")
        self.assertLess(result["inliers"], (len(POINTS) + OVERLAP) // 2)
        self.assert_maps(result["transform"], POINTS, TARGET, 1e-3)

    def test_iterations(self):
        result = self.align(self.source, self.target, "--iterations", "2")
        self.assertEqual((result["iterations"], result["reason"], result["converged"]), (2, "iterations", True))
        self.assertIn("limit of 2 iterations", self.succeed("align", self.source, self.target, "--iterations", "2"))

    def test_translation_and_rotation_epsilon(self):
        loose = self.align(self.source, self.target, "--translation-epsilon", "1")
        self.assertEqual((loose["reason"], loose["iterations"]), ("transform", 1))
        # The first iterations turn by more than a thousandth of a degree.
        strict = self.align(self.source, self.target, "--translation-epsilon", "1", "--rotation-epsilon", "0.001")
        self.assertEqual(strict["reason"], "transform")
        self.assertGreater(strict["iterations"], 1)
        wide = self.align(self.source, self.target, "--translation-epsilon", "1", "--rotation-epsilon", "45")
        self.assertEqual(wide["iterations"], 1)
        fine = self.align(self.source, self.target, "--translation-epsilon", "0.001")
        self.assertGreater(fine["iterations"], 1)

    def test_fitness_epsilon(self):
        result = self.align(self.half_source, self.half_target, "--fitness-epsilon", "0.9")
        self.assertEqual(result["reason"], "relative mse")

    def test_leaf(self):
        output = self.path("out.pcd")
        result = self.align(self.source, self.target, "--leaf", "0.6", "-o", output)
        dropped = result["points"]["dropped"]
        self.assertGreater(dropped["source"]["downsampled"], 100)
        self.assertEqual(result["points"]["source"] + dropped["source"]["downsampled"], len(POINTS))
        self.assertEqual(result["points"]["target"] + dropped["target"]["downsampled"], len(TARGET))
        self.assertEqual(len(read_pcd(output)[1]), len(POINTS))
        # A grid finer than the points keeps them all.
        self.assertEqual(self.align(self.source, self.target, "--leaf", "0.01")["points"]["source"], len(POINTS))

    def test_leaf_takes_the_centroid_of_each_voxel(self):
        cloud = self.write("c.pcd", pcd([(0.1, 0.1, 0.1), (0.3, 0.1, 0.1), (-0.1, 0.1, 0.1), (5.0, 5.0, 5.0)]))
        centroids = self.write("d.pcd", pcd([(0.2, 0.1, 0.1), (-0.1, 0.1, 0.1), (5.0, 5.0, 5.0)]))
        result = self.align(cloud, centroids, "--leaf", "1")
        self.assertEqual(result["points"]["source"], 3)
        self.assertLess(result["rmse_before"], 1e-6)

    def test_leaf_has_no_limit_on_the_voxels_of_the_box(self):
        apart = POINTS + [(1e7, 1e7, 1e7)]
        cloud = self.write("apart.pcd", pcd(apart))
        self.assertLess(self.align(cloud, cloud, "--leaf", "0.6")["points"]["source"], len(POINTS))

    def test_metric(self):
        hills = sampled_surface(1500, seed=2)
        source = self.write("hills.pcd", pcd(hills))
        target = self.write("moved_hills.pcd", pcd([moved(MOTION, point) for point in sampled_surface(3000, seed=1)]))
        ends = ["--translation-epsilon", "1e-4", "--rotation-epsilon", "0.01"]
        by_points = self.align(source, target, *ends)
        self.assertEqual((by_points["metric"], by_points["free_motions"]), ("point", 0))
        for more in ([], ["--search", "device"], ["--pipeline", "staged"], ["--trim", "0.999"], ["--anderson"]):
            with self.subTest(more):
                by_planes = self.align(source, target, *ends, "--metric", "plane", *more)
                self.assertEqual((by_planes["metric"], by_planes["degenerate"]), ("plane", "none"))
                self.assertLess(by_planes["iterations"], by_points["iterations"] / 2)
                self.assert_maps(by_planes["transform"], hills, [moved(MOTION, point) for point in hills], 0.01)
        self.assertIn("normals", self.align(source, target, "--metric", "plane")["times_ms"])
        self.assertIn("\nmetric     plane\n", self.succeed("align", source, target, "--metric", "plane"))
        self.fail_with(USAGE, "align", source, target, "--metric", "line", names=["--metric", "gicp|plane|point|symmetric"])

    def test_metric_gicp(self):
        hills = sampled_surface(1500, seed=2)
        source = self.write("hills.pcd", pcd(hills))
        target = self.write("moved_hills.pcd", pcd([moved(MOTION, point) for point in sampled_surface(3000, seed=1)]))
        ends = ["--translation-epsilon", "1e-4", "--rotation-epsilon", "0.01"]
        by_points = self.align(source, target, *ends)
        for more in ([], ["--search", "device"], ["--pipeline", "staged"], ["--trim", "0.999"], ["--anderson"],
                     ["--reciprocal"]):
            with self.subTest(more):
                by_surfaces = self.align(source, target, *ends, "--metric", "gicp", *more)
                self.assertEqual((by_surfaces["metric"], by_surfaces["degenerate"]), ("gicp", "none"))
                self.assertLess(by_surfaces["iterations"], by_points["iterations"] / 2)
                self.assert_maps(by_surfaces["transform"], hills, [moved(MOTION, point) for point in hills], 0.01)
        self.assertIn("normals", self.align(source, target, "--metric", "gicp")["times_ms"])
        self.assertIn("\nmetric     gicp\n", self.succeed("align", source, target, "--metric", "gicp"))

    def test_preset(self):
        hills = sampled_surface(800, seed=2)
        source = self.write("hills.pcd", pcd(hills))
        target = self.write("moved_hills.pcd", pcd([moved(MOTION, point) for point in sampled_surface(1500, seed=1)]))
        for preset, metric in (("lidar", "plane"), ("rgbd", "gicp"), ("object", "gicp")):
            with self.subTest(preset):
                by_preset = self.align(source, target, "--preset", preset)
                self.assertEqual((by_preset["metric"], by_preset["loss"]["function"]), (metric, "huber"))
                self.assertEqual(self.align(source, target, "--metric", metric, "--loss", "huber")["transform"],
                                 by_preset["transform"])
        for arguments in (["--preset", "object", "--metric", "point", "--loss", "cauchy:0.2"],
                          ["--metric", "point", "--loss", "cauchy:0.2", "--preset", "object"]):
            given = self.align(source, target, *arguments)
            self.assertEqual((given["metric"], given["loss"]["function"]), ("point", "cauchy"))
        self.fail_with(USAGE, "align", source, target, "--preset", "lydar",
                       names=["--preset", "lidar|rgbd|object", "did you mean lidar"])

    def test_loss(self):
        hills = sampled_surface(1500, seed=2)
        clutter = [(x, y, z + 0.5) for x, y, z in hills[:300]]
        source = self.write("hills.pcd", pcd(hills + clutter))
        target = self.write("moved_hills.pcd", pcd([moved(MOTION, point) for point in sampled_surface(3000, seed=1)]))
        plain = self.align(source, target, "--metric", "plane", "--once")
        self.assertIsNone(plain["loss"])
        off = self.farthest(plain["transform"], hills)
        for given, scale in (("cauchy:0.03", 0.03), ("tukey", None), ("geman-mcclure:5e-2", 0.05), ("welsch", None)):
            with self.subTest(given):
                robust = self.align(source, target, "--metric", "plane", "--loss", given)
                self.assertLess(self.farthest(robust["transform"], hills), off / 2)
                self.assertEqual(robust["loss"]["function"], given.partition(":")[0])
                self.assertEqual(robust["loss"]["given"], scale is not None)
                self.assertGreater(robust["loss"]["scale"], 0)
                if scale:
                    self.assertEqual(robust["loss"]["scale"], scale)
        text = self.succeed("align", source, target, "--metric", "plane", "--loss", "cauchy:0.03")
        self.assertIn("\nmetric     plane, loss cauchy:0.03\n", text)
        text = self.succeed("align", source, target, "--loss", "huber")
        self.assertRegex(text, r"\nmetric     point, loss huber:[0-9.]+ \(from the residuals\)\n")
        self.assertIsNone(self.align(source, target, "--loss", "none", "--once")["loss"])
        for wrong, name in (("l1", "none|huber|cauchy|geman-mcclure|tukey|welsch"), ("huber:", "1e-18 to 1e18"),
                            ("huber:0", "1e-18 to 1e18"), ("huber:nan", "1e-18 to 1e18"), ("none:1", "none:1")):
            self.fail_with(USAGE, "align", source, target, "--loss", wrong, names=["--loss", name])
        self.fail_with(USAGE, "compare", source, target, "--loss", "huber", names="--loss")

    def test_guess_auto(self):
        scene = sampled_surface(2000, seed=1) + [(2.5, 0.02 * i - 1, 0.01 * (i * 37 % 100)) for i in range(100)]
        away = motion(140, (3, -2, 1))
        source = self.write("scene.pcd", pcd(scene))
        target = self.write("moved_scene.pcd", pcd([moved(away, point) for point in scene]))
        from_there = self.checked(self.run_command("align", source, target, "--once", "--json", "-").stdout)
        self.assertGreater(self.farthest(from_there["transform"], scene, away), 0.5)
        self.assertNotEqual(from_there["verdict"], "good")
        self.assertIsNone(from_there["searched_guess"])
        found = self.align(source, target, "--guess", "auto", "--strict")
        self.assertLess(self.farthest(found["transform"], scene, away), 1e-3)
        self.assertGreater(found["searched_guess"]["starts"], 1)
        self.assertGreater(found["searched_guess"]["score"], 0.5)
        self.assertIn("guess", found["times_ms"])
        self.assertIsNone(self.align(source, source)["searched_guess"])
        text = self.succeed("align", source, target, "--guess", "auto")
        self.assertRegex(text, r"\nguess      of \d+ starts anywhere the best has score [\d.]+ of 1")
        headings = self.align(source, source, "--guess", "auto", "--motions", "yaw")
        self.assertLess(headings["searched_guess"]["starts"], 100)
        # A file may have that name all the same.
        given = self.align(source, target, "--guess", self.write("auto", " ".join(numbers(away))))
        self.assertLess(self.farthest(given["transform"], scene, away), 1e-3)

    def test_overlap_auto(self):
        hills = sampled_surface(3000, seed=1)
        source = self.write("left.pcd", pcd([point for point in hills if point[0] < 0.4]))
        right = [moved(MOTION, point) for point in sampled_surface(3000, seed=2) if point[0] > -1]
        target = self.write("right.pcd", pcd(right))
        plain = self.checked(self.run_command("align", source, target, "--metric", "plane", "--once", "--json", "-").stdout)
        self.assertIsNone(plain["overlap"])
        found = self.align(source, target, "--metric", "plane", "--overlap", "auto")
        self.assertLess(self.farthest(found["transform"], hills), 0.1)
        self.assertLess(self.farthest(found["transform"], hills), 0.5 * self.farthest(plain["transform"], hills))
        self.assertAlmostEqual(found["overlap"]["share"], sum(-1 < p[0] < 0.4 for p in hills) /
                               sum(p[0] < 0.4 for p in hills), delta=0.15)
        self.assertEqual(found["loss"]["function"], "geman-mcclure")
        self.assertGreater(found["times_ms"]["overlap"], 0)
        given = self.align(source, target, "--metric", "plane", "--overlap", "auto", "--loss", "cauchy:0.05")
        self.assertEqual(given["loss"]["function"], "cauchy")
        text = self.succeed("align", source, target, "--overlap", "auto")
        self.assertRegex(text, r"\noverlap    \d+ % of the source, by the best of (1 way|[2-6] ways) from coarse to fine\n")
        manifest = self.write("pairs.csv", "source,target,overlap,metric\nleft.pcd,right.pcd,auto,plane\n")
        self.succeed("batch", manifest, "-o", self.path("out"))
        line = json.loads(pathlib.Path(self.path("out"), "results.jsonl").read_text())
        for key in ("transform", "overlap", "loss", "verdict"):
            self.assertEqual(line[key], found[key])
        self.fail_with(USAGE, "align", source, target, "--overlap", "0.5", names=["--overlap", "0.5"])
        self.fail_with(USAGE, "compare", source, target, "--overlap", "auto", names="--overlap")
        few = self.write("few.pcd", pcd(hills[:5]))
        self.fail_with(INPUT, "align", few, target, "--overlap", "auto", names=["few.pcd onto", "--overlap auto"])

    def test_guess_auto_of_what_is_symmetric(self):
        axes = range(-10, 11)
        faces = [(x / 10, y / 10, s) for x in axes for y in axes for s in (-1, 1)]
        cube = faces + [(x, s, y) for x, y, s in faces] + [(s, x, y) for x, y, s in faces]
        far = (437000, 5412000, 100)  # where float32 has no digits left
        cube = [tuple(a + b for a, b in zip(point, far)) for point in cube]
        source = self.write("cube.pcd", pcd(cube, fields=XYZ_DOUBLE))
        done = self.run_command("align", source, source, "--guess", "auto", "--json", "-")
        result = self.checked(done.stdout)

        def of_the_grid(point):
            return tuple(round(10 * value) for value in point)

        by_rival = {of_the_grid(moved(result["searched_guess"]["rival"]["transform"], point)) for point in cube}
        self.assertEqual(by_rival, set(map(of_the_grid, cube)))
        self.assertEqual(result["verdict"], "doubtful")
        self.assertRegex(result["reasons"][0], r"^two poses fit: another, \d+ degrees and \S+ from this one, has 100 %")
        self.assertEqual(result["searched_guess"]["rival"]["near"], 1)
        self.assertNotEqual(result["searched_guess"]["rival"]["transform"], result["transform"])
        self.assertIn("--guess with a rough pose, where one is known, decides between them", result["advice"])

    def test_guess_auto_takes_points(self):
        few = self.write("few.pcd", pcd([(1, 2, 3)] * 50))
        self.fail_with(INPUT, "align", few, self.target, "--guess", "auto", names=["few.pcd", "--guess auto"])
        # The shell of a box in which there is room for all of the hills.
        grid = range(-6, 7, 2)
        shell = [p for i in grid for j in grid for f in (-6, 6) for p in ((f, i, j), (i, f, j), (i, j, f))]
        hills = self.write("hills.pcd", pcd(sampled_surface(600, seed=5)))
        arguments = ["align", self.write("shell.pcd", pcd(shell)), hills, "--guess", "auto"]
        self.fail_with(NOT_CONVERGED, *arguments, names="the pose is wrong")
        self.fail_with(USAGE, "compare", few, self.target, "--guess", "auto", names="--guess auto")

    def farthest(self, transform, points, onto=MOTION):
        return max(math.dist(moved(transform, point), moved(onto, point)) for point in points)

    def test_motions(self):
        hills = sampled_surface(1500, seed=2)
        turn = [[math.cos(0.05), -math.sin(0.05), 0, 0.05], [math.sin(0.05), math.cos(0.05), 0, -0.03], [0, 0, 1, 0],
                [0, 0, 0, 1]]
        source = self.write("hills.pcd", pcd(hills))
        target = self.write("moved_hills.pcd", pcd([moved(turn, point) for point in sampled_surface(3000, seed=1)]))
        guess = "1 0 0 0 0 1 0 0 0 0 1 0.01"
        for metric in ("point", "plane", "symmetric", "gicp"):
            for motions in ("planar", "yaw", "translation"):
                with self.subTest(metric=metric, motions=motions):
                    found = self.align(source, target, "--metric", metric, "--motions", motions, "--guess", guess)
                    transform = found["transform"]
                    self.assertEqual(found["motions"], motions)
                    self.assertEqual(transform[2][:3], [0, 0, 1])
                    if motions == "planar":
                        self.assertAlmostEqual(transform[2][3], 0.01, 15)
                    if motions == "translation":
                        self.assertEqual(transform[0][:3] + transform[1][:3], [1, 0, 0, 0, 1, 0])
                    else:
                        self.assertAlmostEqual(transform[1][0], math.sin(0.05), 2)
        self.assertIn("\nmetric     point, motions yaw\n", self.succeed("align", source, target, "--motions", "yaw"))
        self.fail_with(USAGE, "align", source, target, "--motions", "flat", names=["--motions", "planar|rigid"])
        self.fail_with(USAGE, "compare", source, target, "--motions", "yaw", names="--motions")

    def test_metric_plane_on_a_floor(self):
        floor = [(x, y, 0) for x, y, _ in POINTS]
        source = self.write("floor.pcd", pcd([(x, y, 0.1) for x, y, _ in floor]))
        target = self.write("floor_below.pcd", pcd(floor))
        arguments = ["align", source, target, "--metric", "plane"]
        done = self.fail_with(NOT_CONVERGED, *arguments, "--json", "-", names="of the six motions 3")
        result = self.checked(done.stdout)
        self.assertEqual((result["degenerate"], result["free_motions"]), ("sliding", 3))
        self.assert_maps(result["transform"], [(0, 0, 0.1)], [(0, 0, 0)], 1e-6)
        self.assertIn("degenerate yes: of the six motions 3", self.run_command(*arguments).stdout)

    def test_degenerate(self):
        floor = [(x, y, 0) for x, y, _ in POINTS]
        source = self.write("floor.pcd", pcd([(x, y, 0.1) for x, y, _ in floor]))
        target = self.write("floor_below.pcd", pcd(floor))
        arguments = [source, target, "--metric", "plane", "--guess", "1 0 0 0.25 0 1 0 -0.125 0 0 1 0"]
        self.fail_with(NOT_CONVERGED, "align", *arguments, "--degenerate", "fail", names="3 only slide")
        for choice in ("solve", "keep"):
            with self.subTest(choice):
                found = self.align(*arguments, "--degenerate", choice)
                self.assertEqual((found["degenerate"], found["converged"]), ("sliding", True))
                self.assert_maps(found["transform"], [(0, 0, 0.1)], [(0.25, -0.125, 0)], 1e-5)
        self.assertIn("degenerate yes", self.succeed("align", *arguments, "--degenerate", "keep"))
        self.fail_with(USAGE, "align", *arguments, "--degenerate", "drop", names=["--degenerate", "fail|keep|solve"])
        self.fail_with(USAGE, "compare", source, target, "--degenerate", "keep", names="--degenerate keep")

    def test_anderson(self):
        ends = ["--translation-epsilon", "1e-6", "--rotation-epsilon", "1e-5", "--iterations", "1000"]
        plain = self.align(self.half_source, self.half_target, *ends, "--once")
        accelerated = self.align(self.half_source, self.half_target, *ends, "--once", "--anderson")
        self.assertEqual(accelerated["reason"], "transform")
        self.assertLess(accelerated["iterations"], plain["iterations"])
        self.assertLess(accelerated["rmse"], 1.01 * plain["rmse"])
        self.assertIn("pcl_gpu_icp", self.succeed("compare", self.source, self.target, "--anderson"))

    def test_reciprocal(self):
        plain = self.align(self.half_source, self.half_target, "--iterations", "1")
        mutual = self.align(self.half_source, self.half_target, "--iterations", "1", "--reciprocal")
        self.assertLess(mutual["inliers"], plain["inliers"])
        self.assertGreater(mutual["inliers"], 0)

    def test_trim(self):
        result = self.align(self.source, self.target, "--iterations", "1", "--trim", "0.25")
        self.assertEqual(result["inliers"], len(POINTS) // 4)

    def test_drop_zero_returns(self):
        zeros = [(0.0, 0.0, 0.0)] * 400
        source = self.write("s.pcd", pcd(POINTS + zeros))
        target = self.write("t.pcd", pcd(TARGET + zeros))
        output = self.path("out.pcd")
        for dropping in ([], ["--drop-zero-returns"]):  # so many are no measurements
            result = self.align(source, target, "--quiet", *dropping, "-o", output, "--force")
            self.assertEqual(result["points"]["dropped"]["source"]["zero_returns"], len(zeros) + POINTS.count(zeros[0]))
            self.assert_maps(result["transform"], POINTS, TARGET, 1e-3)
            points = read_pcd(output)[1]
            self.assertEqual(points[len(POINTS) :], zeros)
        biased = self.align(source, target, "--quiet", "--once", "--drop-zero-returns=false")
        self.assertEqual(biased["points"]["dropped"]["source"]["zero_returns"], 0)
        self.assertGreater(abs(biased["transform"][0][3] - MOTION[0][3]), 1e-3)

    def test_search_and_pipeline(self):
        for search in ("pcl", "device"):
            for pipeline, step in (("staged", "device_svd"), ("fused", "device_match_solve")):
                with self.subTest(search=search, pipeline=pipeline):
                    result = self.align(self.source, self.target, "--pipeline", pipeline, "--search", search)
                    self.assertEqual((result["pipeline"], result["search"]), (pipeline, search))
                    self.assert_maps(result["transform"], POINTS, TARGET, 1e-4)
                    self.assertIn(step, result["times_ms"])
                    self.assertEqual(len(result["searched"]), result["iterations"])
                    self.assertEqual(result["searched"][0], len(POINTS))
        compared = self.succeed("compare", self.source, self.target, "--search", "device")
        self.assertIn("pcl_gpu_icp", compared)

    def test_device(self):
        named = self.align(self.source, self.target, "--device", "0:0")
        self.assertEqual(
            self.align(self.source, self.target, "--device", named["device"]["name"])["device"], named["device"])

    def test_threads(self):
        self.assertIn(" 1 threads", self.succeed("align", self.source, self.target, "--threads", "1"))
        self.assertIn(" 3 threads", self.succeed("align", self.source, self.target, "--threads", "3"))

    def test_quiet(self):
        matrix = self.path("matrix.txt")
        self.assertEqual(self.succeed("align", self.source, self.target, "--quiet", "--matrix", matrix), "")
        self.assertGreater(os.path.getsize(matrix), 0)
        self.checked(self.succeed("align", self.source, self.target, "--quiet", "--json", "-"))
        self.assertEqual(self.succeed("compare", self.source, self.target, "--quiet"), "")
