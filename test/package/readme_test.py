#!/usr/bin/env python3
"""readme_test.py PREFIX FOLDER: builds in FOLDER the CMake project and the lines of C++ that README shows, as they stand
and in the variants that it names, with what is installed in PREFIX, and runs the program."""

import pathlib
import re
import shutil
import subprocess
import sys
import unittest

PREFIX, FOLDER = map(pathlib.Path, sys.argv[1:3])
README = (pathlib.Path(__file__).resolve().parents[2] / "README.md").read_text()

MAIN = """
int main()
{
  pcl::PointCloud<pcl::PointXYZ>::Ptr cloud(new pcl::PointCloud<pcl::PointXYZ>);
  for (int i = 0; i < 100; ++i)
    cloud->emplace_back(0.1F * i, 0.01F * i * i, 0.001F * i * i * i);
  READ
  icp.setInputSource(cloud);
  icp.setInputTarget(cloud);
  pcl::PointCloud<pcl::PointXYZ> aligned;
  icp.align(aligned);
  return icp.hasConverged() && aligned.size() == 100 ? 0 : 1;
}
"""
READ = """pcl::io::savePCDFile("cloud.pcd", *cloud);
  pcl::io::loadPCDFile("cloud.pcd", *cloud);"""


def block(language, start):
    """The block of README in that language that starts so."""
    blocks = re.findall(rf"^```{language}\n(.*?)^```$", README, re.MULTILINE | re.DOTALL)
    return next(text for text in blocks if text.startswith(start))


class ReadmeProject(unittest.TestCase):
    project = block("cmake", "cmake_minimum_required")

    def build(self, name, project, with_io=True):
        folder = FOLDER / name
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
        (folder / "CMakeLists.txt").write_text(project)
        includes = block("cpp", "#include <pcl_gpu_icp/icp.h>")
        if with_io:
            includes = "#include <pcl/io/pcd_io.h>\n" + includes
        (folder / "my_program.cpp").write_text(includes + MAIN.replace("READ", READ if with_io else ""))
        for command in (["cmake", "-B", "build", f"-DCMAKE_PREFIX_PATH={PREFIX}"], ["cmake", "--build", "build"],
                        ["build/my_program"]):
            done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
            self.assertEqual(done.returncode, 0, f"{command}:\n{done.stdout}{done.stderr}")

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


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
