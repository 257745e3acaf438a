#pragma once

#include <pcl_gpu_icp/export.h>

#include <cstddef>
#include <mutex>
#include <string>
#include <vector>

namespace pcl_gpu_icp {

/// Which of those that wait is next.
enum class Policy {
  SmallestFirst,        ///< the smallest request
  FirstComeFirstServed, ///< the oldest request
  LargestFirst,         ///< the largest request
};

PCL_GPU_ICP_API const char* toString(Policy policy);

/// What ran where and when, recorded while a batch runs. Thread-safe. What there is no memory for is left out.
class PCL_GPU_ICP_API Schedule {
public:
  /// A stretch of time of a lane. Lanes are numbered from 0 on each device.
  struct Span {
    std::size_t device = 0;
    std::size_t lane = 0;
    std::size_t pair = 0;       ///< as BatchAligner::add numbered it
    std::string what;           ///< "pair", or the operation that the device ran
    std::size_t work_items = 0; ///< granted; 0 for "pair"
    double begin_ms = 0;        ///< since the batch began
    double end_ms = 0;
  };

  /// What a device had at an instant.
  struct Level {
    std::size_t device = 0;
    double at_ms = 0;
    std::size_t idle = 0;    ///< work-items
    std::size_t waiting = 0; ///< requests
  };

  void add(Span span) noexcept;
  void add(const Level& level) noexcept;

  std::vector<Span> spans() const;
  std::vector<Level> levels() const;

private:
  mutable std::mutex mutex_;
  std::vector<Span> spans_;
  std::vector<Level> levels_;
};

} // namespace pcl_gpu_icp
