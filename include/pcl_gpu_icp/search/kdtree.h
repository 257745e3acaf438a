#pragma once

#include <pcl_gpu_icp/neighbour_search.h>
#include <pcl_gpu_icp/search/coordinate_kdtree.h>
#include <pcl_gpu_icp/search/points_of.h>

#include <pcl/search/kdtree.h>

#include <optional>
#include <utility>
#include <vector>

namespace pcl_gpu_icp::search {

/// pcl::search::KdTree over a tree of boxes that an OpenCL device searches: the same neighbours at the same distances.
/// Of points equally far as the last that fits, any may be the one that is left out. Batches of nearestKSearch run on
/// the device (up to k = NeighbourSearch::most_on_device); single queries and radius searches run on the host in the
/// same tree, because a launch takes longer than they do. Non-finite points are left out, and non-finite queries find
/// nothing. With a point representation or an epsilon of the caller's, PCL's own tree answers. Queries are thread-safe.
///
/// Errors: DeviceError from a batch when there is no device, or when the tree or the answers do not fit it.
template <typename PointT>
class KdTree : public CoordinateKdTree<PointT> {
  using Base = CoordinateKdTree<PointT>;

public:
  using Ptr = pcl::shared_ptr<KdTree>;
  using ConstPtr = pcl::shared_ptr<const KdTree>;
  using typename Base::IndicesConstPtr;
  using typename Base::PointCloud;
  using typename Base::PointCloudConstPtr;
  using typename Base::SetInputCloudResult;

  /// \param device by default Device::select(), when a batch first needs it
  explicit KdTree(bool sorted = true, std::optional<Device> device = std::nullopt)
  : Base(sorted)
  , search_(std::move(device))
  {
  }

  SetInputCloudResult setInputCloud(const PointCloudConstPtr& cloud,
                                    const IndicesConstPtr& indices = IndicesConstPtr()) override;

  using Base::nearestKSearch;
  using Base::radiusSearch;
  int nearestKSearch(const PointT& point, int k, pcl::Indices& indices, std::vector<float>& distances) const override;
  int radiusSearch(const PointT& point,
                   double radius,
                   pcl::Indices& indices,
                   std::vector<float>& distances,
                   unsigned int max_nn = 0) const override;
  /// Of the points of `cloud` that `queries` names, or of all when it is empty.
  void nearestKSearch(const PointCloud& cloud,
                      const pcl::Indices& queries,
                      int k,
                      std::vector<pcl::Indices>& indices,
                      std::vector<std::vector<float>>& distances) const override;

private:
  static int hand(Neighbours&& found, pcl::Indices& indices, std::vector<float>& distances)
  {
    indices.assign(found.positions.begin(), found.positions.end());
    distances = std::move(found.squared_distances);
    return static_cast<int>(indices.size());
  }

  NeighbourSearch search_;
};

template <typename PointT>
typename KdTree<PointT>::SetInputCloudResult KdTree<PointT>::setInputCloud(const PointCloudConstPtr& cloud,
                                                                           const IndicesConstPtr& indices)
{
  this->hold(cloud, indices);
  search_.build(pointsOf(*cloud, indices ? indices.get() : nullptr));
  return static_cast<SetInputCloudResult>(true);
}

template <typename PointT>
int KdTree<PointT>::nearestKSearch(const PointT& point,
                                   int k,
                                   pcl::Indices& indices,
                                   std::vector<float>& distances) const
{
  if (!this->usesDefaults())
    return this->pclTree()->nearestKSearch(point, k, indices, distances);
  return hand(search_.nearest(&point.x, k > 0 ? static_cast<std::size_t>(k) : 0), indices, distances);
}

template <typename PointT>
int KdTree<PointT>::radiusSearch(
    const PointT& point, double radius, pcl::Indices& indices, std::vector<float>& distances, unsigned int max_nn) const
{
  if (!this->usesDefaults())
    return this->pclTree()->radiusSearch(point, radius, indices, distances, max_nn);
  return hand(search_.within(&point.x, radius, max_nn, this->sorted_results_), indices, distances);
}

template <typename PointT>
void KdTree<PointT>::nearestKSearch(const PointCloud& cloud,
                                    const pcl::Indices& queries,
                                    int k,
                                    std::vector<pcl::Indices>& indices,
                                    std::vector<std::vector<float>>& distances) const
{
  if (!this->usesDefaults()) {
    this->pclTree()->nearestKSearch(cloud, queries, k, indices, distances);
    return;
  }
  auto answers =
      search_.nearest(pointsOf(cloud, queries.empty() ? nullptr : &queries), k > 0 ? static_cast<std::size_t>(k) : 0);
  indices.resize(answers.size());
  distances.resize(answers.size());
  for (std::size_t i = 0; i < answers.size(); ++i)
    hand(std::move(answers[i]), indices[i], distances[i]);
}

} // namespace pcl_gpu_icp::search
