#pragma once

#include <pcl_gpu_icp/device.h>
#include <pcl_gpu_icp/points.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

namespace pcl_gpu_icp {

namespace opencl {
struct Traits;
}

/// Points found, with their squared distances: entry i of one belongs to entry i of the other.
struct Neighbours {
  std::vector<std::int32_t> positions; ///< as Points::position() gives them
  std::vector<float> squared_distances;
};

/// Exact nearest neighbours in a tree of boxes that the device and the host share: batches are answered on the device,
/// single queries on the host, where they take less than a launch. Non-finite points are left out, and non-finite
/// queries find nothing. Queries are thread-safe.
class PCL_GPU_ICP_API NeighbourSearch {
public:
  /// Batches go up to this k on the device, and from there on to the host's threads.
  static constexpr unsigned most_on_device = 32;

  /// \param device by default Device::select(), when a batch first needs it
  explicit NeighbourSearch(std::optional<Device> device = std::nullopt);
  ~NeighbourSearch();
  NeighbourSearch(NeighbourSearch&&) noexcept;
  NeighbourSearch& operator=(NeighbourSearch&&) noexcept;

  /// Copies the coordinates of the finite points and builds the tree.
  void build(const Points& points);

  /// Finite points.
  std::size_t size() const;

  /// The k nearest points, nearest first; all of them when there are fewer.
  Neighbours nearest(const float* xyz, std::size_t k) const;

  /// The points closer than `radius`, nearest first if `sorted`; of more than `most`, the nearest. `most` 0: no limit.
  Neighbours within(const float* xyz, double radius, std::size_t most = 0, bool sorted = true) const;

  /// nearest() of every query.
  /// \throws DeviceError when the tree or the answers do not fit the device
  std::vector<Neighbours> nearest(const Points& queries, std::size_t k) const;

private:
  friend NeighbourSearch makeNeighbourSearch(const Device&, const opencl::Traits&);
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

} // namespace pcl_gpu_icp
