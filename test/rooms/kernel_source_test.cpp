// Kernel sources: embedded, or read from the directory that a developer names.
#include "opencl/kernel_source.h"

#include "kernel_files.h"
#include "scoped_directory.h"
#include "scoped_environment.h"

#include <pcl_gpu_icp/error.h>

#include <gtest/gtest.h>

#include <filesystem>
#include <sstream>

namespace pcl_gpu_icp::test {

using opencl::kernelSource;

namespace {

std::size_t occurrences(const std::string& text, const std::string& part)
{
  std::size_t count = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1))
    ++count;
  return count;
}

std::string withoutComments(const std::string& source)
{
  std::istringstream lines(source);
  std::string text, line;
  while (std::getline(lines, line))
    text += line.substr(0, line.find("//")) + "\n";
  return text;
}

} // namespace

TEST(KernelSource, IsEmbeddedForEveryKernel)
{
  for (const std::string& file : kernelFiles())
    EXPECT_NE(kernelSource(file).find("kernel void"), std::string::npos) << file;
}

TEST(KernelSource, DoesNotDependOnTheWorkingDirectory)
{
  const std::string here = kernelSource("svd.cl");
  const auto before = std::filesystem::current_path();
  const ScopedDirectory elsewhere;
  std::filesystem::current_path(elsewhere.path());
  EXPECT_EQ(kernelSource("svd.cl"), here);
  std::filesystem::current_path(before);
}

TEST(KernelSource, TakesEachHeaderInOnce)
{
  for (const std::string& file : kernelFiles()) {
    const std::string source = kernelSource(file);
    EXPECT_EQ(occurrences(source, "#define POINTS_PER_BLOCK"), 1U) << file;
    EXPECT_EQ(occurrences(source, "#include"), 0U) << file;
  }
}

TEST(KernelSource, AsksOnlyForWhatIsTheSameInPasses)
{
  for (const std::string& file : kernelFiles())
    for (const char* of_the_pass : {"get_group_id(", "get_num_groups(", "get_global_size(", "get_global_offset("})
      EXPECT_EQ(occurrences(withoutComments(kernelSource(file)), of_the_pass), 0U) << file << ": " << of_the_pass;
}

TEST(KernelSource, CompilerMessagesNameFileAndLine)
{
  const ScopedDirectory directory;
  directory.write("a.cl", "// a\n#include \"b.h\"\nline three\n");
  directory.write("b.h", "line one\n");
  const ScopedEnvironment environment("PCL_GPU_ICP_KERNEL_DIR", directory.path());
  EXPECT_EQ(kernelSource("a.cl"), "#line 1 \"a.cl\"\n// a\n#line 1 \"b.h\"\nline one\n#line 3 \"a.cl\"\nline three\n");
}

TEST(KernelSource, AMissingFileIsNamedWithItsDirectory)
{
  const ScopedDirectory directory;
  const ScopedEnvironment environment("PCL_GPU_ICP_KERNEL_DIR", directory.path());
  try {
    kernelSource("svd.cl");
    FAIL() << "nothing was thrown";
  } catch (const InvalidArgument& error) {
    const std::string what = error.what();
    EXPECT_NE(what.find(directory.path() + "/svd.cl"), std::string::npos) << what;
    EXPECT_NE(what.find("PCL_GPU_ICP_KERNEL_DIR"), std::string::npos) << what;
  }
}

TEST(KernelSource, AnEmptyDirectoryVariableIsAsGoodAsNone)
{
  const ScopedEnvironment environment("PCL_GPU_ICP_KERNEL_DIR", "");
  EXPECT_NO_THROW(kernelSource("svd.cl"));
}

TEST(KernelSource, AnUnknownNameIsRefused) { EXPECT_THROW(kernelSource("no_such_kernel.cl"), InvalidArgument); }

} // namespace pcl_gpu_icp::test
