#include "matcher_implementation.h"
#include "values_at.h"

#include <pcl_gpu_icp/error.h>

#include <algorithm>
#include <string>

// The matches that are on the device as lists of correspondences, and increments of some of a list.

namespace pcl_gpu_icp {

std::vector<Correspondence> Matcher::correspondences(const RigidTransform& pose) const
{
  Implementation& self = *implementation_;
  const auto& source = self.source.points;
  const auto& target = self.target->cloud.points;
  const RigidTransform pivoted = recentred(pose, self.source.pivot, self.target->cloud.pivot);
  std::vector<Correspondence> by_place(source.size());
  self.queue.download(self.stage.matches(), source.size() * sizeof(cl_int), [&](const void* memory) {
    const auto* matches = static_cast<const cl_int*>(memory);
    for (std::size_t i = 0; i < source.size(); ++i) {
      const std::int32_t place = source[i].position;
      Correspondence& c = by_place[place];
      c = {self.source_positions[place], -1, 0};
      if (matches[i] < 0)
        continue;
      c.target = target[matches[i]].position;
      const float* p = source[i].xyz;
      c.squared_distance = static_cast<float>(squaredDistance(pivoted(p[0], p[1], p[2]), target[matches[i]].xyz));
    }
  });
  by_place.erase(std::remove_if(by_place.begin(), by_place.end(), [](const Correspondence& c) { return c.target < 0; }),
                 by_place.end());
  return by_place;
}

Matches Matcher::estimate(const std::vector<Correspondence>& kept, const RigidTransform& pose)
{
  Implementation& self = *implementation_;
  if (!self.solvesSystem())
    throw InvalidArgument("an increment from some of the matches needs normals, covariances, a loss or motions");
  const DevicePose device_pose = self.onDevice(pose);
  Matches result;
  Estimate& estimate = result.increment;
  estimate.degeneracy = Degeneracy::Empty;
  if (!kept.empty()) {
    const auto last = std::max_element(self.source_positions.begin(), self.source_positions.end());
    std::vector<char> is_kept(last == self.source_positions.end() ? 0 : *last + 1);
    for (const Correspondence& c : kept) {
      if (c.source < 0 || static_cast<std::size_t>(c.source) >= is_kept.size())
        throw InvalidArgument("a correspondence names source point " + std::to_string(c.source) + ", which is none");
      is_kept[c.source] = 1;
    }
    std::vector<cl_int> matches(self.source_rows.stride, -1);
    self.queue.download(self.stage.matches(), self.source.points.size() * sizeof(cl_int), [&](const void* memory) {
      for (std::size_t i = 0; i < self.source.points.size(); ++i)
        if (is_kept[self.source_positions[self.source.points[i].position]] != 0)
          matches[i] = static_cast<const cl_int*>(memory)[i];
    });
    self.queue.upload(self.kept_matches, matches.size() * sizeof(cl_int), [&](void* memory) {
      std::copy(matches.begin(), matches.end(), static_cast<cl_int*>(memory));
    });
    estimate.pairs = kept.size();
    self.paired = &self.kept_matches;
    self.solveSystem(device_pose.pivoted(), self.kept_matches, result);
  }
  self.complete(estimate, device_pose);
  return result;
}

double meanSquaredDistance(const std::vector<Correspondence>& correspondences,
                           const Points& source,
                           const Points& target,
                           const RigidTransform& pose)
{
  double sum = 0;
  for (const Correspondence& c : correspondences) {
    const float* p = valuesAt(source, c.source);
    sum += squaredDistance(pose(p[0], p[1], p[2]), valuesAt(target, c.target));
  }
  return correspondences.empty() ? 0 : sum / static_cast<double>(correspondences.size());
}

} // namespace pcl_gpu_icp
