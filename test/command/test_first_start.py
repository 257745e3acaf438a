"""The first start, where the kernels are still to be compiled: nothing but the result is printed, any place for them is
made the best of, and a signal ends it."""

import os
import pathlib
import resource
import signal
import subprocess
import time
from unittest import mock

from command import COMMAND, DEVICE, CommandTest, motion, moved, pcd, surface

POINTS = surface()


class FirstStart(CommandTest):
    def setUp(self):
        super().setUp()
        self.source = self.write("source.pcd", pcd(POINTS))
        self.target = self.write("target.pcd", pcd([moved(motion(3, (0.05, -0.08, 0.04)), p) for p in POINTS]))
        self.pair = (self.source, self.target)
        # PoCL alone, and only the places that a test sets: others are for other tests.
        environment = mock.patch.dict(os.environ, OCL_ICD_VENDORS="/etc/OpenCL/vendors/pocl.icd")
        environment.start()
        self.addCleanup(environment.stop)
        for name in ("POCL_CACHE_DIR", "XDG_CACHE_HOME", "POCL_KERNEL_CACHE"):
            os.environ.pop(name, None)


class Quiet(FirstStart):
    def test_nothing_but_the_result_is_printed(self):
        """Of each kernel: every search, metric and pipeline, in double and in float precision."""
        cache = {"POCL_CACHE_DIR": self.path("cache")}
        for arguments in ((), ("--search", "device"), ("--metric", "plane"), ("--pipeline", "staged")):
            printed = self.succeed("align", *self.pair, *arguments, environment=cache)
            self.assertTrue(printed.startswith("verdict "), printed)
        self.assertTrue(self.succeed("compare", *self.pair, "--metric", "plane", environment=cache).startswith("source "))
        self.assertTrue(os.listdir(self.path("cache")), "the kernels were compiled")


class Terminal(FirstStart):
    """A terminal is told what takes so long, at the first start only."""

    COMPILING = r"\rcompiling kernels for this device, once: \d+ s\x1b\[K"

    def test_align_and_compare(self):
        for command in ("align", "compare"):
            os.environ["POCL_CACHE_DIR"] = self.path(command)
            _, seen = self.on_terminal(command, *self.pair)
            self.assertRegex(seen, self.COMPILING)
            self.assertTrue(seen.endswith("\r\x1b[K"), "the line is gone in the end")
            _, seen = self.on_terminal(command, *self.pair)
            self.assertNotIn("compiling", seen)

    def test_a_batch_shows_its_bar_again(self):
        os.environ["POCL_CACHE_DIR"] = self.path("batch")
        manifest = self.write("pairs.csv", "source,target\nsource.pcd,target.pcd\n")
        _, seen = self.on_terminal("batch", manifest, "-o", self.path("out"), stdout_too=True)
        self.assertRegex(seen, self.COMPILING + r"(?s:.*)\r\[#{24}\] 1/1")

    def test_quiet(self):
        os.environ["POCL_CACHE_DIR"] = self.path("quiet")
        self.assertEqual(self.on_terminal("align", *self.pair, "--quiet"), ("", ""))


class Folder(FirstStart):
    """Where PoCL keeps the kernels. For root, too, nothing can be made below a file."""

    def test_without_a_home_the_user_has_one_in_the_temporary_folder(self):
        os.mkdir(self.path("tmp"))
        private = pathlib.Path(self.path("tmp"), f"pcl_gpu_icp-{os.geteuid()}")
        for home in ("/dev/null/home", ""):
            self.succeed("align", *self.pair, environment={"HOME": home, "TMPDIR": self.path("tmp")})
            self.assertEqual(private.stat().st_mode & 0o777, 0o700)
            kernels = sorted(path for path in private.rglob("*.so"))
            self.assertTrue(kernels)
        compiled = [path.stat().st_mtime_ns for path in kernels]
        self.succeed("align", *self.pair, environment={"HOME": home, "TMPDIR": self.path("tmp")})
        self.assertEqual([path.stat().st_mtime_ns for path in kernels], compiled, "they are found again")

    def test_where_there_is_none_it_says_what_to_do(self):
        nowhere = {"HOME": "/dev/null/home", "TMPDIR": self.path("")}
        self.write(f"pcl_gpu_icp-{os.geteuid()}", "in the way")
        self.fail_with(DEVICE, "align", *self.pair, environment=nowhere,
                       names=["/dev/null/home", self.path(f"pcl_gpu_icp-{os.geteuid()}"), "set POCL_CACHE_DIR"])

    def test_what_the_user_says_is_named(self):
        for name in ("POCL_CACHE_DIR", "XDG_CACHE_HOME"):
            self.fail_with(DEVICE, "align", *self.pair, environment={name: "/dev/null/cache"},
                           names=["/dev/null/cache", name, "set POCL_CACHE_DIR"])

    def test_one_that_cannot_be_written(self):
        os.mkdir(self.path("read only"))
        os.chmod(self.path("read only"), 0o555)
        os.environ["POCL_CACHE_DIR"] = self.path("read only")
        self.addCleanup(os.environ.pop, "POCL_CACHE_DIR")
        done = self.run_as_nobody("align", *self.pair)
        self.assertEqual(done.returncode, DEVICE, done)
        self.assertIn(self.path("read only"), done.stderr)
        self.assertIn("Permission denied", done.stderr)

    def test_one_without_room(self):
        self.fail_with(DEVICE, "align", *self.pair, environment={"POCL_CACHE_DIR": self.path("cache")},
                       names=[self.path("cache"), "ulimit -f"],
                       preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (65536, 65536)))
        small = self.path("small")
        os.mkdir(small)
        if subprocess.run(["mount", "-t", "tmpfs", "-o", "size=64k", "none", small], capture_output=True).returncode != 0:
            self.skipTest("cannot mount a small file system")
        self.addCleanup(subprocess.run, ["umount", small], check=True)
        self.fail_with(DEVICE, "align", *self.pair, environment={"POCL_CACHE_DIR": small},
                       names=[small, "No space left on device"])
        # In the home it is nobody's wish.
        os.mkdir(self.path("tmp"))
        self.succeed("align", *self.pair, environment={"HOME": small, "TMPDIR": self.path("tmp")})


class Interrupted(FirstStart):
    def start(self, *arguments):
        """Returns when the command has taken the signals over, which it does before all else."""
        self.starts = getattr(self, "starts", 0) + 1
        process = subprocess.Popen(
            [COMMAND, *arguments], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
            env={**os.environ, "POCL_CACHE_DIR": self.path(f"cache {self.starts}")}, start_new_session=True)
        both = 1 << (signal.SIGINT - 1) | 1 << (signal.SIGTERM - 1)
        while True:
            status = pathlib.Path(f"/proc/{process.pid}/status").read_text()
            held_back = int(status.split("SigBlk:")[1].split()[0], 16)
            if held_back & both == both:
                return process
            self.assertIsNone(process.poll(), "ended by itself")
            time.sleep(0.001)

    def test_ends_at_any_moment_and_leaves_nothing(self):
        files = set(os.listdir(self.directory))
        for command in (
            ("align", *self.pair, "-o", self.path("aligned.pcd"), "--json", self.path("a.json")),
            ("compare", *self.pair, "--json", self.path("c.json")),
        ):
            for i, delay in enumerate((0, 0.1, 0.2, 0.4, 0.8)):
                number, code = ((signal.SIGINT, 130), (signal.SIGTERM, 143))[i % 2]
                with self.subTest(command[0], delay=delay):
                    process = self.start(*command)
                    time.sleep(delay)
                    os.killpg(process.pid, number)  # as a terminal does, also to the programs that PoCL runs
                    self.assertEqual((*process.communicate(timeout=60), process.returncode), ("", "", code))
                    left = {name for name in os.listdir(self.directory) if not name.startswith("cache ")}
                    self.assertEqual(left, files)

    def test_a_batch_without_a_result_can_be_begun_again(self):
        manifest = self.write("pairs.csv", "source,target\nsource.pcd,target.pcd\n")
        batch = ("batch", manifest, "-o", self.path("out"), "--quiet")
        for delay in (0, 0.3):
            for resume in ((), ("--resume",)):
                process = self.start(*batch, *resume)
                time.sleep(delay)
                process.send_signal(signal.SIGINT)
                output, errors = process.communicate(timeout=60)
                self.assertEqual((output, process.returncode), ("", 130), errors)
                if errors:  # none where not even the manifest had been read
                    self.assertEqual(errors, "pcl_gpu_icp: interrupted with 1 of 1 pairs left; --resume goes on\n")
        self.succeed(*batch)
