// Errors: OpenCL's own names, and messages that say what failed where.
#include "opencl/error.h"

#include <gtest/gtest.h>

#include <string>

namespace pcl_gpu_icp::test {

using opencl::codeName;

TEST(ErrorCode, HasOpenCLsName)
{
  EXPECT_STREQ(codeName(0), "CL_SUCCESS");
  EXPECT_STREQ(codeName(-1), "CL_DEVICE_NOT_FOUND");
  EXPECT_STREQ(codeName(-4), "CL_MEM_OBJECT_ALLOCATION_FAILURE");
  EXPECT_STREQ(codeName(-5), "CL_OUT_OF_RESOURCES");
  EXPECT_STREQ(codeName(-6), "CL_OUT_OF_HOST_MEMORY");
  EXPECT_STREQ(codeName(-11), "CL_BUILD_PROGRAM_FAILURE");
  EXPECT_STREQ(codeName(-54), "CL_INVALID_WORK_GROUP_SIZE");
  EXPECT_STREQ(codeName(-63), "CL_INVALID_GLOBAL_WORK_SIZE");
  EXPECT_STREQ(codeName(-1001), "CL_PLATFORM_NOT_FOUND_KHR");
}

// cl.h numbers its errors -1 to -19 and -30 to -72.
TEST(ErrorCode, EveryOneOfOpenCL12HasAName)
{
  const auto named = [](int code) { return std::string(codeName(code)).rfind("CL_", 0) == 0; };
  for (int code = -1; code >= -19; --code)
    EXPECT_TRUE(named(code)) << code;
  for (int code = -30; code >= -68; --code)
    EXPECT_TRUE(named(code)) << code;
  EXPECT_FALSE(named(-9999));
}

TEST(DeviceError, SaysWhatFailedWhereAndWhatToDo)
{
  const DeviceError error({-5, "clEnqueueNDRangeKernel", "listed_sums", "Some GPU"}, "use a smaller cloud");
  EXPECT_STREQ(error.what(),
               "clEnqueueNDRangeKernel failed with CL_OUT_OF_RESOURCES (-5) for kernel listed_sums on Some GPU: use a "
               "smaller cloud");
  EXPECT_EQ(error.code(), -5);
  EXPECT_STREQ(error.codeName(), "CL_OUT_OF_RESOURCES");
  EXPECT_EQ(error.call(), "clEnqueueNDRangeKernel");
  EXPECT_EQ(error.kernel(), "listed_sums");
  EXPECT_EQ(error.device(), "Some GPU");
}

TEST(DeviceError, LeavesOutWhatIsNotKnown)
{
  EXPECT_STREQ(DeviceError({-36, "clFinish", "", ""}, "").what(),
               "clFinish failed with CL_INVALID_COMMAND_QUEUE (-36)");
  EXPECT_STREQ(DeviceError({}, "nothing matches").what(), "nothing matches");
}

TEST(KernelBuildError, CarriesOptionsAndLog)
{
  const KernelBuildError error({-11, "clBuildProgram", "svd.cl", "Some GPU"}, "-DX", "line 3: oops");
  EXPECT_EQ(error.options(), "-DX");
  EXPECT_EQ(error.log(), "line 3: oops");
  const std::string what = error.what();
  for (const char* part : {"svd.cl", "-DX", "line 3: oops", "CL_BUILD_PROGRAM_FAILURE", "Some GPU"})
    EXPECT_NE(what.find(part), std::string::npos) << part;
}

TEST(Translated, TurnsTheBindingsExceptionIntoADeviceError)
{
  try {
    opencl::translated("Some GPU", "svd", []() { throw cl::Error(CL_OUT_OF_RESOURCES, "clFlush"); });
    FAIL() << "nothing was thrown";
  } catch (const DeviceError& error) {
    EXPECT_EQ(error.code(), CL_OUT_OF_RESOURCES);
    EXPECT_EQ(error.call(), "clFlush");
    EXPECT_EQ(error.kernel(), "svd");
    EXPECT_EQ(error.device(), "Some GPU");
  }
}

} // namespace pcl_gpu_icp::test
