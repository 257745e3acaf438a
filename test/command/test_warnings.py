"""What of the files may not be as meant: a line on standard error and a member of the JSON."""

from command import CommandTest, SCHEMA, XYZ_DOUBLE, motion, moved, pcd, surface

POINTS = surface()
MOTION = motion(3, (0.05, -0.08, 0.04))
TARGET = [moved(MOTION, point) for point in POINTS]


class Warnings(CommandTest):
    def warned(self, source, target, *arguments):
        """The warnings of an alignment of two contents, the same in both places."""
        files = self.write("source.pcd", source), self.write("target.pcd", target)
        done = self.run_command("align", *files, *arguments, "--json", "-")
        warnings = self.checked(done.stdout)["warnings"]
        lines = [line for line in done.stderr.splitlines() if ": warning: " in line]
        self.assertEqual(lines, [f"pcl_gpu_icp: warning: {warning}" for warning in warnings])
        compared = self.run_command("compare", *files, *arguments, "--quiet")
        self.assertNotIn("warning", compared.stderr)
        return warnings

    def test_none(self):
        self.assertEqual(self.warned(pcd(POINTS), pcd(TARGET)), [])

    def test_many_points_at_zero(self):
        zeros = pcd(POINTS + [(0.0, 0.0, 0.0)] * 40)
        [line] = self.warned(zeros, pcd(TARGET))
        self.assertIn("source.pcd: 41 of 520 points are at exactly (0, 0, 0)", line)
        self.assertIn("left out; --drop-zero-returns=false keeps them", line)
        for told in ("--drop-zero-returns", "--drop-zero-returns=false"):
            self.assertEqual(self.warned(zeros, pcd(TARGET), told), [])
        self.assertEqual(self.warned(pcd(POINTS + [(0.0, 0.0, 0.0)] * 2), pcd(TARGET)), [])
        self.assertEqual(len(self.warned(zeros, zeros)), 2)

    def test_float_coordinates_far_from_the_origin(self):
        far = lambda points: [(x + 512345.5, y + 5403210.5, z) for x, y, z in points]
        lines = self.warned(pcd(far(POINTS), "binary"), pcd(far(TARGET), "binary"))
        self.assertEqual(len(lines), 2)
        for line, name in zip(lines, ("source.pcd", "target.pcd")):
            self.assertIn(name + ": its float coordinates near 5.403e+06 are 0.5 apart", line)
        double = [pcd(far(points), "binary", XYZ_DOUBLE) for points in (POINTS, TARGET)]
        self.assertEqual(self.warned(*double), [])
        near = lambda points: [(x + 1000, y + 1000, z) for x, y, z in points]
        self.assertEqual(self.warned(pcd(near(POINTS), "binary"), pcd(near(TARGET), "binary")), [])
        stray = POINTS + [(1e7, 1e7, 1e7)]
        self.assertEqual(self.warned(pcd(stray), pcd(TARGET)), [])

    def test_other_units(self):
        millimetres = pcd([tuple(1000 * v for v in p) for p in POINTS])
        [line] = self.warned(millimetres, pcd(TARGET))
        self.assertRegex(line, r"source\.pcd spans \S+ and \S+target\.pcd \S+: are they in the same unit\?")
        self.assertEqual(len(self.warned(pcd(POINTS), millimetres)), 1)
        self.assertEqual(self.warned(pcd([tuple(20 * v for v in p) for p in POINTS]), pcd(TARGET)), [])

    def test_guess_of_few_digits(self):
        clouds = pcd(POINTS), pcd(TARGET)
        three = "0.990 -0.139 0.012 0 0.139 0.986 -0.086 0 0.000 0.087 0.996 0"
        [line] = self.warned(*clouds, "--guess=" + three)
        self.assertRegex(line, r"^--guess: written with few digits; the nearest rotation is taken, .* up to 0.000\d$")
        file = self.write("guess.txt", three)
        self.assertIn(f"--guess {file}: written with few digits", self.warned(*clouds, "--guess", file)[0])
        self.assertEqual(self.warned(*clouds, "--guess=0 0 0 0 0 0.6 0.8"), [])

    def test_batch(self):
        zeros = self.write("zeros.pcd", pcd(POINTS + [(0.0, 0.0, 0.0)] * 40))
        good, target = self.write("good.pcd", pcd(POINTS)), self.write("target.pcd", pcd(TARGET))
        manifest = self.write("pairs.csv", f"source,target\n{zeros},{target}\n{good},{target}\n{target},{zeros}\n")
        done = self.run_command("batch", manifest, "-o", self.path("out"))
        self.assertIn("pcl_gpu_icp: warning: 2 of 3 pairs have warnings; see ", done.stderr)
        lines = (self.directory / "out" / "results.jsonl").read_text().splitlines()
        results = [self.checked(line, SCHEMA.with_name("batch.schema.json")) for line in lines]
        self.assertEqual([len(r["warnings"]) for r in sorted(results, key=lambda r: r["pair"])], [1, 0, 1])
        quiet = self.run_command("batch", manifest, "-o", self.path("quiet"), "--quiet")
        self.assertEqual(quiet.stderr, "")
