#pragma once

#include <pcl_gpu_icp/search/nearest_index.h>
#include <pcl_gpu_icp/stopwatch.h>

#include <pcl/search/kdtree.h>

#include <memory>
#include <mutex>
#include <utility>
#include <vector>

namespace pcl_gpu_icp::search {

/// A view of a PCL cloud's coordinates, or of those that an index names.
template <typename PointT>
Points pointsOf(const pcl::PointCloud<PointT>& cloud, const pcl::Indices* indices = nullptr)
{
  Points points;
  points.data = cloud.empty() ? nullptr : &cloud[0].x;
  points.stride = sizeof(PointT);
  points.count = indices ? indices->size() : cloud.size();
  points.index = indices ? indices->data() : nullptr;
  return points;
}

/// pcl::search::KdTree that answers one-nearest queries from a NearestIndex. Everything else (k > 1, radius searches,
/// a point representation or an epsilon set by the caller) is answered by PCL's own tree, built when first asked for.
/// Given a cloud whose coordinates are those it holds, it keeps its tree. Queries are thread-safe.
template <typename PointT>
class NearestKdTree : public pcl::search::KdTree<PointT> {
  using Base = pcl::search::KdTree<PointT>;

public:
  using Ptr = pcl::shared_ptr<NearestKdTree>;
  using typename Base::PointCloudConstPtr;
  using IndicesConstPtr = pcl::IndicesConstPtr;
  // PCL 1.14 changed what setInputCloud returns from void to bool.
  using SetInputCloudResult = decltype(std::declval<Base&>().setInputCloud(std::declval<const PointCloudConstPtr&>()));

  explicit NearestKdTree(bool sorted = true)
  : Base(sorted)
  , default_representation_(Base::getPointRepresentation())
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
  const NearestIndex* index() const { return usesDefaults() ? &index_ : nullptr; }

  /// Builds anew if the coordinates of the cloud have changed in place since.
  void refresh();

  /// Grows with every build.
  unsigned long revision() const { return revision_; }

  /// Time spent on building, and on finding out that nothing changed, since the last call.
  double takeBuildMilliseconds() { return std::exchange(times_["tree"].milliseconds, 0.0); }

private:
  bool usesDefaults() const
  {
    return Base::getPointRepresentation() == default_representation_ && Base::getEpsilon() == 0;
  }

  /// PCL's own tree and what it was made with.
  struct OnDemand {
    std::once_flag once;
    std::unique_ptr<Base> tree;
    typename Base::PointRepresentationConstPtr representation;
    float epsilon;
  };
  const Base& pclTree() const;
  void forgetPclTree()
  {
    on_demand_ = std::make_unique<OnDemand>();
    on_demand_->representation = Base::getPointRepresentation();
    on_demand_->epsilon = Base::getEpsilon();
  }

  typename Base::PointRepresentationConstPtr default_representation_;
  NearestIndex index_;
  std::uint64_t fingerprint_ = 0;
  unsigned long revision_ = 0;
  StageTimes times_;
  std::unique_ptr<OnDemand> on_demand_;
};

template <typename PointT>
typename NearestKdTree<PointT>::SetInputCloudResult
NearestKdTree<PointT>::setInputCloud(const PointCloudConstPtr& cloud, const IndicesConstPtr& indices)
{
  this->input_ = cloud;
  this->indices_ = indices;
  forgetPclTree();
  refresh();
  return static_cast<SetInputCloudResult>(true);
}

template <typename PointT>
void NearestKdTree<PointT>::refresh()
{
  const Stopwatch watch(times_, "tree");
  const Points points = pointsOf(*this->input_, this->indices_ ? this->indices_.get() : nullptr);
  const std::uint64_t fingerprint = fingerprintOf(points);
  const bool unchanged = revision_ > 0 && fingerprint == fingerprint_;
  if (!unchanged) {
    index_.build(points);
    fingerprint_ = fingerprint;
    ++revision_;
  }
  // A representation may look at more than the coordinates.
  if (!unchanged || !usesDefaults() || on_demand_->representation != default_representation_ ||
      on_demand_->epsilon != 0)
    forgetPclTree();
}

template <typename PointT>
const pcl::search::KdTree<PointT>& NearestKdTree<PointT>::pclTree() const
{
  OnDemand& on_demand = *on_demand_;
  std::call_once(on_demand.once, [&] {
    on_demand.tree = std::make_unique<Base>(this->sorted_results_);
    on_demand.tree->setPointRepresentation(on_demand.representation);
    on_demand.tree->setEpsilon(on_demand.epsilon);
    on_demand.tree->setInputCloud(this->input_, this->indices_);
  });
  return *on_demand.tree;
}

template <typename PointT>
int NearestKdTree<PointT>::nearestKSearch(const PointT& point,
                                          int k,
                                          pcl::Indices& indices,
                                          std::vector<float>& distances) const
{
  if (k != 1 || !usesDefaults())
    return pclTree().nearestKSearch(point, k, indices, distances);
  const Neighbour neighbour = index_.nearest(&point.x);
  // Callers in PCL read entry 0 whatever is returned.
  indices.assign(1, neighbour.index);
  distances.assign(1, neighbour.squared_distance);
  return neighbour.index >= 0 ? 1 : 0;
}

template <typename PointT>
int NearestKdTree<PointT>::radiusSearch(
    const PointT& point, double radius, pcl::Indices& indices, std::vector<float>& distances, unsigned int max_nn) const
{
  return pclTree().radiusSearch(point, radius, indices, distances, max_nn);
}

} // namespace pcl_gpu_icp::search
