#include <pcl_gpu_icp/parallel_for.h>
#include <pcl_gpu_icp/search/matcher.h>

#include <cmath>

namespace pcl_gpu_icp::search {

namespace {

struct Coordinates {
  float xyz[3];
};

Coordinates moved(const RigidTransform& pose, const float* p)
{
  const auto x = pose(p[0], p[1], p[2]);
  return {{static_cast<float>(x[0]), static_cast<float>(x[1]), static_cast<float>(x[2])}};
}

float squaredDistance(const float* a, const float* b)
{
  const float dx = a[0] - b[0], dy = a[1] - b[1], dz = a[2] - b[2];
  return dx * dx + dy * dy + dz * dz;
}

const float* pointAt(const Points& cloud, std::int32_t position)
{
  return reinterpret_cast<const float*>(static_cast<const char*>(cloud.data) + position * cloud.stride);
}

} // namespace

Matcher::Matcher(const Points& source,
                 const Points& target,
                 const NearestIndex& target_index,
                 float max_squared_distance,
                 unsigned threads)
: source_(source)
, target_(target)
, target_index_(target_index)
, max_squared_distance_(max_squared_distance)
, threads_(threads)
, neighbours_(source.count)
{
}

void Matcher::requireReciprocal()
{
  reciprocal_ = true;
  source_index_.build(source_);
}

const std::vector<Correspondence>& Matcher::match(const RigidTransform& pose)
{
  const RigidTransform back = reciprocal_ ? inverse(pose) : RigidTransform{};
  parallelFor(source_.count, queries_at_a_time, threads_, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const Coordinates query = moved(pose, source_[i]);
      Neighbour start = neighbours_[i];
      if (start.index >= 0)
        start.squared_distance = squaredDistance(query.xyz, pointAt(target_, start.index));
      neighbours_[i] = target_index_.nearest(query.xyz, max_squared_distance_, start);
    }
  });

  const auto is_mutual = [&](std::size_t i) {
    const Coordinates target_at_source = moved(back, pointAt(target_, neighbours_[i].index));
    const Neighbour nearest = source_index_.nearest(target_at_source.xyz, max_squared_distance_);
    return nearest.index == static_cast<std::int32_t>(source_.position(i));
  };
  std::vector<char> mutual;
  if (reciprocal_) {
    mutual.resize(source_.count);
    parallelFor(source_.count, queries_at_a_time, threads_, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i)
        mutual[i] = neighbours_[i].index >= 0 && is_mutual(i);
    });
  }

  correspondences_.clear();
  for (std::size_t i = 0; i < source_.count; ++i)
    if (neighbours_[i].index >= 0 && (!reciprocal_ || mutual[i]))
      correspondences_.push_back(
          {static_cast<std::int32_t>(source_.position(i)), neighbours_[i].index, neighbours_[i].squared_distance});
  return correspondences_;
}

double rootMeanSquareDistance(const std::vector<Correspondence>& correspondences,
                              const Points& source,
                              const Points& target,
                              const RigidTransform& pose)
{
  if (correspondences.empty())
    return 0;
  double sum = 0;
  for (const Correspondence& c : correspondences) {
    const float* p = pointAt(source, c.source);
    const float* q = pointAt(target, c.target);
    const auto x = pose(p[0], p[1], p[2]);
    for (int axis = 0; axis < 3; ++axis)
      sum += (x[axis] - q[axis]) * (x[axis] - q[axis]);
  }
  return std::sqrt(sum / static_cast<double>(correspondences.size()));
}

} // namespace pcl_gpu_icp::search
