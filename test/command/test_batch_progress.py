"""A bar on a terminal, plain lines in a pipe."""

import re

from batches import BatchTest
from command import NOT_CONVERGED


class Progress(BatchTest):
    def setUp(self):
        super().setUp()
        self.file = self.manifest([*self.pairs(6), ("none.pcd", "scan_0.pcd")])
        self.arguments = ["batch", self.file, "-o", self.path("out"), "--policy", "fifo", "--pairs-in-flight", "1"]

    def test_a_bar_on_a_terminal(self):
        _, seen = self.on_terminal(*self.arguments, code=NOT_CONVERGED, stdout_too=True)
        bars = re.findall(r"\r(\[[#.]{24}\] (\d)/7)(.*?)\x1b\[K", seen)
        bars = list(dict.fromkeys(bars))  # one is shown again where what was told of a first start covered it
        self.assertEqual([int(done) for _, done, _ in bars], list(range(8)))
        self.assertEqual((bars[0][0], bars[0][2]), ("[" + "." * 24 + "] 0/7", ""))
        for _, _, rest in bars[1:7]:
            self.assertRegex(rest, r"\A, \d+\.\d pairs/s, \d+:\d\d left\Z")
        self.assertEqual(bars[7][0], "[" + "#" * 24 + "] 7/7")
        self.assertRegex(bars[7][2], r"\A, 1 without success, \d+\.\d pairs/s, 0:00 left\Z")
        last = seen.split("\r\x1b[K")[-1]
        self.assertRegex(last, r"(?s)\Apairs      7: 6 converged, 0 without an answer, 1 failed\r\n.*"
                               r"pcl_gpu_icp: of 7 pairs 1 failed [^\n]+\n\Z", "the bar is gone in the end")
        self.assertNotIn("1/7 pair 0 scan_1.pcd", seen)

    def test_a_bar_and_lines_that_go_elsewhere(self):
        text, seen = self.on_terminal(*self.arguments, code=NOT_CONVERGED)
        self.assertRegex(text, r"\A1/7 pair 0 scan_1.pcd onto scan_0.pcd: converged")
        self.assertNotIn("\r", text)
        self.assertIn("] 7/7, 1 without success", seen)

    def test_lines_in_a_pipe(self):
        done = self.run_command(*self.arguments)
        self.assertNotIn("\r", done.stdout + done.stderr)
        lines = done.stdout.splitlines()
        for i in range(6):
            self.assertRegex(lines[i], rf"\A{i + 1}/7 pair {i} scan_{i + 1}.pcd onto scan_{i}.pcd: "
                                       r"converged, \d+ iterations, RMSE [0-9.e-]+\Z")
        self.assertRegex(lines[6], r"\A7/7 pair 6 none.pcd onto scan_0.pcd: failed: .*none.pcd: No such file or directory\Z")
        self.assertRegex("\n".join(lines[7:]), r"(?s)\Apairs +7: .*\ndevice .*\ntime .* pairs/s\nresults .*results.jsonl\n")
        self.assertEqual(done.stderr.count("\n"), 1)

    def test_lines_have_the_numbers_of_the_manifest(self):
        done = self.run_command(*self.arguments[:4], "--policy", "fifo", "--pairs-in-flight", "1", "--shard", "2/3")
        self.assertRegex(done.stdout, r"\A1/2 pair 1 scan_2.pcd onto scan_1.pcd: .*\n2/2 pair 4 scan_5.pcd onto scan_4.pcd: ")

    def test_quiet(self):
        done = self.run_command(*self.arguments, "--quiet")
        self.assertEqual((done.returncode, done.stdout, done.stderr.count("\n")), (NOT_CONVERGED, "", 1))
        self.assertEqual(self.on_terminal(*self.arguments, "--quiet", "--force", code=NOT_CONVERGED)[1].count("["), 0)

    def test_a_resumed_run_counts_what_is_there(self):
        self.run_command(*self.arguments)
        path = self.directory / "out/results.jsonl"
        path.write_text("".join(path.read_text().splitlines(keepends=True)[:4]))
        done = self.run_command(*self.arguments, "--resume")
        self.assertIn("5/7 ", done.stdout.splitlines()[0])
        self.assertIn("(4 were there already)", done.stdout)
