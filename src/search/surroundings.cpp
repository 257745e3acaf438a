#include "surroundings.h"

#include <pcl_gpu_icp/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

namespace pcl_gpu_icp::search {

namespace {

/// Places by the cells of a grid, each in all that its radius reaches: with cells of twice the radius these are eight.
class PlaceGrid {
public:
  PlaceGrid(const std::vector<std::array<double, 3>>& places, double radius)
  : per_cell_(1 / (2 * radius))
  {
    std::size_t slots = 1;
    while (slots < 16 * places.size())
      slots *= 2;
    cells_.resize(slots);
    const auto in_each_cell = [&](const std::array<double, 3>& place, const auto& use) {
      for (int corner = 0; corner < 8; ++corner) {
        std::int64_t cell[3];
        bool is_there = true;
        for (int axis = 0; axis < 3; ++axis) {
          const double at = place[axis] * per_cell_ - 0.5;
          is_there &= std::abs(at) < farthest;
          cell[axis] = is_there ? floorOf(at) + (corner >> axis & 1) : 0;
        }
        if (is_there)
          use(cells_[slotOf(keyOf(cell))], keyOf(cell));
      }
    };
    for (const auto& place : places)
      in_each_cell(place, [](Cell& cell, std::uint64_t key) {
        cell.key = key;
        ++cell.count;
      });
    std::uint32_t first = 0;
    for (Cell& cell : cells_) {
      cell.first = first;
      first += cell.count;
      cell.count = 0;
    }
    members_.resize(first);
    for (std::size_t i = 0; i < places.size(); ++i)
      in_each_cell(places[i], [&](Cell& cell, std::uint64_t /*key*/) {
        members_[cell.first + cell.count++] = static_cast<std::uint32_t>(i);
      });
  }

  struct Members {
    const std::uint32_t* first;
    const std::uint32_t* last;
    const std::uint32_t* begin() const { return first; }
    const std::uint32_t* end() const { return last; }
  };

  /// Those that may be within the radius of a point.
  Members near(const float* point) const
  {
    std::int64_t cell[3];
    for (int axis = 0; axis < 3; ++axis) {
      const double at = point[axis] * per_cell_;
      if (!(std::abs(at) < farthest))
        return {nullptr, nullptr};
      cell[axis] = floorOf(at);
    }
    const Cell& found = cells_[slotOf(keyOf(cell))];
    const std::uint32_t* first = members_.data() + found.first;
    return {first, first + found.count};
  }

private:
  static constexpr double farthest = (1 << 20) - 2; ///< a key has 21 bits for each axis
  static constexpr std::uint64_t none = ~std::uint64_t(0);

  struct Cell {
    std::uint64_t key = none;
    std::uint32_t first = 0, count = 0;
  };

  /// Without a call, which the x86-64 that everybody has needs for std::floor.
  static std::int64_t floorOf(double at)
  {
    constexpr std::int64_t lift = 1 << 20;
    return static_cast<std::int64_t>(at + lift) - lift;
  }

  static std::uint64_t keyOf(const std::int64_t* cell)
  {
    std::uint64_t key = 0;
    for (int axis = 0; axis < 3; ++axis)
      key = key << 21 | static_cast<std::uint64_t>(cell[axis] + (1 << 20));
    return key;
  }

  /// Where the cell is, or would be.
  std::size_t slotOf(std::uint64_t key) const
  {
    std::size_t slot = key * 0x9E3779B97F4A7C15 >> 32 & (cells_.size() - 1);
    while (cells_[slot].key != key && cells_[slot].key != none)
      slot = (slot + 1) & (cells_.size() - 1);
    return slot;
  }

  double per_cell_;
  std::vector<Cell> cells_;
  std::vector<std::uint32_t> members_;
};

} // namespace

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
