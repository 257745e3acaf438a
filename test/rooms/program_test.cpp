// Programs: built once per options, and errors that carry the compiler's words.
#include "device_cases.h"
#include "kernel_files.h"
#include "opencl/context.h"
#include "scoped_directory.h"
#include "scoped_environment.h"

#include <pcl_gpu_icp/error.h>

#include <filesystem>

namespace pcl_gpu_icp::test {

using opencl::Context;
using opencl::Shape;

class Program : public OnDevice {
protected:
  Context& context() const { return Context::of(GetParam().device); }

  /// The options of this case's stages, which belong to a later room.
  std::string options() const
  {
    const DeviceCase& device_case = GetParam();
    return std::string("-cl-std=CL1.2") +
           (device_case.traits.shape == Shape::Chunked ? " -DCHUNKED" : " -DWORK_GROUP_SIZE=128") +
           (device_case.precision == Precision::Double ? " -DREAL_IS_DOUBLE" : "");
  }
};

TEST_P(Program, EveryKernelCompilesWithoutAWarning)
{
  for (const std::string& file : kernelFiles())
    EXPECT_NO_THROW(context().program(file, options() + " -Werror")) << file;
}

// A compiler that does not inline must still find every helper: C99's plain `inline` would leave it undefined.
TEST_P(Program, EveryKernelCompilesWithoutOptimisation)
{
  for (const std::string& file : kernelFiles())
    EXPECT_NO_THROW(context().program(file, options() + " -cl-opt-disable")) << file;
}

TEST_P(Program, IsBuiltOnceForTheSameOptions)
{
  EXPECT_EQ(context().program("gather.cl", options())(), context().program("gather.cl", options())());
  EXPECT_NE(context().program("gather.cl", options())(), context().program("gather.cl", options() + " -DOTHER")());
}

TEST_P(Program, ABrokenKernelIsReportedWithFileOptionsAndLog)
{
  const ScopedDirectory directory;
  directory.write("broken.cl", "kernel void broken(global float* a)\n{\n  a[0] = not_declared;\n}\n");
  const ScopedEnvironment environment("PCL_GPU_ICP_KERNEL_DIR", directory.path());
  const std::string wanted = options() + " -DBROKEN";
  try {
    context().program("broken.cl", wanted);
    FAIL() << "nothing was thrown";
  } catch (const KernelBuildError& error) {
    EXPECT_EQ(error.kernel(), "broken.cl");
    EXPECT_EQ(error.options(), wanted);
    EXPECT_NE(error.log().find("not_declared"), std::string::npos) << error.log();
    EXPECT_NE(error.log().find("broken.cl"), std::string::npos) << error.log();
    EXPECT_EQ(error.device(), GetParam().device.info().name);
    EXPECT_EQ(error.code(), CL_BUILD_PROGRAM_FAILURE);
    EXPECT_NE(std::string(error.what()).find("not_declared"), std::string::npos) << error.what();
  }
}

TEST_P(Program, IsTriedAgainAfterAFailure)
{
  const ScopedDirectory directory;
  const ScopedEnvironment environment("PCL_GPU_ICP_KERNEL_DIR", directory.path());
  const std::string wanted = options() + " -DTRY_" + GetParam().name();
  EXPECT_THROW(context().program("late.cl", wanted), InvalidArgument);
  directory.write("late.cl", "kernel void late() {\n");
  EXPECT_THROW(context().program("late.cl", wanted), KernelBuildError);
  directory.write("late.cl", "kernel void late() {}\n");
  EXPECT_NO_THROW(context().program("late.cl", wanted));
}

INSTANTIATE_TEST_SUITE_P(, Program, testing::ValuesIn(wholeCases()), nameOf<DeviceCase>);

TEST(Context, IsOnePerDevice)
{
  for (const Device& device : Device::list())
    EXPECT_EQ(&Context::of(device), &Context::of(Device(device)));
}

} // namespace pcl_gpu_icp::test
