#pragma once

#include <pcl/search/kdtree.h>

#include <memory>
#include <mutex>
#include <utility>

namespace pcl_gpu_icp::search {

/// A pcl::search::KdTree that answers in a way of its own from x, y, z. Where that is not what is asked for (a point
/// representation or an epsilon of the caller's), PCL's own tree answers, built when a query first needs it. Queries
/// are thread-safe.
template <typename PointT>
class CoordinateKdTree : public pcl::search::KdTree<PointT> {
  using Base = pcl::search::KdTree<PointT>;

public:
  using typename Base::PointCloud;
  using typename Base::PointCloudConstPtr;
  using IndicesConstPtr = pcl::IndicesConstPtr;
  // PCL 1.14 changed what setInputCloud returns from void to bool.
  using SetInputCloudResult = decltype(std::declval<Base&>().setInputCloud(std::declval<const PointCloudConstPtr&>()));

protected:
  explicit CoordinateKdTree(bool sorted)
  : Base(sorted)
  , default_representation_(Base::getPointRepresentation())
  {
  }

  bool usesDefaults() const
  {
    return Base::getPointRepresentation() == default_representation_ && Base::getEpsilon() == 0;
  }

  void hold(const PointCloudConstPtr& cloud, const IndicesConstPtr& indices)
  {
    this->input_ = cloud;
    this->indices_ = indices;
    forgetPclTree();
  }

  /// Not while queries run.
  void forgetPclTree() { pcl_tree_.reset(); }

  /// Built anew when the point representation or the epsilon has changed since.
  std::shared_ptr<const Base> pclTree() const
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (!pcl_tree_ || pcl_tree_->getPointRepresentation() != Base::getPointRepresentation() ||
        pcl_tree_->getEpsilon() != Base::getEpsilon()) {
      const auto tree = std::make_shared<Base>(this->sorted_results_);
      tree->setPointRepresentation(Base::getPointRepresentation());
      tree->setEpsilon(Base::getEpsilon());
      tree->setInputCloud(this->input_, this->indices_);
      pcl_tree_ = tree;
    }
    return pcl_tree_;
  }

private:
  typename Base::PointRepresentationConstPtr default_representation_;
  mutable std::mutex mutex_; ///< of the tree
  mutable std::shared_ptr<const Base> pcl_tree_;
};

} // namespace pcl_gpu_icp::search
