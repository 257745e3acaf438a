#pragma once

#include "report/comparison_report.h"

#include <pcl_gpu_icp/normal_estimator.h>

#include <chrono>
#include <functional>
#include <string>
#include <sys/types.h>
#include <variant>

namespace pcl_gpu_icp::cli {

/// Stock PCL in a process of its own, because it may end the process it is in: its search asserts that points are
/// finite, which the answer of a singular system is not. The process is a copy of this one, waits until it is asked and
/// measures its own time.
class StockProcess {
public:
  using Normals = NormalEstimator::Normals;
  using Answer = std::variant<report::Run, std::string>; ///< or why there is none

  /// To be called before OpenCL is used, which does not work in a copy of the process.
  /// \param run called in that process; what it throws is why there is no answer
  /// \throws Failure (Internal) where the system gives no process
  explicit StockProcess(const std::function<report::Run(const Normals&)>& run);
  /// Ends the process, if it has not ended.
  ~StockProcess();
  StockProcess(const StockProcess&) = delete;
  StockProcess& operator=(const StockProcess&) = delete;

  /// Lets it run, once.
  Answer ask(const Normals& normals, std::chrono::duration<double> limit);

private:
  std::string howItEnded();

  pid_t process_ = -1; ///< -1: has ended
  int socket_ = -1;
};

} // namespace pcl_gpu_icp::cli
