"""The schedule as a trace that Perfetto shows."""

import json
import os
import pathlib

from batches import BatchTest
from command import NOT_CONVERGED, OUTPUT


class Trace(BatchTest):
    def trace(self, *arguments, code=0):
        self.batch(*arguments, "--trace", self.path("trace.json"), "--force", code=code)
        trace = json.loads(pathlib.Path(self.path("trace.json")).read_text())
        return trace["traceEvents"]

    def check_no_overlap(self, spans):
        spans = sorted(spans, key=lambda span: span["ts"])
        for a, b in zip(spans, spans[1:]):
            self.assertLessEqual(a["ts"] + a["dur"], b["ts"] + 0.002, (a, b))

    def test_spans_counters_and_names(self):
        rows = self.pairs(8)
        capacity = 300  # below the points of a cloud, so that requests wait
        for arguments in (["--search", "device"], []):
            with self.subTest(arguments):
                events = self.trace(self.manifest(rows), "--pairs-in-flight", "3", "--capacity", capacity, *arguments)
                self.check(events, rows, capacity)

    def check(self, events, rows, capacity):
        of_kind = lambda kind: [event for event in events if event["ph"] == kind]
        spans = of_kind("X")
        pairs = [span for span in spans if span["cat"] == "pair"]
        stages = [span for span in spans if span["cat"] == "stage"]
        self.assertEqual(sorted(span["args"]["pair"] for span in pairs), list(range(len(rows))))
        self.assertEqual({span["args"]["pair"] for span in stages}, set(range(len(rows))))
        colours = {}
        for span in spans:
            pair = span["args"]["pair"]
            self.assertEqual((span["args"]["source"], span["args"]["target"]), rows[pair])
            self.assertGreaterEqual(span["dur"], 0)
            self.assertEqual(colours.setdefault(pair, span["cname"]), span["cname"])
        self.assertEqual(len(set(colours.values())), len(rows))
        for stage in stages:
            self.assertTrue(0 < stage["args"]["work_items"] <= capacity)
            whole = next(span for span in pairs if span["args"]["pair"] == stage["args"]["pair"])
            self.assertEqual((stage["pid"], stage["tid"]), (whole["pid"], whole["tid"]))
            self.assertGreaterEqual(stage["ts"], whole["ts"])
            self.assertLessEqual(stage["ts"] + stage["dur"], whole["ts"] + whole["dur"] + 0.002)
        lanes = {(span["pid"], span["tid"]) for span in spans}
        self.assertLessEqual(len(lanes), 3)
        for lane in lanes:
            for kind in (pairs, stages):
                self.check_no_overlap([span for span in kind if (span["pid"], span["tid"]) == lane])

        names = {(event["name"], event["pid"], event["tid"]): event["args"]["name"] for event in of_kind("M")}
        self.assertEqual({key[1:] for key in names if key[0] == "thread_name"}, lanes)
        for (pid, tid) in lanes:
            self.assertEqual(names["thread_name", pid, tid], f"lane {tid}")
            self.assertEqual(names["process_name", pid, 0], self.summary()["devices"][pid]["name"])

        counters = {}
        for event in of_kind("C"):
            counters.setdefault(event["name"], []).extend(event["args"].values())
        self.assertEqual(set(counters), {"idle work-items", "waiting requests"})
        self.assertTrue(all(0 <= idle <= capacity for idle in counters["idle work-items"]))
        self.assertLess(min(counters["idle work-items"]), capacity)
        self.assertEqual((counters["idle work-items"][-1], counters["waiting requests"][-1]), (capacity, 0))

    def test_pairs_have_the_numbers_of_the_manifest(self):
        rows = [("none.pcd", "scan_0.pcd"), *self.pairs(5)]
        manifest = self.manifest(rows)
        self.batch(manifest, code=NOT_CONVERGED)
        results = pathlib.Path(self.path("out/results.jsonl"))
        results.write_text("".join(line + "\n" for line in self.lines() if json.loads(line)["pair"] not in (2, 4)))
        self.batch(manifest, "--resume", "--trace", self.path("trace.json"), code=NOT_CONVERGED)
        events = json.loads(pathlib.Path(self.path("trace.json")).read_text())["traceEvents"]
        spans = [event for event in events if event["ph"] == "X"]
        self.assertEqual({span["args"]["pair"] for span in spans}, {2, 4})
        self.assertEqual({span["args"]["source"] for span in spans}, {rows[2][0], rows[4][0]})

    def test_an_existing_file_is_refused(self):
        trace = self.write("trace.json", "mine")
        self.fail_with(OUTPUT, "batch", self.manifest(self.pairs(1)), "-o", self.path("out"), "--trace", trace,
                       names=["--trace", "exists"])
        self.assertFalse(os.path.exists(self.path("out/results.jsonl")))
