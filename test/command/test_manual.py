"""The manual page."""

import re
import shutil
import subprocess

from manual import COMMANDS, FOLDER, ManualTest

PAGE = FOLDER / "pcl_gpu_icp.1"


class ManualPage(ManualTest):
    def test_every_option_is_there(self):
        text = PAGE.read_text()
        for command in COMMANDS:
            section = text.partition(f'.SH "{command}"\n')[2].partition("\n.SH ")[0].replace("\\-", "-")
            described = re.findall(r"^\.TP\n(.*)\n(.+)$", section, re.MULTILINE)
            names = {name for names, _ in described for name in re.findall(r"\\fB(-[\w-]+)\\fR", names)}
            self.assertEqual(names, self.options(command))

    def test_it_is_in_order(self):
        checks = [check for check in (["man", "--warnings", "-l"], ["groff", "-man", "-ww", "-z"],
                                      ["mandoc", "-Tlint", "-Wwarning"]) if shutil.which(check[0])]
        if not checks:
            self.skipTest("none of man, groff and mandoc is installed")
        for check in checks:
            done = subprocess.run([*check, PAGE], capture_output=True, text=True, env={"PATH": "/usr/bin:/bin",
                                                                                       "MANWIDTH": "80"})
            self.assertEqual((done.returncode, done.stderr), (0, ""), check)
            if check[0] == "mandoc":
                self.assertEqual(done.stdout, "")

    def test_what_a_reader_sees(self):
        if not shutil.which("man"):
            self.skipTest("man is not installed")
        seen = subprocess.run(["man", "-l", PAGE], capture_output=True, text=True, check=True,
                              env={"PATH": "/usr/bin:/bin", "MANWIDTH": "100", "LC_ALL": "C"}).stdout
        for text in ("pcl_gpu_icp align [OPTIONS] SOURCE TARGET", "Common options", "--max-distance DISTANCE",
                     "pcl_gpu_icp batch --sequence 'scan_*.pcd' -o trajectory", "\\\n", "Exit status: 0 converged"):
            self.assertIn(text, seen)
