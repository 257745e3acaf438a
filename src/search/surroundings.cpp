#include "surroundings.h"

#include "place_grid.h"

#include <pcl_gpu_icp/parallel_for.h>

#include <algorithm>
#include <cstdint>
#include <utility>

namespace pcl_gpu_icp::search {

void Nearby::add(const std::array<double, 3>& /*v*/, double squared_distance)
{
  ++count;
  nearest_sq = std::min(nearest_sq, squared_distance);
}

void Nearby::add(const Nearby& more)
{
  count += more.count;
  nearest_sq = std::min(nearest_sq, more.nearest_sq);
}

void Surroundings::add(const std::array<double, 3>& v, double squared_distance)
{
  Nearby::add(v, squared_distance);
  std::size_t entry = 0;
  for (int row = 0; row < 3; ++row) {
    sum[row] += v[row];
    for (int column = 0; column <= row; ++column)
      squares[entry++] += v[row] * v[column];
  }
}

void Surroundings::add(const Surroundings& more)
{
  Nearby::add(more);
  for (std::size_t i = 0; i < sum.size(); ++i)
    sum[i] += more.sum[i];
  for (std::size_t i = 0; i < squares.size(); ++i)
    squares[i] += more.squares[i];
}

template <typename Found>
std::vector<Found> foundAround(const std::vector<std::array<double, 3>>& places,
                               const std::vector<PlacedPoint>& cloud,
                               double radius,
                               unsigned threads)
{
  constexpr std::size_t parts_at_most = 4, of_a_part = 1 << 12;
  const std::size_t parts = std::clamp<std::size_t>(cloud.size() / of_a_part, 1, parts_at_most);
  std::vector<std::vector<Found>> found(parts, std::vector<Found>(places.size()));
  if (!(radius > 0))
    return found[0];
  const PlaceGrid grid(places, radius);
  const double radius_sq = radius * radius, per_radius = 1 / radius;
  parallelFor(parts, 1, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t part = begin; part < end; ++part)
      for (std::size_t i = part * cloud.size() / parts; i < (part + 1) * cloud.size() / parts; ++i) {
        const float* point = cloud[i].xyz;
        for (const std::uint32_t place : grid.near(point)) {
          const std::array<double, 3>& at = places[place];
          const double x = point[0] - at[0], y = point[1] - at[1], z = point[2] - at[2];
          const double squared_distance = x * x + y * y + z * z;
          if (squared_distance <= radius_sq)
            found[part][place].add({x * per_radius, y * per_radius, z * per_radius}, squared_distance);
        }
      }
  });
  for (std::size_t part = 1; part < parts; ++part)
    for (std::size_t place = 0; place < places.size(); ++place)
      found[0][place].add(found[part][place]);
  return std::move(found[0]);
}

template std::vector<Nearby>
foundAround(const std::vector<std::array<double, 3>>&, const std::vector<PlacedPoint>&, double, unsigned);
template std::vector<Surroundings>
foundAround(const std::vector<std::array<double, 3>>&, const std::vector<PlacedPoint>&, double, unsigned);

} // namespace pcl_gpu_icp::search
