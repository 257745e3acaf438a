"""--help: options by groups, in lines that fit a terminal, and examples that run."""

import os
import pathlib
import re
import subprocess

from command import COMMAND, CommandTest, motion, moved, pcd, ply, surface

COMMANDS = ("align", "batch", "compare", "devices")
GROUPS = ["Common options", "Search and metric", "Robustness", "When it ends", "Output", "Batch", "Comparison", "Advanced"]


def headings(text):
    return re.findall(r"^([A-Z][^:\n]*):$", text, re.MULTILINE)


def examples(text):
    """The command lines at the end of a help."""
    lines = re.findall(r"^    (\S.*)$", text.partition("Examples:\n")[2].replace("\\\n        ", ""), re.MULTILINE)
    return [line for line in lines if "pcl_gpu_icp " in line]


class Help(CommandTest):
    def test_of_the_whole(self):
        text = self.succeed("--help")
        for command in COMMANDS:
            self.assertEqual(len(re.findall(rf"^  {command}  +[A-Z].*$", text, re.MULTILINE)), 1)
        self.assertEqual(len(examples(text)), 1)
        self.assertIn("Exit status: 0 converged", text)
        self.assertNotIn("Exactly 1", text)

    def test_groups_in_their_order(self):
        for command, groups in {
            "align": ["Common options", "Search and metric", "Robustness", "When it ends", "Output", "Advanced"],
            "batch": ["Common options", "Search and metric", "Robustness", "When it ends", "Output", "Batch", "Advanced"],
            "compare": ["Common options", "Search and metric", "Robustness", "When it ends", "Output", "Comparison",
                        "Advanced"],
            "devices": ["Common options", "Output"],
        }.items():
            with self.subTest(command):
                text = self.succeed(command, "--help")
                self.assertEqual([name for name in headings(text) if name in GROUPS], groups)
                common = text.partition("Common options:\n")[2].partition("\n\n")[0]
                self.assertIn("--help", common)
                if command != "devices":
                    self.assertIn("--guess", common)

    def test_lines_fit_a_terminal(self):
        for command in ((), *((name,) for name in COMMANDS)):
            for line in self.succeed(*command, "--help").splitlines():
                self.assertLessEqual(len(line), 80, line)

    def test_columns_of_a_manifest(self):
        text = self.succeed("batch", "--help")
        columns = text.partition("in columns: ")[2].partition(".")[0].replace("\n", " ").split(", ")
        manifest = self.write("pairs.csv", ",".join(["source", "target", *columns]) + "\n")
        done = self.run_command("batch", manifest, "-o", self.path("out"))
        self.assertIn("has no pairs", done.stderr, "every column is known")
        self.assertGreater(len(columns), 10)

    def test_examples_run(self):
        points = surface()
        scans = [[moved(motion(2 * i, (0.02 * i, -0.03 * i, 0.02 * i)), p) for p in points] for i in range(3)]
        for name, scan in [("source", scans[0]), ("target", scans[1])]:
            self.write(f"{name}.pcd", pcd(scan))
            self.write(f"{name}.ply", ply(scan))
        for i, scan in enumerate(scans):
            self.write(f"scan_{i}.pcd", pcd(scan))
        self.write("pairs.csv", "source,target\nsource.pcd,target.pcd\nscan_1.pcd,scan_2.pcd\n")
        path = f"{pathlib.Path(COMMAND).parent}:{os.environ['PATH']}"
        for command in COMMANDS:
            lines = examples(self.succeed(command, "--help"))
            self.assertEqual(len(lines), 3, command)
            for line in lines:
                with self.subTest(line):
                    done = subprocess.run(["sh", "-c", line], cwd=self.directory, env={**os.environ, "PATH": path},
                                          capture_output=True, text=True, timeout=300)
                    self.assertEqual((done.returncode, done.stderr), (0, ""))
