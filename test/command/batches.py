"""Runs batches of small clouds and reads what they write."""

import csv
import io
import json
import pathlib

from command import SCHEMA, SUCCESS, CommandTest, motion, moved, pcd, surface

RESULT_SCHEMA = SCHEMA.with_name("batch.schema.json")
SUMMARY_SCHEMA = SCHEMA.with_name("batch_summary.schema.json")
POINTS = surface()


def csv_text(rows, columns=("source", "target")):
    text = io.StringIO()
    writer = csv.writer(text)
    writer.writerows([columns, *rows])
    return text.getvalue()


class BatchTest(CommandTest):
    def scans(self, count, points=POINTS):
        """Writes scan_0.pcd and so on, each the points moved a little more, and returns their names in the folder."""
        names = [f"scan_{i}.pcd" for i in range(count)]
        for i, name in enumerate(names):
            matrix = motion(0.5 * i, (0.02 * i, -0.01 * i, 0.01 * i))
            self.write(name, pcd([moved(matrix, point) for point in points], "binary"))
        return names

    def pairs(self, count, points=POINTS):
        """Each scan and the one before."""
        names = self.scans(count + 1, points)
        return list(zip(names[1:], names))

    def manifest(self, rows, columns=("source", "target"), name="manifest.csv"):
        return self.write(name, csv_text(rows, columns))

    def batch(self, *arguments, code=SUCCESS, output="out", **settings):
        """Runs a batch into a directory and returns its results by their pairs, and the summary."""
        done = self.run_command("batch", *arguments, "-o", self.path(output), **settings)
        self.assertEqual(done.returncode, code, done)
        return self.results(output), self.summary(output)

    def results(self, output="out", name="results.jsonl"):
        lines = [self.checked(line, RESULT_SCHEMA) for line in self.lines(output, name)]
        by_pair = {line["pair"]: line for line in lines}
        self.assertEqual(len(by_pair), len(lines), "no pair is there twice")
        return by_pair

    def lines(self, output="out", name="results.jsonl"):
        text = pathlib.Path(self.path(output), name).read_text()
        self.assertTrue(text == "" or text.endswith("\n"), "whole lines only")
        return text.splitlines()

    def summary(self, output="out", name="summary.json"):
        return self.checked(pathlib.Path(self.path(output), name).read_text(), SUMMARY_SCHEMA)

    def transforms(self, results):
        return {pair: result.get("transform") for pair, result in results.items()}

    def aligned_alone(self, rows, *arguments):
        """What align makes of each pair."""
        return {
            i: self.align(self.path(source), self.path(target), *arguments)["transform"]
            for i, (source, target) in enumerate(rows)}


def without_times(results):
    """What is the same in every run."""
    return {
        pair: {key: value for key, value in result.items() if key not in ("times_ms", "device_bytes")}
        for pair, result in results.items()}


def json_lines(objects):
    return "".join(json.dumps(each) + "\n" for each in objects)
