"""Manifests in, results and a summary out."""

import json
import os
import pathlib
import shutil

from batches import POINTS, BatchTest, csv_text, json_lines
from command import COMMAND, DEVICE, INPUT, NOT_CONVERGED, OUTPUT, USAGE, motion, moved, numbers, pcd, surface

TURN = motion(120, (5, -4, 3))
GUESS = motion(119, (5.02, -4.02, 3.01))


class Manifests(BatchTest):
    def test_every_pair_gets_what_align_gives_it(self):
        rows = self.pairs(3)
        for arguments in ([], ["--search", "device"], ["--leaf", "0.6", "--iterations", "4"],
                          ["--metric", "plane"], ["--metric", "plane", "--search", "device"], ["--metric", "gicp"],
                          ["--metric", "gicp", "--search", "device"], ["--metric", "symmetric"], ["--preset", "object"],
                          ["--reciprocal"]):
            with self.subTest(arguments):
                results, summary = self.batch(self.manifest(rows), *arguments, "--force")
                self.assertEqual(self.transforms(results), self.aligned_alone(rows, *arguments))
                self.assertEqual((summary["pairs"], summary["converged"] + summary["at_the_limit"], summary["complete"]),
                                 (3, 3, True))
        self.assertEqual(summary["version"], os.environ["PCL_GPU_ICP_VERSION"])
        self.assertEqual(summary["arguments"], [COMMAND, "batch", self.path("manifest.csv"), "--reciprocal", "--force",
                                                "-o", self.path("out")])
        alone = self.align(self.path("scan_1.pcd"), self.path("scan_0.pcd"), "--reciprocal")
        for key in alone.keys() - {"version", "arguments", "source", "target", "threads", "device_bytes", "times_ms"}:
            self.assertEqual(results[0][key], alone[key], key)

    def test_csv_and_json_lines_are_the_same(self):
        rows = self.pairs(3)
        from_csv, _ = self.batch(self.manifest(rows), output="csv")
        objects = [{"source": source, "target": target, "guess": None} for source, target in rows]
        from_json, _ = self.batch(self.write("m.jsonl", "\n" + json_lines(objects)), output="json")
        self.assertEqual(self.transforms(from_csv), self.transforms(from_json))
        self.assertEqual([from_csv[i]["source"] for i in range(3)], ["scan_1.pcd", "scan_2.pcd", "scan_3.pcd"])

    def test_names_are_relative_to_the_manifest(self):
        rows = self.pairs(1)
        folder = self.path("elsewhere")
        os.mkdir(folder)
        manifest = self.write("elsewhere/m.csv", csv_text([(f"../{rows[0][0]}", self.path(rows[0][1]))]))
        results, _ = self.batch(manifest)
        self.assertEqual(results[0]["source"], "../scan_1.pcd")
        self.assertEqual(self.transforms(results), self.aligned_alone(rows))

    def test_quotes_of_csv(self):
        names = ["a, b.pcd", 'said "so".pcd', "two\nlines.pcd", " spaces .pcd"]
        for name in names:
            self.write(name, pcd(POINTS))
        text = csv_text([(names[0], names[1]), (names[2], names[3])]).replace(names[3], f'"{names[3]}"')
        for content in (text, text.replace("\r\n", "\n"), "\ufeff" + text, text.rstrip("\r\n"), "\r\n" + text + "\r\n"):
            with self.subTest(content):
                results, _ = self.batch(self.write("m.csv", content), "--force")
                self.assertEqual([(results[i]["source"], results[i]["target"]) for i in range(2)],
                                 [(names[0], names[1]), (names[2], names[3])])

    def test_options_of_a_line(self):
        rows = self.pairs(3)
        columns = ("target", "iterations", "reciprocal", "source", "leaf")
        lines = [(rows[0][1], "1", "", rows[0][0], ""), (rows[1][1], "", "false", rows[1][0], "0.60"),
                 (rows[2][1], "", "", rows[2][0], "")]
        objects = [
            {"source": rows[0][0], "target": rows[0][1], "iterations": 1},
            {"source": rows[1][0], "target": rows[1][1], "reciprocal": False, "leaf": 0.6},
            {"source": rows[2][0], "target": rows[2][1]}]
        expected = [
            {"iterations": "1", "reciprocal": "true"}, {"iterations": "2", "reciprocal": "false", "leaf": "0.6"},
            {"iterations": "2", "reciprocal": "true"}]
        for manifest in (self.manifest(lines, columns), self.write("m.jsonl", json_lines(objects))):
            with self.subTest(manifest):
                results, summary = self.batch(manifest, "--iterations", "2", "--reciprocal", "--force")
                self.assertEqual([results[i]["options"] for i in range(3)], expected)
                self.assertEqual(summary["settings"]["options"], {"iterations": "2", "reciprocal": "true"})
                self.assertEqual([results[i]["iterations"] for i in range(3)], [1, 2, 2])
                for i, arguments in enumerate((["--iterations", "1", "--reciprocal"],
                                               ["--iterations", "2", "--leaf", "0.6"],
                                               ["--iterations", "2", "--reciprocal"])):
                    alone = self.align(self.path(rows[i][0]), self.path(rows[i][1]), *arguments)
                    self.assertEqual(results[i]["transform"], alone["transform"])

    def test_guess_of_a_line(self):
        source = self.write("source.pcd", pcd(POINTS))
        target = self.write("target.pcd", pcd([moved(TURN, point) for point in POINTS]))
        self.write("guess.txt", "\n".join(" ".join(numbers([row])) for row in GUESS))
        flat = [value for row in GUESS for value in row]
        pair = {"source": "source.pcd", "target": "target.pcd"}
        objects = [
            {**pair, "guess": "guess.txt"}, {**pair, "guess": GUESS}, {**pair, "guess": flat},
            {**pair, "guess": " ".join(map(repr, flat))}, pair]
        alone = self.align(source, target, "--guess", *numbers(GUESS))["transform"]
        results, _ = self.batch(self.write("m.jsonl", json_lines(objects)))
        self.assertEqual([results[i]["transform"] for i in range(4)], [alone] * 4)
        self.assertNotEqual(results[4]["transform"], alone)
        self.assertEqual(results[1]["options"], results[2]["options"])
        results, _ = self.batch(self.manifest([("source.pcd", "target.pcd", "guess.txt")], ("source", "target", "guess")),
                                "--force")
        self.assertEqual(results[0]["transform"], alone)
        # One for all is relative to the working directory, as every argument.
        results, _ = self.batch(self.manifest([("source.pcd", "target.pcd")]), "--guess", self.path("guess.txt"), "--force")
        self.assertEqual(results[0]["transform"], alone)

    def test_a_bad_manifest_is_named_before_anything_runs(self):
        self.pairs(1)
        pair = '"source": "scan_1.pcd", "target": "scan_0.pcd"'
        for name, content, names in [
            ("m.csv", "source,target,wobble\nscan_1.pcd,scan_0.pcd,3\n", ["m.csv:1", "wobble"]),
            ("m.csv", "source,target,device\nscan_1.pcd,scan_0.pcd,cpu\n", ["m.csv:1", "device"]),
            ("m.csv", "source,target,json\nscan_1.pcd,scan_0.pcd,a\n", ["m.csv:1", "json"]),
            ("m.csv", "source,target,\nscan_1.pcd,scan_0.pcd,a\n", "m.csv:1"),
            ("m.csv", "source,source,target\na,b,c\n", ["m.csv:1", "source", "twice"]),
            ("m.csv", "source,iterations\nscan_1.pcd,3\n", ["m.csv:1", "no column target"]),
            ("m.csv", "source,target\nscan_1.pcd,scan_0.pcd\n,scan_0.pcd\n", ["m.csv:3", "has no source"]),
            ("m.csv", "source,target\nscan_1.pcd,scan_0.pcd\nscan_1.pcd\n", ["m.csv:3", "1 fields"]),
            ("m.csv", "source,target\nscan_1.pcd,scan_0.pcd,x\n", ["m.csv:2", "3 fields"]),
            ("m.csv", 'source,target\n"scan_1.pcd,scan_0.pcd\n', ["m.csv", "quote"]),
            ("m.csv", 'source,target\n"scan_1.pcd"x,scan_0.pcd\n', ["m.csv:2", "quote"]),
            ("m.csv", 'source,target,leaf\n"a\nb",c,\nd,e,-1\n', ["m.csv:4", "leaf", "-1"]),
            ("m.csv", "source,target,search\na,b,magic\n", ["m.csv:2", "search", "magic"]),
            ("m.csv", "source,target,reciprocal\na,b,maybe\n", ["m.csv:2", "reciprocal", "maybe"]),
            ("m.csv", "source,target,iterations\na,b,1.5\n", ["m.csv:2", "iterations", "1.5"]),
            ("m.csv", "source,target,guess\na,b,1 2 3\n", ["m.csv:2", "guess", "3 numbers"]),
            ("m.csv", "source,target\n", "has no pairs"),
            ("m.csv", "", "has no pairs"),
            ("m.jsonl", f"{{{pair}}}\n{{{pair}, \"wobble\": 1}}\n", ["m.jsonl:2", "wobble"]),
            ("m.jsonl", f"{{{pair}, \"threads\": 1}}\n", ["m.jsonl:1", "threads"]),
            ("m.jsonl", f"{{{pair}, \"source\": \"x\"}}\n", ["m.jsonl:1", "source twice"]),
            ("m.jsonl", '{"source": "scan_1.pcd"}\n', ["m.jsonl:1", "has no target"]),
            ("m.jsonl", f"{{{pair}, \"leaf\": \"wide\"}}\n", ["m.jsonl:1", "leaf", "wide"]),
            ("m.jsonl", f"{{{pair}, \"leaf\": {{}}}}\n", ["m.jsonl:1", "leaf"]),
            ("m.jsonl", f"{{{pair}, \"guess\": [1, \"x\"]}}\n", ["m.jsonl:1", "guess"]),
            ("m.jsonl", f"{{{pair}\n", ["m.jsonl:1", "JSON"]),
            ("m.jsonl", "[1, 2]\n", ["m.jsonl:1", "object"]),
            ("m.txt", "source,target\n", ["m.txt", ".csv"]),
        ]:
            with self.subTest(content):
                done = self.fail_with(
                    INPUT, "batch", self.write(name, content), "-o", self.path("out"), names=names)
                self.assertEqual(done.stdout, "")
                self.assertFalse(os.path.exists(self.path("out")))
        self.fail_with(INPUT, "batch", self.path("none.csv"), "-o", self.path("out"), names="none.csv: No such file")


class Outcomes(BatchTest):
    def test_one_bad_file_is_one_failed_line(self):
        rows = self.pairs(5)
        self.write("empty.pcd", "")
        rows[1:1] = [("none.pcd", "scan_0.pcd")]
        rows[3:3] = [("scan_0.pcd", "empty.pcd")]
        manifest = self.manifest(rows)
        done = self.fail_with(NOT_CONVERGED, "batch", manifest, "-o", self.path("out"),
                              names=["of 7 pairs 2 failed and 0 have no answer", "results.jsonl"])
        results = self.results()
        for pair, file in ((1, "none.pcd"), (3, "empty.pcd")):
            self.assertEqual((results[pair]["status"], results[pair]["error"]["kind"]), ("failed", "input"))
            self.assertIn(file, results[pair]["error"]["message"])
            self.assertIn(file, done.stdout)
        good = [i for i in range(7) if i not in (1, 3)]
        alone = self.aligned_alone([rows[i] for i in good])
        self.assertEqual([results[i]["transform"] for i in good], list(alone.values()))
        summary = self.summary()
        self.assertEqual((summary["failed"], summary["converged"], summary["left"]), (2, 5, 0))
        self.assertEqual([bad["pair"] for bad in summary["unsuccessful"]], [1, 3])

    def test_kinds_of_failure(self):
        self.write("far.pcd", pcd([(9e17, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)]))
        self.pairs(1)
        rows = [("far.pcd", "far.pcd", "0.001", ""), ("scan_1.pcd", "scan_0.pcd", "", "none.txt")]
        results, _ = self.batch(self.manifest(rows, ("source", "target", "leaf", "guess")), code=NOT_CONVERGED)
        self.assertEqual([results[i]["error"]["kind"] for i in range(2)], ["usage", "input"])
        self.assertIn("--leaf", results[0]["error"]["message"])
        self.assertIn("none.txt", results[1]["error"]["message"])

    def test_a_pair_too_large_for_the_device(self):
        rows = self.pairs(3)
        self.write("large.pcd", pcd(surface(120, 100), "binary"))
        results, _ = self.batch(self.manifest([("large.pcd", "large.pcd"), *rows]), code=NOT_CONVERGED,
                                environment={"PCL_GPU_ICP_MAX_ALLOCATION": "100000"})
        self.assertEqual(results[0]["error"]["kind"], "device")
        self.assertEqual([results[i]["status"] for i in (1, 2, 3)], ["converged"] * 3)

    def test_a_device_that_is_lost(self):
        """Pairs that nobody tried have no line, so that they are done later."""
        rows = self.pairs(12)
        shutil.copytree(pathlib.Path(os.environ["PCL_GPU_ICP_SAMPLES"]).parent / "kernels", self.path("kernels"))
        for kernel in (self.directory / "kernels").glob("*.cl"):
            kernel.write_text("no OpenCL C")
        broken = {"PCL_GPU_ICP_KERNEL_DIR": self.path("kernels")}
        arguments = [self.manifest(rows), "--pairs-in-flight", "2"]
        done = self.run_command("batch", *arguments, "-o", self.path("out"), environment=broken)
        self.assertEqual(done.returncode, DEVICE, done)
        self.assertRegex(done.stderr, r"pcl_gpu_icp: the device was lost: .*; 10 of 12 pairs left; --resume goes on\n\Z")
        self.assertEqual([result["error"]["kind"] for result in self.results().values()], ["device"] * 2)
        self.assertEqual((self.summary()["left"], self.summary()["complete"]), (10, False))
        _, summary = self.batch(*arguments, "--resume", code=NOT_CONVERGED)
        self.assertEqual((summary["kept"], summary["converged"], summary["left"]), (2, 10, 0))

    def test_a_pair_that_does_not_converge(self):
        rows = self.pairs(2)
        self.write("far.pcd", pcd([(x + 1000, y, z) for x, y, z in POINTS]))
        done = self.fail_with(NOT_CONVERGED, "batch", self.manifest([*rows, ("scan_0.pcd", "far.pcd")]), "-o",
                              self.path("out"), "--max-distance", "1", "--once", names="of 3 pairs 0 failed and 1 have no answer")
        self.assertIn("scan_0.pcd onto far.pcd: no answer: no pair within --max-distance 1", done.stdout)
        result = self.results()[2]
        self.assertEqual((result["status"], result["converged"]), ("not converged", False))
        self.assertIn("no answer: no pair within", self.summary()["unsuccessful"][0]["why"])

    def test_fail_fast(self):
        rows = [("none.pcd", "scan_0.pcd"), *self.pairs(40)]
        arguments = ["--fail-fast", "--policy", "fifo", "--pairs-in-flight", "1"]
        done = self.fail_with(NOT_CONVERGED, "batch", self.manifest(rows), "-o", self.path("out"), *arguments,
                              names="--fail-fast left 40")
        self.assertIn("1/41 pair 0 none.pcd", done.stdout)
        self.assertEqual(list(self.results()), [0])
        summary = self.summary()
        self.assertEqual((summary["failed"], summary["left"], summary["complete"]), (1, 40, False))
        # What was cancelled is done by the next run.
        results, summary = self.batch(self.manifest(rows), "--resume", code=NOT_CONVERGED)
        self.assertEqual(len(results), 41)
        self.assertEqual((summary["kept"], summary["aligned"]), (1, 40))

    def test_fail_fast_without_a_failure(self):
        results, _ = self.batch(self.manifest(self.pairs(4)), "--fail-fast")
        self.assertEqual(len(results), 4)


class Outputs(BatchTest):
    def setUp(self):
        super().setUp()
        self.rows = self.pairs(2)
        self.file = self.manifest(self.rows)

    def test_results_that_exist_are_refused(self):
        self.batch(self.file)
        before = self.lines()
        self.fail_with(OUTPUT, "batch", self.file, "-o", self.path("out"), names=["results.jsonl", "--resume", "--force"])
        self.assertEqual(self.lines(), before)
        _, summary = self.batch(self.file, "--force")
        self.assertEqual(summary["aligned"], 2)
        self.fail_with(USAGE, "batch", self.file, "-o", self.path("out"), "--force", "--resume", names="--force")

    def test_directories(self):
        self.fail_with(OUTPUT, "batch", self.file, "-o", self.path("no/out"), names=["-o", "No such file"])
        self.fail_with(OUTPUT, "batch", self.file, "-o", self.file, names=["-o", "not a directory"])
        os.mkdir(self.path("made"))
        self.batch(self.file, output="made")
        os.makedirs(self.path("odd/results.jsonl"))
        self.fail_with(OUTPUT, "batch", self.file, "-o", self.path("odd"), "--force", names="results.jsonl")

    def test_a_file_in_the_way_is_found_before_the_work(self):
        os.mkdir(self.path("out"))
        for name in ("summary.json", "trace.json"):
            with self.subTest(name):
                self.write(f"out/{name}", "mine")
                self.fail_with(OUTPUT, "batch", self.file, "-o", self.path("out"), "--trace", self.path("out/trace.json"),
                               names=name)
                self.assertEqual(pathlib.Path(self.path(f"out/{name}")).read_text(), "mine")
                self.assertEqual(os.listdir(self.path("out")), [name])
                os.remove(self.path(f"out/{name}"))

    def test_the_trace_is_no_other_output(self):
        self.batch(self.file)
        before = self.lines()
        for name in ("results.jsonl", "summary.json"):
            self.fail_with(USAGE, "batch", self.file, "-o", self.path("out"), "--resume", "--trace",
                           self.path(f"out/../out/{name}"), names=["--trace", name])
        self.assertEqual(self.lines(), before)

    def test_standard_output_that_is_full(self):
        with open("/dev/full", "w") as full:
            done = self.run_command("batch", self.file, "-o", self.path("out"), stdout=full)
        self.assertEqual((done.returncode, done.stderr),
                         (OUTPUT, "pcl_gpu_icp: standard output: No space left on device\n"))


class Settings(BatchTest):
    def test_none_changes_a_transform(self):
        rows = self.pairs(6)
        manifest = self.manifest(rows)
        alone = self.aligned_alone(rows)
        for arguments, key, value in [
            (["--pairs-in-flight", "3"], "pairs_in_flight", 3),
            (["--points-in-flight", "1000"], "points_in_flight", 1000),
            (["--capacity", "7"], "capacity", 7),
            (["--policy", "fifo"], "policy", "fifo"),
            (["--policy", "largest"], "policy", "largest"),
            (["--threads", "2"], "policy", "smallest"),
        ]:
            with self.subTest(arguments):
                results, summary = self.batch(manifest, *arguments, "--force")
                self.assertEqual(self.transforms(results), alone)
                self.assertEqual(summary["settings"][key], value)

    def finishing_order(self, policy):
        clouds = {"small.pcd": POINTS[:100], "large.pcd": POINTS, "middle.pcd": POINTS[:300]}
        for name, points in clouds.items():
            self.write(name, pcd(points))
        ply = f"ply\nformat ascii 1.0\nelement vertex 200\n" + "".join(f"property float {a}\n" for a in "xyz")
        self.write("some.ply", ply + "end_header\n" + "".join("%r %r %r\n" % point for point in POINTS[:200]))
        names = ["middle.pcd", "large.pcd", "some.ply", "small.pcd"]
        self.batch(self.manifest([(name, name) for name in names]), "--policy", policy, "--pairs-in-flight", "1", "--force")
        return [json.loads(line)["source"] for line in self.lines()]

    def test_pairs_are_ordered_by_the_points_in_their_headers(self):
        self.assertEqual(self.finishing_order("smallest"), ["small.pcd", "some.ply", "middle.pcd", "large.pcd"])
        self.assertEqual(self.finishing_order("largest"), ["large.pcd", "middle.pcd", "some.ply", "small.pcd"])
        self.assertEqual(self.finishing_order("fifo"), ["middle.pcd", "large.pcd", "some.ply", "small.pcd"])

    def test_devices(self):
        manifest = self.manifest(self.pairs(3))
        listed = json.loads(self.succeed("devices", "--json"))["devices"]
        names = [device["selector"] for device in listed]
        for arguments in (["--device", ",".join(names)], [word for name in names for word in ("--device", name)]):
            _, summary = self.batch(manifest, *arguments, "--force")
            self.assertEqual([device["name"] for device in summary["devices"]], [device["name"] for device in listed])
        self.fail_with(USAGE, "batch", manifest, "-o", self.path("x"), "--device", f"{names[0]},{names[0]}", names="twice")
        self.fail_with(DEVICE, "batch", manifest, "-o", self.path("x"), "--device", "nosuch", names="nosuch")
        self.assertFalse(os.path.exists(self.path("x")))

    def test_wrong_arguments(self):
        manifest = self.manifest(self.pairs(1))
        for arguments, names in [
            ([manifest], "--output"),
            (["-o", "x"], ["MANIFEST", "--sequence"]),
            ([manifest, "--sequence", "scan_*.pcd", "-o", "x"], ["MANIFEST", "--sequence"]),
            ([manifest, "-o", "x", "--policy", "magic"], ["--policy", "magic"]),
            ([manifest, "-o", "x", "--pairs-in-flight", "0"], "--pairs-in-flight"),
            ([manifest, "-o", "x", "--points-in-flight", "many"], "--points-in-flight"),
            ([manifest, "-o", "x", "--capacity", "-1"], "--capacity"),
            ([manifest, "-o", "x", "--leaf", "0"], "--leaf"),
            ([manifest, "-o", "x", "--json", "y"], "--json"),
            *(([manifest, "-o", "x", "--shard", shard], ["--shard", shard])
              for shard in ("0/3", "4/3", "1", "1/0", "a/b", "1/3/5", "-1/3", "/")),
            (["--sequence", "scan_*.pcd", "-o", "x", "--shard", "1/2"], "--shard"),
        ]:
            with self.subTest(arguments):
                self.fail_with(USAGE, "batch", *arguments, names=names)

    def test_help(self):
        text = self.succeed("batch", "--help")
        for option in ("MANIFEST", "--sequence", "--resume", "--fail-fast", "--shard", "--trace", "--policy", "--leaf"):
            self.assertIn(option, text)
        self.assertIn("batch", self.succeed("--help"))
