"""Arguments: every wrong one is named in one line, exit 2."""

import os

from command import INPUT, USAGE, CommandTest, numbers, motion, pcd, surface

REFLECTION = "-1 0 0 0  0 1 0 0  0 0 1 0  0 0 0 1".split()
SCALED = "1.1 0 0 0  0 1.1 0 0  0 0 1.1 0  0 0 0 1".split()
PROJECTIVE = "1 0 0 0  0 1 0 0  0 0 1 0  0 0 0.1 1".split()


class Usage(CommandTest):
    def test_version(self):
        self.assertEqual(self.succeed("--version"), f"pcl_gpu_icp {os.environ['PCL_GPU_ICP_VERSION']}\n")

    def test_wrong_arguments(self):
        for arguments, names in [
            ([], "subcommand"),
            (["dance"], "dance"),
            (["align"], "SOURCE"),
            (["align", "a.pcd"], "TARGET"),
            (["align", "a.pcd", "b.pcd", "c.pcd"], "c.pcd"),
            (["align", "a.pcd", "b.pcd", "--bogus"], "--bogus"),
            (["align", "a.pcd", "b.pcd", "--max-distance"], "--max-distance"),
            (["align", "a.pcd", "b.pcd", "-o", "out.xyz"], "out.xyz"),
            (["align", "a.pcd", "b.pcd", "--both", "out.xyz"], "out.xyz"),
            (["align", "a.pcd", "b.pcd", "--search", "magic"], ["--search", "magic"]),
            (["align", "a.pcd", "b.pcd", "--pipeline", "magic"], ["--pipeline", "magic"]),
            (["compare", "a.pcd", "b.pcd", "--tolerance-degrees", "0"], "--tolerance-degrees"),
            (["compare", "a.pcd", "b.pcd", "--tolerance-distance", "-1"], "--tolerance-distance"),
            (["compare", "a.pcd", "b.pcd", "-o", "c.pcd"], "-o"),
            (["devices", "extra"], "extra"),
        ]:
            with self.subTest(arguments):
                self.fail_with(USAGE, *arguments, names=names)

    def test_the_nearest_name_is_proposed(self):
        pair = ["align", "a.pcd", "b.pcd"]
        for arguments, name in [
            ([*pair, "--max-distnace", "3"], "--max-distance"),
            ([*pair, "--max-distnace=3"], "--max-distance"),
            (["align", "--max-distnace", "3", "a.pcd"], "--max-distance"),
            ([*pair, "--Metric", "plane"], "--metric"),
            ([*pair, "--ouput", "c.pcd"], "--output"),
            ([*pair, "--metric", "pont"], "point"),
            ([*pair, "--metric=Plane"], "plane"),
            ([*pair, "--loss", "hubber:0.1"], "huber"),
            (["batch", "m.csv", "-o", "out", "--policy", "fiof"], "fifo"),
            (["compare", "a.pcd", "b.pcd", "--stok-limit", "3"], "--stock-limit"),
            (["--verison"], "--version"),
            # What other programs call it.
            ([*pair, "-q"], "--quiet"),
            ([*pair, "-v"], "--verbose"),
            ([*pair, "--voxel", "0.1"], "--leaf"),
            ([*pair, "--downsample=0.1"], "--leaf"),
            ([*pair, "--init", "guess.txt"], "--guess"),
            ([*pair, "--method", "gicp"], "--metric"),
            (["batch", "m.csv", "-o", "out", "--max-iter", "9"], "--iterations"),
            (["algin", "a.pcd", "b.pcd"], "align"),
        ]:
            with self.subTest(arguments):
                self.fail_with(USAGE, *arguments, names=f"; did you mean {name}? (see --help)")

    def test_none_is_proposed_where_none_is_near(self):
        for arguments, named in [
            (["align", "a.pcd", "b.pcd", "--bogus"], "there is no option --bogus (see"),
            (["align", "a.pcd", "b.pcd", "--metric", "magic"], "magic is not gicp|plane|point|symmetric (see"),
            (["compare", "a.pcd", "b.pcd", "--" + "x" * 100000], "there is no option --xxx"),
            (["dance"], "there is no subcommand dance (see"),
            (["devices", "--voxel", "0.1"], "there is no option --voxel (see"),  # it has no --leaf
            (["align", "a.pcd", "b.pcd", "-k"], "there is no option -k (see"),
        ]:
            self.assertNotIn("did you mean", self.fail_with(USAGE, *arguments, names=named).stderr)

    def test_the_nearest_column_of_a_manifest_is_proposed(self):
        for name, content, proposed in [
            ("a.csv", "source,target,max_distance\n", "max-distance"),
            ("b.csv", "sorce,target\n", "source"),
            ("c.csv", "source,target,metric\na.pcd,b.pcd,pont\n", "point"),
            ("d.jsonl", '{"source": "a.pcd", "target": "b.pcd", "iteratoins": 3}\n', "iterations"),
        ]:
            manifest = self.write(name, content)
            self.fail_with(INPUT, "batch", manifest, "-o", self.path("out"),
                           names=[f"{manifest}:", f"; did you mean {proposed}?"])

    def test_numbers_out_of_range(self):
        for option, values in {
            "--max-distance": ["0", "-1", "nan", "inf", "1e999", "far", "1m", ""],
            "--translation-epsilon": ["-1e-9", "nan"],
            "--rotation-epsilon": ["0", "-1", "181", "nan"],
            "--fitness-epsilon": ["0", "-1", "inf"],
            "--leaf": ["0", "-0.1", "nan"],
            "--trim": ["0", "1.01", "-0.5", "nan"],
            "--iterations": ["0", "-3", "1.5", "many", "99999999999"],
            "--threads": ["0", "-1", "2.5", "99999"],
        }.items():
            for value in values:
                with self.subTest(option=option, value=value):
                    self.fail_with(USAGE, "align", "a.pcd", "b.pcd", f"{option}={value}", names=option)

    def test_guess_that_is_no_rigid_transform(self):
        cloud = self.write("a.pcd", pcd(surface()))
        for guess in (
            ["1"], ["1", "2", "3"], numbers(motion(10, (1, 2, 3)))[:15], ["nan"] * 16, ["inf"] * 16, ["0"] * 16,
            REFLECTION, SCALED, PROJECTIVE):
            with self.subTest(guess):
                self.fail_with(USAGE, "align", cloud, cloud, "--guess", *guess, names="--guess")

    def test_leaf_too_small_for_the_coordinates(self):
        cloud = self.write("a.pcd", pcd([(9e17, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)]))
        self.fail_with(USAGE, "align", cloud, cloud, "--leaf", "0.001", names=["--leaf", cloud])
