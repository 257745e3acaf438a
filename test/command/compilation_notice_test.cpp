// What is said while kernels are compiled, where stderr is no terminal. test_first_start.py has the terminal.
#include "cli/compilation_notice.h"

#include <gtest/gtest.h>

namespace pcl_gpu_icp::cli {
namespace {

using std::chrono::milliseconds;

std::string saidWithin(milliseconds time, CompilationNotice::Patience patience, bool wanted, bool compiles)
{
  testing::internal::CaptureStderr();
  {
    LiveLine line(false);
    const CompilationNotice notice(line, wanted, patience, [compiles] { return compiles; });
    std::this_thread::sleep_for(time);
  }
  return testing::internal::GetCapturedStderr();
}

constexpr CompilationNotice::Patience impatient{milliseconds(1), milliseconds(5)};

TEST(CompilationNotice, SaysOnceWhatTakesLong)
{
  EXPECT_EQ(saidWithin(milliseconds(200), impatient, true, true),
            "pcl_gpu_icp: compiling kernels for this device, once: later starts do without\n");
}

TEST(CompilationNotice, SaysNothingOfWhatIsQuick)
{
  EXPECT_EQ(saidWithin(milliseconds(50), {milliseconds(1), milliseconds(60000)}, true, true), "");
  EXPECT_EQ(saidWithin(milliseconds(50), impatient, true, false), "");
}

TEST(CompilationNotice, SaysNothingWhereNothingIsWanted)
{
  EXPECT_EQ(saidWithin(milliseconds(50), impatient, false, true), "");
}

TEST(CompilationNotice, EndsAtOnce)
{
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_EQ(saidWithin(milliseconds(0), {milliseconds(60000), milliseconds(60000)}, true, true), "");
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(10));
}

} // namespace
} // namespace pcl_gpu_icp::cli
