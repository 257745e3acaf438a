"""What bash and zsh complete."""

import re
import shlex
import shutil
import subprocess

from manual import COMMANDS, FOLDER, ManualTest


class Bash(ManualTest):
    def setUp(self):
        super().setUp()
        self.write("source.pcd", "")
        self.write("two words.pcd", "")
        (self.directory / "scans").mkdir()

    def complete(self, *words):
        """What the last word may become."""
        script = (f"source {shlex.quote(str(FOLDER / 'pcl_gpu_icp'))}; COMP_WORDS=({shlex.join(['pcl_gpu_icp', *words])}); "
                  "COMP_CWORD=$((${#COMP_WORDS[@]} - 1)); "
                  "$(complete -p pcl_gpu_icp | sed 's/.*-F \\([^ ]*\\) .*/\\1/'); printf '%s\\n' \"${COMPREPLY[@]}\"")
        done = subprocess.run(["bash", "-c", script], cwd=self.directory, capture_output=True, text=True, check=True)
        self.assertEqual(done.stderr, "")
        return sorted(done.stdout.split("\n")[:-1]) if done.stdout != "\n" else []

    def test_commands(self):
        self.assertEqual(self.complete(""), sorted([*COMMANDS, "-h", "--help", "--version"]))
        self.assertEqual(self.complete("al"), ["align"])

    def test_every_option(self):
        for command in COMMANDS:
            self.assertEqual(set(self.complete(command, "-")), self.options(command))
        self.assertEqual(self.complete("align", "a.pcd", "b.pcd", "--max-d"), ["--max-distance"])

    def test_words_that_an_option_takes(self):
        self.assertEqual(self.complete("align", "--metric", ""), ["gicp", "plane", "point", "symmetric"])
        self.assertEqual(self.complete("align", "--metric", "=", "p"), ["plane", "point"])
        self.assertEqual(self.complete("align", "--metric", "="), ["gicp", "plane", "point", "symmetric"])
        self.assertEqual(self.complete("align", "--loss", "ca"), ["cauchy"])
        self.assertEqual(self.complete("batch", "--policy", "f"), ["fifo"])
        self.assertEqual(self.complete("compare", "--device", ""), ["accelerator", "cpu", "gpu"])
        self.assertEqual(self.complete("align", "--iterations", ""), [])

    def test_files(self):
        files = ["scans", "source.pcd", "two words.pcd"]
        for words in (["align", ""], ["align", "-o", ""], ["align", "--report", ""], ["batch", ""]):
            self.assertEqual(self.complete(*words), files)
        self.assertEqual(self.complete("align", "--guess", ""), sorted([*files, "auto"]))
        self.assertEqual(self.complete("batch", "-o", ""), ["scans"])
        self.assertEqual(self.complete("devices", ""), [])


class Zsh(ManualTest):
    FILE = FOLDER / "_pcl_gpu_icp"

    def test_every_option(self):
        text = self.FILE.read_text()
        for command in COMMANDS:
            section = text.partition(f"  {command})\n")[2].partition(";;\n")[0]
            names = set(re.findall(r"^ +'(?:\*|\([^)]*\))(-[\w-]+)=?\[", section, re.MULTILINE))
            self.assertEqual(names, self.options(command))

    def complete(self, line):
        """What a terminal shows where tab is pressed."""
        self.write("complete.zsh", f"""
            zmodload zsh/zpty
            zpty shell 'TERM=dumb PS1= zsh -f -i'
            zpty -w shell 'unsetopt zle_bracketed_paste; fpath=({shlex.quote(str(FOLDER))} $fpath)'
            zpty -w shell 'autoload -U compinit; compinit -u -d {self.path("dump")}; cd {self.directory}; print READY'
            zpty -r shell seen '*READY*READY*'
            zpty -w -n shell {shlex.quote(line)}$'\\t\\t'
            sleep 1
            while zpty -r -t shell seen; do print -rn -- $seen; done
            zpty -d shell
        """)
        done = subprocess.run(["zsh", "-f", self.path("complete.zsh")], capture_output=True, text=True, timeout=60)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        return done.stdout

    def test_on_a_terminal(self):
        if not shutil.which("zsh"):
            self.skipTest("zsh is not installed")
        self.write("source.pcd", "")
        for line, words in {
            "pcl_gpu_icp ": COMMANDS,
            "pcl_gpu_icp align --metric ": ["gicp", "plane", "point", "symmetric"],
            "pcl_gpu_icp align --metric=": ["gicp", "plane", "point", "symmetric"],
            "pcl_gpu_icp align so": ["source.pcd"],
            "pcl_gpu_icp align -o so": ["source.pcd"],
            "pcl_gpu_icp align --guess ": ["auto", "source.pcd"],
            "pcl_gpu_icp batch --re": ["--report", "--resume", "--reciprocal"],
        }.items():
            with self.subTest(line):
                seen = self.complete(line)
                for word in words:
                    self.assertIn(word, seen)
