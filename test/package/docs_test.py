#!/usr/bin/env python3
"""docs_test.py PREFIX FOLDER SCANS: what README and the pages of docs/ show, done in FOLDER with what is installed in PREFIX:
commands run on the scans in SCANS and print what is shown, C++ compiles, Python runs, and the CMake project builds as it stands
and in the variants that are named beside it. Blocks of `sh` install or download and are not run."""

import importlib.util
import os
import pathlib
import re
import shutil
import subprocess
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).parent / "docs"))
from blocks import PAGES, ROOT, blocks, commands
from output import differences

PREFIX, FOLDER, SCANS = (pathlib.Path(argument).resolve() for argument in sys.argv[1:4])
ENVIRONMENT = {**os.environ, "PATH": f"{PREFIX}/bin:{os.environ['PATH']}"}

MAIN = """
int main()
{
  pcl::PointCloud<pcl::PointXYZ>::Ptr source(new pcl::PointCloud<pcl::PointXYZ>), target = source;
  for (int i = 0; i < 100; ++i)
    source->emplace_back(0.1F * i, 0.01F * i * i, 0.001F * i * i * i);
  READ
  pcl::PointCloud<pcl::PointXYZ> aligned;
  LINES
  return icp.hasConverged() && aligned.size() == 100 ? 0 : 1;
}
"""
READ = """pcl::io::savePCDFile("cloud.pcd", *source);
  pcl::io::loadPCDFile("cloud.pcd", *source);"""

# What the pages take as given where they show lines of a program.
GIVEN = """#include <pcl_gpu_icp/icp.h>

#include <iostream>
#include <vector>

using Cloud = pcl::PointCloud<pcl::PointXYZ>;
void use(const Eigen::Matrix4f&);
"""
FUNCTION = """void NAME(Cloud::Ptr source, Cloud::Ptr target, Cloud::Ptr map, std::vector<Cloud::Ptr> scans, Cloud aligned,
  Eigen::Matrix4f guess, pcl_gpu_icp::RigidTransform pose, pcl_gpu_icp::IterativeClosestPoint<pcl::PointXYZ, pcl::PointXYZ> icp)
{
  {
#line LINE "PAGE"
BODY
  }
}
"""
PEERS = ("small_gicp",)  # compiled where they are installed


def run(command, folder):
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    if done.returncode:
        raise AssertionError(f"{command}:\n{done.stdout}{done.stderr}")


class Project(unittest.TestCase):
    page = ROOT / "docs/in-a-program.md"
    project = next(text for _, text in blocks(page, "cmake"))

    def build(self, name, project, with_io=True):
        folder = FOLDER / name
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
        (folder / "CMakeLists.txt").write_text(project)
        include, lines = next(text for _, text in blocks(ROOT / "README.md", "cpp")).split("\n", 1)
        if with_io:
            include = "#include <pcl/io/pcd_io.h>\n" + include
        main = MAIN.replace("READ", READ if with_io else "").replace("LINES", lines)
        (folder / "my_program.cpp").write_text(include + main)
        for command in (["cmake", "-B", "build", f"-DCMAKE_PREFIX_PATH={PREFIX}"], ["cmake", "--build", "build"],
                        ["build/my_program"]):
            run(command, folder)

    def test_as_it_stands(self):
        self.build("as_it_stands", self.project)

    def test_pcl_found_after(self):
        lines = self.project.splitlines(keepends=True)
        pcl = next(i for i, line in enumerate(lines) if line.startswith("find_package(PCL"))
        self.assertTrue(lines[pcl + 1].startswith("find_package(pcl_gpu_icp"))
        lines[pcl], lines[pcl + 1] = lines[pcl + 1], lines[pcl]
        self.build("pcl_found_after", "".join(lines))

    def test_without_io(self):
        lines = [line for line in self.project.splitlines(keepends=True) if not line.startswith("find_package(PCL")]
        project = "".join(lines).replace(" C CXX", " CXX").replace(" ${PCL_LIBRARIES}", "")
        self.build("without_io", project, with_io=False)


class Cpp(unittest.TestCase):
    """All blocks in one translation unit, a function each: most of the time goes into PCL's templates, once."""

    @staticmethod
    def function(page, line, text):
        body = [row if not row.startswith("#include") else "" for row in text.splitlines()]
        values = {"NAME": f"{re.sub(r'[^a-z]', '_', page.stem.lower())}_{line}", "LINE": str(line), "PAGE": page.name,
                  "BODY": "\n".join(body)}
        return re.sub("NAME|LINE|PAGE|BODY", lambda match: values[match[0]], FUNCTION)

    def source(self):
        includes, functions = [], []
        for page in PAGES:
            for line, text in blocks(page, "cpp"):
                headers = re.findall(r"^#include <(.*)>", text, re.MULTILINE)
                function = self.function(page, line, text)
                peers = [header for header in headers if header.startswith(PEERS)]
                for header in headers:
                    guard = f"#if __has_include(<{header}>)\n" if header in peers else ""
                    includes.append(f"{guard}#include <{header}>\n" + ("#endif\n" if guard else ""))
                for header in peers:
                    function = (f"#if __has_include(<{header}>)\n{function}#else\n"
                                f'#pragma message "not compiled, for want of {header}: {page.name}:{line}"\n#endif\n')
                functions.append(function)
        return GIVEN + "".join(dict.fromkeys(includes)) + "\n" + "\n".join(functions)

    def test_compiles(self):
        folder = FOLDER / "cpp"
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
        (folder / "blocks.cpp").write_text(self.source())
        (folder / "CMakeLists.txt").write_text(
            "cmake_minimum_required(VERSION 3.18)\nproject(blocks C CXX)\nfind_package(PCL 1.12 REQUIRED COMPONENTS io features)\n"
            "find_package(pcl_gpu_icp REQUIRED)\nadd_library(blocks SHARED blocks.cpp)\n"
            "target_link_libraries(blocks pcl_gpu_icp::pcl_gpu_icp ${PCL_LIBRARIES})\n")
        run(["cmake", "-B", "build", f"-DCMAKE_PREFIX_PATH={PREFIX}"], folder)
        run(["cmake", "--build", "build"], folder)


@unittest.skipUnless(SCANS.is_dir(), f"the scans of the pages are not in {SCANS}: no command was run")
class Commands(unittest.TestCase):
    """Those of a page run one after another in a folder that has the scans."""

    def test_prints_what_is_shown(self):
        for page in PAGES:
            folder = FOLDER / "pages" / page.stem
            shutil.rmtree(folder, ignore_errors=True)
            folder.mkdir(parents=True)
            for scan in SCANS.iterdir():
                (folder / scan.name).symlink_to(scan)
            for line, block in blocks(page, "console"):
                for command, shown in commands(block):
                    with self.subTest(page=page.name, line=line, command=command):
                        self.check(command, shown, folder)

    def check(self, command, shown, folder):
        if command.startswith("cat ") and not (folder / command.split()[1]).exists():
            (folder / command.split()[1]).write_text("\n".join(shown) + "\n")  # a file that the page shows
        done = subprocess.run(["bash", "-c", command], cwd=folder, env=ENVIRONMENT, stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, text=True)
        fails = any(re.match("pcl_gpu_icp: (?!warning)", row) for row in shown)
        self.assertEqual(bool(done.returncode), fails, done.stdout)
        self.assertEqual(differences(shown, done.stdout.splitlines()), [], done.stdout)

    def test_python_runs(self):
        for page in PAGES:
            for line, block in blocks(page, "python"):
                modules = re.findall(r"^import (\w+)", block, re.MULTILINE)
                missing = [module for module in modules if not importlib.util.find_spec(module)]
                with self.subTest(page=page.name, line=line):
                    if missing:
                        print(f"not run, for want of {', '.join(missing)}: {page.name}:{line}", file=sys.stderr)
                        continue
                    done = subprocess.run([sys.executable, "-c", block], cwd=SCANS, env=ENVIRONMENT, capture_output=True, text=True)
                    self.assertEqual(done.returncode, 0, done.stderr)


class Scripts(unittest.TestCase):
    def test_those_named_are_there(self):
        for page in PAGES:
            for name in re.findall(r"\bscripts/[\w-]+(?:\.py)?", page.read_text()):
                with self.subTest(page=page.name, script=name):
                    self.assertTrue((ROOT / name).is_file() and (name.endswith(".py") or os.access(ROOT / name, os.X_OK)))


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
