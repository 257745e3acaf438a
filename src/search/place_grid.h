#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_gpu_icp::search {

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

} // namespace pcl_gpu_icp::search
