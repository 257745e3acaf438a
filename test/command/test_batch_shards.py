"""Parts of a manifest on several machines: no file in common, and together what a single run gives."""

import os
import pathlib
import subprocess

from batches import BatchTest, without_times
from command import COMMAND, INPUT, NOT_CONVERGED


class Shards(BatchTest):
    def setUp(self):
        super().setUp()
        self.rows = [*self.pairs(7), ("none.pcd", "scan_0.pcd")]
        self.file = self.manifest(self.rows)
        self.single, _ = self.batch(self.file, output="single", code=NOT_CONVERGED)

    def test_together_they_are_a_single_run(self):
        processes = [
            subprocess.Popen([COMMAND, "batch", self.file, "-o", self.path("out"), "--shard", f"{i}/3", "--quiet"],
                             stderr=subprocess.DEVNULL)
            for i in (1, 2, 3)]
        self.assertEqual([process.wait(timeout=300) for process in processes], [0, NOT_CONVERGED, 0])
        self.assertEqual(
            set(os.listdir(self.path("out"))),
            {f"{stem}-{i}-of-3.{kind}" for i in (1, 2, 3) for stem, kind in (("results", "jsonl"), ("summary", "json"))})
        merged = "".join(
            pathlib.Path(self.path(f"out/results-{i}-of-3.jsonl")).read_text() for i in (1, 2, 3))
        self.write("out/results.jsonl", merged)
        self.assertEqual(without_times(self.results()), without_times(self.single))
        self.assertEqual([sorted(self.results("out", f"results-{i}-of-3.jsonl")) for i in (1, 2, 3)],
                         [[0, 3, 6], [1, 4, 7], [2, 5]])
        summaries = [self.summary("out", f"summary-{i}-of-3.json") for i in (1, 2, 3)]
        self.assertEqual([summary["shard"] for summary in summaries], [{"number": i, "of": 3} for i in (1, 2, 3)])
        self.assertEqual([summary["pairs"] for summary in summaries], [3, 3, 2])
        # What was merged is a run's own result: there is nothing left to do.
        _, summary = self.batch(self.file, "--resume", code=NOT_CONVERGED)
        self.assertEqual((summary["kept"], summary["aligned"]), (8, 0))

    def test_a_shard_resumes(self):
        self.succeed("batch", self.file, "-o", self.path("out"), "--shard", "1/2", "--iterations", "2", "--quiet")
        path = pathlib.Path(self.path("out/results-1-of-2.jsonl"))
        path.write_text("".join(path.read_text().splitlines(keepends=True)[:2]))
        self.succeed("batch", self.file, "-o", self.path("out"), "--shard", "1/2", "--iterations", "2", "--quiet", "--resume")
        self.assertEqual(sorted(self.results("out", "results-1-of-2.jsonl")), [0, 2, 4, 6])
        self.assertEqual(self.summary("out", "summary-1-of-2.json")["kept"], 2)

    def test_results_of_another_shard(self):
        self.succeed("batch", self.file, "-o", self.path("out"), "--shard", "1/2", "--quiet")
        os.rename(self.path("out/results-1-of-2.jsonl"), self.path("out/results-2-of-2.jsonl"))
        self.fail_with(INPUT, "batch", self.file, "-o", self.path("out"), "--shard", "2/2", "--resume",
                       names=["results-2-of-2.jsonl:1", "not among those"])

    def test_more_shards_than_pairs(self):
        self.succeed("batch", self.file, "-o", self.path("out"), "--shard", "9/9", "--quiet")
        self.assertEqual(self.lines("out", "results-9-of-9.jsonl"), [])
        self.assertEqual(self.summary("out", "summary-9-of-9.json")["pairs"], 0)
