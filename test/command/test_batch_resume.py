"""Whatever ends a batch, --resume goes on with what is whole."""

import errno
import fcntl
import json
import os
import pathlib
import resource
import signal
import subprocess
import time

from batches import BatchTest, without_times
from command import COMMAND, INPUT, NOT_CONVERGED, OUTPUT, surface

SLOW = surface(120, 100)


class Interrupted(BatchTest):
    """A batch of pairs that take a while, and what there is of it when it has been ended half-way."""

    def setUp(self):
        super().setUp()
        source, target = self.pairs(1, SLOW)[0]
        self.rows = [(source, target, str(5 + i)) for i in range(30)]
        self.columns = ("source", "target", "iterations")
        self.file = self.manifest(self.rows, self.columns)
        self.arguments = ["--reciprocal", "--fitness-epsilon", "1e-300", "--policy", "fifo"]

    def wait_for_results(self, process, count, meanwhile=lambda: None):
        results = pathlib.Path(self.path("out/results.jsonl"))
        while not results.exists() or results.read_bytes().count(b"\n") < count:
            self.assertIsNone(process.poll(), "ended by itself")
            meanwhile()
            time.sleep(0.001)

    def end_half_way(self, number):
        """Sends the signal once there are results, and returns how it ended."""
        process = subprocess.Popen(
            [COMMAND, "batch", self.file, "-o", self.path("out"), *self.arguments, "--pairs-in-flight", "2"],
            stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.wait_for_results(process, 5)
        process.send_signal(number)
        _, errors = process.communicate(timeout=300)
        self.assertFalse(os.path.exists(self.path("out/summary.json")))
        return process.returncode, errors

    def check_resumed(self):
        """The next run does what is missing, and only that."""
        before = pathlib.Path(self.path("out/results.jsonl")).read_text()
        whole = before[: before.rfind("\n") + 1]
        done = whole.count("\n")
        self.assertLess(done, len(self.rows))
        results, summary = self.batch(self.file, *self.arguments, "--resume")
        after = pathlib.Path(self.path("out/results.jsonl")).read_text()
        self.assertTrue(after.startswith(whole), "what was whole is as it was")
        self.assertEqual((summary["kept"], summary["aligned"], summary["complete"]), (done, len(self.rows) - done, True))
        at_once, _ = self.batch(self.file, *self.arguments, "--force", output="at once")
        self.assertEqual(without_times(results), without_times(at_once))
        # Nothing is left to do.
        _, summary = self.batch(self.file, *self.arguments, "--resume")
        self.assertEqual((summary["aligned"], summary["pairs_per_second"]), (0, None))
        self.assertEqual(pathlib.Path(self.path("out/results.jsonl")).read_text(), after)

    def test_kill(self):
        self.assertEqual(self.end_half_way(signal.SIGKILL)[0], -signal.SIGKILL)
        self.check_resumed()

    def test_interrupt_and_terminate(self):
        for number, code in ((signal.SIGINT, 130), (signal.SIGTERM, 143)):
            with self.subTest(number):
                ended, errors = self.end_half_way(number)
                self.assertEqual(ended, code)
                self.assertRegex(
                    errors, r"\Apcl_gpu_icp: interrupted with \d+ of 30 pairs left; --resume goes on\n\Z")
                self.lines()
                self.check_resumed()
                for file in pathlib.Path(self.path("out")).iterdir():
                    file.unlink()

    def test_interrupted_while_the_kernels_are_built(self):
        """What PoCL's compiler makes of a signal is no failure of a pair."""
        for delay in (0, 0.1, 0.2, 0.4):
            with self.subTest(delay):
                cache = {"POCL_CACHE_DIR": self.path(f"cache {delay}")}
                process = subprocess.Popen(
                    [COMMAND, "batch", self.file, "-o", self.path("out"), "--quiet"],
                    stdin=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, env={**os.environ, **cache},
                    start_new_session=True)
                self.wait_for_results(process, 0)
                time.sleep(delay)
                os.killpg(process.pid, signal.SIGINT)  # as a terminal does, also to the programs that PoCL runs
                _, errors = process.communicate(timeout=300)
                self.assertEqual(process.returncode, 130, errors)
                self.assertRegex(errors, r"\Apcl_gpu_icp: interrupted with \d+ of 30 pairs left; --resume goes on\n\Z")
                self.assertEqual({result["status"] for result in self.results().values()} - {"converged", "at the limit"}, set())
                os.remove(self.path("out/results.jsonl"))

    def test_a_signal_that_is_ignored(self):
        """As nohup and shells leave it for what runs in the background."""
        process = subprocess.Popen(
            [COMMAND, "batch", self.file, "-o", self.path("out"), "--quiet"], stdin=subprocess.DEVNULL,
            preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_IGN))
        self.wait_for_results(process, 3, lambda: process.send_signal(signal.SIGINT))
        self.assertEqual(process.wait(timeout=300), 0)
        self.assertEqual(len(self.results()), len(self.rows))

    def test_a_line_that_is_torn(self):
        self.batch(self.file, *self.arguments)
        results = pathlib.Path(self.path("out/results.jsonl"))
        content = results.read_bytes()
        start = content.rindex(b"\n", 0, -1) + 1
        for length in (start + 1, (start + len(content)) // 2, len(content) - 1):
            with self.subTest(length):
                results.write_bytes(content[:length])
                self.check_resumed()
        results.write_bytes(content[:10])  # not even one line is whole
        self.check_resumed()


class FullDisk(BatchTest):
    def setUp(self):
        super().setUp()
        self.pairs(1)
        # Lines so long that a limit which they exceed is one that the files PoCL keeps its kernels in do not.
        detour = "./" * 1900
        row = (detour + "scan_1.pcd", detour + "scan_0.pcd")
        self.file = self.manifest([row] * 300)

    def limited(self, *arguments):
        limit = (2 << 20) + 137
        return self.fail_with(
            OUTPUT, "batch", self.file, "-o", self.path("out"), *arguments,
            names=["results.jsonl", os.strerror(errno.EFBIG)],
            preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit)))

    def test_no_line_is_torn_and_the_rest_is_done_later(self):
        self.limited()
        first = self.lines()
        self.assertTrue(0 < len(first) < 300)
        self.assertFalse(os.path.exists(self.path("out/summary.json")))
        self.limited("--resume")
        self.assertEqual(self.lines(), first)
        results, summary = self.batch(self.file, "--resume")
        self.assertEqual((len(results), summary["kept"]), (300, len(first)))
        self.assertEqual(self.lines()[: len(first)], first)

    def test_a_device_that_is_full(self):
        mount = self.path("small")
        os.mkdir(mount)
        if subprocess.run(["mount", "-t", "tmpfs", "-o", "size=256k", "none", mount], capture_output=True).returncode != 0:
            self.skipTest("cannot mount a small file system")
        self.addCleanup(subprocess.run, ["umount", mount], check=True)
        done = self.fail_with(OUTPUT, "batch", self.file, "-o", self.path("small/out"),
                              names=["results.jsonl", os.strerror(errno.ENOSPC)])
        self.assertIn("converged", done.stdout)
        first = self.lines("small/out")
        self.assertGreater(len(first), 5)
        subprocess.run(["mount", "-o", "remount,size=16m", mount], check=True)
        results, summary = self.batch(self.file, "--resume", output="small/out")
        self.assertEqual((len(results), summary["kept"]), (300, len(first)))


class Agreement(BatchTest):
    def setUp(self):
        super().setUp()
        self.rows = self.pairs(3)
        self.file = self.manifest([*self.rows, ("none.pcd", "scan_0.pcd")])
        self.batch(self.file, code=NOT_CONVERGED)
        self.results_path = pathlib.Path(self.path("out/results.jsonl"))

    def resume(self, *arguments, names):
        before = self.results_path.read_bytes()
        self.fail_with(INPUT, "batch", self.file, "-o", self.path("out"), "--resume", *arguments, names=names)
        self.assertEqual(self.results_path.read_bytes(), before)

    def test_failed_pairs_are_not_done_again(self):
        (self.directory / "none.pcd").write_bytes((self.directory / "scan_1.pcd").read_bytes())
        _, summary = self.batch(self.file, "--resume", code=NOT_CONVERGED)
        self.assertEqual((summary["aligned"], summary["failed"]), (0, 1))
        # Unless their line is deleted.
        self.results_path.write_text("".join(line + "\n" for line in self.lines() if '"failed"' not in line))
        _, summary = self.batch(self.file, "--resume")
        self.assertEqual((summary["aligned"], summary["kept"], summary["failed"]), (1, 3, 0))

    def test_another_manifest(self):
        self.manifest([self.rows[0], self.rows[1], (self.rows[2][0], "scan_0.pcd"), ("none.pcd", "scan_0.pcd")])
        self.resume(names=["results.jsonl:", "pair 2", "scan_3.pcd onto scan_0.pcd"])
        self.manifest([*self.rows, ("other.pcd", "scan_0.pcd")])
        self.resume(names=["results.jsonl:", "pair 3", "other.pcd"])
        self.manifest(self.rows)
        self.resume(names=["results.jsonl:", "pair 3 is not among those to align"])

    def test_other_options(self):
        self.resume("--iterations", "7", names=["results.jsonl:1", "options"])
        self.resume("--search", "device", names=["results.jsonl:1", "options"])
        # Those that decide nothing may change.
        _, summary = self.batch(self.file, "--resume", "--policy", "fifo", "--threads", "2", code=NOT_CONVERGED)
        self.assertEqual(summary["aligned"], 0)

    def test_a_longer_manifest(self):
        self.manifest([*self.rows, ("none.pcd", "scan_0.pcd"), ("scan_3.pcd", "scan_0.pcd")])
        results, summary = self.batch(self.file, "--resume", code=NOT_CONVERGED)
        self.assertEqual((summary["kept"], summary["aligned"], results[4]["status"]), (4, 1, "converged"))

    def test_equal_numbers_agree_however_they_are_written(self):
        rows = [(*row, leaf) for row, leaf in zip(self.rows, ("0.5", "0.50", "5e-1"))]
        manifest = self.manifest(rows, ("source", "target", "leaf"), "leaf.csv")
        self.batch(manifest, output="leaf")
        rows = [(*row, "+0.5") for row in self.rows]
        self.manifest(rows, ("source", "target", "leaf"), "leaf.csv")
        _, summary = self.batch(manifest, "--resume", output="leaf")
        self.assertEqual(summary["kept"], 3)

    def test_lines_that_are_no_results(self):
        lines = self.lines()
        self.results_path.write_text("\n".join([*lines, "pair 9 went well"]) + "\n")
        self.resume(names="results.jsonl:5: is no result of a batch")
        self.results_path.write_text("\n".join([*lines, lines[0]]) + "\n")
        self.resume(names=["results.jsonl:5", "is there twice"])
        self.results_path.write_text(json.dumps({"pair": 0}) + "\n")
        self.resume(names="results.jsonl:1: is no result of a batch")

    def test_two_at_once(self):
        with open(self.results_path, "a") as file:
            fcntl.flock(file, fcntl.LOCK_EX)
            self.fail_with(OUTPUT, "batch", self.file, "-o", self.path("out"), "--resume",
                           names=["results.jsonl", "another process"])

    def test_a_name_that_is_no_utf8_agrees_with_itself(self):
        name = os.fsencode(self.directory) + b"/\xff.pcd"
        pathlib.Path(os.fsdecode(name)).write_bytes((self.directory / "scan_1.pcd").read_bytes())
        manifest = self.write("odd.csv", b"source,target\n\xff.pcd,scan_0.pcd\n")
        self.succeed("batch", manifest, "-o", self.path("odd"), "--quiet")
        self.assertEqual(self.results("odd")[0]["source"], "\ufffd.pcd")
        self.succeed("batch", manifest, "-o", self.path("odd"), "--quiet", "--resume")
        self.assertEqual(self.summary("odd")["kept"], 1)

    def test_nothing_to_resume_is_a_new_run(self):
        _, summary = self.batch(self.file, "--resume", output="new", code=NOT_CONVERGED)
        self.assertEqual((summary["kept"], summary["aligned"]), (0, 4))
