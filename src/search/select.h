#pragma once

#include <pcl_gpu_icp/points.h>

namespace pcl_gpu_icp::search {

/// std::nth_element along an axis, of points in the same place by position: a total order, so that what lies on either
/// side of `nth` depends on the points alone. Two to three times as fast: which side a point goes to is nothing that a
/// processor could predict, and here nothing waits for it.
void selectAlong(int axis, PlacedPoint* first, PlacedPoint* nth, PlacedPoint* last);

} // namespace pcl_gpu_icp::search
