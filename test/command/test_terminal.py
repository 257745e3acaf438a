"""A live line per iteration on a terminal, and nothing of the kind in a pipe."""

import os

from command import CommandTest, motion, moved, pcd, surface

POINTS = surface()
TARGET = [moved(motion(3, (0.05, -0.08, 0.04)), point) for point in POINTS]


class Terminal(CommandTest):
    def setUp(self):
        super().setUp()
        self.arguments = ["align", self.write("source.pcd", pcd(POINTS)), self.write("target.pcd", pcd(TARGET))]

    def test_live_line(self):
        text, seen = self.on_terminal(*self.arguments)
        self.assertIn("\rreading source.pcd\x1b[K\rreading target.pcd\x1b[K\r\x1b[K", seen)
        self.assertIn("\riteration 1  RMSE ", seen)
        self.assertIn("\riteration 2  RMSE ", seen)
        self.assertNotIn("\n", seen)
        self.assertTrue(seen.endswith("\r\x1b[K"), "the line is gone in the end")
        self.assertIn("converged", text)
        self.assertNotIn("\r", text)

    def test_quiet_terminal(self):
        self.assertEqual(self.on_terminal(*self.arguments, "--quiet"), ("", ""))

    def test_pipe(self):
        done = self.run_command(*self.arguments)
        self.assertEqual(done.stderr, "")
        self.assertNotIn("\r", done.stdout)
        self.assertNotIn("iteration 1 ", done.stdout)

    def test_the_verdict_is_coloured_on_a_terminal_only(self):
        arguments = [*self.arguments, "--once"]
        _, seen = self.on_terminal(*arguments, stdout_too=True)
        self.assertIn("verdict    \x1b[1;32mgood\x1b[0m\r\n", seen)
        text, _ = self.on_terminal(*arguments)
        self.assertIn("verdict    good\n", text)
        os.environ["NO_COLOR"] = "1"
        self.addCleanup(os.environ.pop, "NO_COLOR")
        _, seen = self.on_terminal(*arguments, stdout_too=True)
        self.assertIn("verdict    good\r\n", seen)
