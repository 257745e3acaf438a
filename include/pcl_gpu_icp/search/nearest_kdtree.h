#pragma once

#include <pcl_gpu_icp/search/coordinate_kdtree.h>
#include <pcl_gpu_icp/search/nearest_index.h>
#include <pcl_gpu_icp/search/points_of.h>
#include <pcl_gpu_icp/search/shared_cache.h>
#include <pcl_gpu_icp/stopwatch.h>

#include <pcl/search/kdtree.h>

#include <memory>
#include <mutex>
#include <utility>
#include <vector>

namespace pcl_gpu_icp::search {

/// pcl::search::KdTree that answers one-nearest queries from a NearestIndex. Everything else (k > 1, radius searches,
/// a point representation or an epsilon set by the caller) is answered by PCL's own tree, built when first asked for.
/// Given a cloud whose coordinates are those it holds, it keeps its tree. Queries are thread-safe.
template <typename PointT>
class NearestKdTree : public CoordinateKdTree<PointT> {
  using Base = CoordinateKdTree<PointT>;

public:
  using Ptr = pcl::shared_ptr<NearestKdTree>;
  using typename Base::IndicesConstPtr;
  using typename Base::PointCloudConstPtr;
  using typename Base::SetInputCloudResult;

  explicit NearestKdTree(bool sorted = true)
  : Base(sorted)
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

  /// The index that answers, or null when the caller's settings call for PCL's own tree.
  std::shared_ptr<const NearestIndex> index() const { return this->usesDefaults() ? index_ : nullptr; }

  /// Where to look for an index of the same points before building one; null, the default: nowhere.
  void setCache(std::shared_ptr<SharedCache<NearestIndex>> cache) { cache_ = std::move(cache); }

  /// Whether setInputCloud() leaves the building to refresh() or to the first query.
  void setDeferred(bool deferred) { deferred_ = deferred; }

  /// Builds anew if the coordinates of the cloud have changed in place since.
  void refresh();

  /// Of the points that the index holds.
  std::uint64_t fingerprint() const { return fingerprint_; }

  /// Grows with every build.
  unsigned long revision() const { return revision_; }

  /// Time spent on building, and on finding out that nothing changed, since the last call.
  double takeBuildMilliseconds() { return std::exchange(times_["tree"].milliseconds, 0.0); }

private:
  /// A query on a tree whose building was deferred builds it.
  void buildIfDeferred() const
  {
    if (due_)
      std::call_once(*due_, [this] { const_cast<NearestKdTree*>(this)->build(); });
  }
  void build();

  bool deferred_ = false;
  std::unique_ptr<std::once_flag> due_; ///< set while a building is deferred
  std::shared_ptr<const NearestIndex> index_ = std::make_shared<NearestIndex>();
  std::shared_ptr<SharedCache<NearestIndex>> cache_;
  std::uint64_t fingerprint_ = 0;
  unsigned long revision_ = 0;
  StageTimes times_;
};

template <typename PointT>
typename NearestKdTree<PointT>::SetInputCloudResult
NearestKdTree<PointT>::setInputCloud(const PointCloudConstPtr& cloud, const IndicesConstPtr& indices)
{
  this->hold(cloud, indices);
  if (deferred_)
    due_ = std::make_unique<std::once_flag>();
  else
    refresh();
  return static_cast<SetInputCloudResult>(true);
}

template <typename PointT>
void NearestKdTree<PointT>::refresh()
{
  due_.reset();
  build();
}

template <typename PointT>
void NearestKdTree<PointT>::build()
{
  const Stopwatch watch(times_, "tree");
  const Points points = pointsOf(*this->input_, this->indices_ ? this->indices_.get() : nullptr);
  const std::uint64_t fingerprint = fingerprintOf(points);
  const bool unchanged = revision_ > 0 && fingerprint == fingerprint_;
  if (!unchanged) {
    const auto build_index = [&] {
      auto index = std::make_shared<NearestIndex>();
      index->build(points);
      return index;
    };
    index_ = cache_ ? cache_->get(fingerprint, build_index) : build_index();
    fingerprint_ = fingerprint;
    ++revision_;
  }
  // A representation may look at more than the coordinates.
  if (!unchanged || !this->usesDefaults())
    this->forgetPclTree();
}

template <typename PointT>
int NearestKdTree<PointT>::nearestKSearch(const PointT& point,
                                          int k,
                                          pcl::Indices& indices,
                                          std::vector<float>& distances) const
{
  if (k != 1 || !this->usesDefaults())
    return this->pclTree()->nearestKSearch(point, k, indices, distances);
  buildIfDeferred();
  const Neighbour neighbour = index_->nearest(&point.x);
  // Callers in PCL read entry 0 whatever is returned.
  indices.assign(1, neighbour.index);
  distances.assign(1, neighbour.squared_distance);
  return neighbour.index >= 0 ? 1 : 0;
}

template <typename PointT>
int NearestKdTree<PointT>::radiusSearch(
    const PointT& point, double radius, pcl::Indices& indices, std::vector<float>& distances, unsigned int max_nn) const
{
  return this->pclTree()->radiusSearch(point, radius, indices, distances, max_nn);
}

} // namespace pcl_gpu_icp::search
