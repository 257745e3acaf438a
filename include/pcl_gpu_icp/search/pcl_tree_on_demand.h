#pragma once

#include <pcl/search/kdtree.h>

#include <memory>
#include <mutex>

namespace pcl_gpu_icp::search {

/// PCL's own tree over a cloud, built when a query first needs it and built anew when the point representation or the
/// epsilon has changed since. Queries are thread-safe; forget() is not.
template <typename PointT>
class PclTreeOnDemand {
public:
  using Tree = pcl::search::KdTree<PointT>;

  void forget() { tree_.reset(); }

  /// A tree with the cloud, indices, point representation and epsilon of `settings`.
  std::shared_ptr<const Tree> like(const Tree& settings, bool sorted) const
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (!tree_ || tree_->getPointRepresentation() != settings.getPointRepresentation() ||
        tree_->getEpsilon() != settings.getEpsilon()) {
      const auto tree = std::make_shared<Tree>(sorted);
      tree->setPointRepresentation(settings.getPointRepresentation());
      tree->setEpsilon(settings.getEpsilon());
      tree->setInputCloud(settings.getInputCloud(), settings.getIndices());
      tree_ = tree;
    }
    return tree_;
  }

private:
  mutable std::mutex mutex_;
  mutable std::shared_ptr<const Tree> tree_;
};

} // namespace pcl_gpu_icp::search
