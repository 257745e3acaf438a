#include "view/projection.h"

#include <algorithm>
#include <cmath>

namespace pcl_gpu_icp::view {
namespace {

/// How much of a cloud is behind each pixel of a panel.
class Density {
public:
  /// \param points that will be added: of few each is a larger dot
  Density(const Panel& panel, std::size_t points)
  : panel_(panel)
  , sums_(static_cast<std::size_t>(panel.width) * static_cast<std::size_t>(panel.height))
  {
    constexpr double covered = 0.06; // the share of the panel that the dots would cover side by side
    constexpr double pi = 3.14159265358979323846;
    const double area = covered * panel.width * panel.height / static_cast<double>(points);
    radius_ = std::clamp(std::sqrt(area / pi), 0.8, 3.5);
  }

  /// \param x,y in pixels from the panel's upper left corner
  void add(double x, double y)
  {
    const double reach = radius_ + 0.5;
    if (!(x > -reach && y > -reach && x < panel_.width + reach && y < panel_.height + reach))
      return;
    const int left = std::max(0, static_cast<int>(std::floor(x - reach)));
    const int top = std::max(0, static_cast<int>(std::floor(y - reach)));
    const int right = std::min(panel_.width - 1, static_cast<int>(std::floor(x + reach)));
    const int bottom = std::min(panel_.height - 1, static_cast<int>(std::floor(y + reach)));
    for (int row = top; row <= bottom; ++row)
      for (int column = left; column <= right; ++column) {
        const double off = std::hypot(column + 0.5 - x, row + 0.5 - y);
        sums_[place(column, row)] += static_cast<float>(std::clamp(reach - off, 0.0, 1.0));
      }
  }

  /// From 0 to 1.
  double at(int column, int row) const
  {
    constexpr double one_dot = 1.6;
    return 1 - std::exp(-one_dot * static_cast<double>(sums_[place(column, row)]));
  }

private:
  std::size_t place(int column, int row) const
  {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(panel_.width) + static_cast<std::size_t>(column);
  }

  Panel panel_;
  std::vector<float> sums_;
  double radius_;
};

} // namespace

double project(Canvas& canvas,
               const Panel& panel,
               const PairView& view,
               const ShownPose& pose,
               const Box& box,
               const Direction& direction)
{
  constexpr double margin = 0.92; // of the panel that the frame may fill
  const auto extent = [&box](int axis) { return std::max(box.high[axis] - box.low[axis], 1e-30); };
  const auto middle = [&box](int axis) { return (box.high[axis] + box.low[axis]) / 2; };
  const double scale = margin * std::min(panel.width / extent(direction.right), panel.height / extent(direction.up));
  const auto draw = [&](Density& density, const ShownCloud& cloud, const RigidTransform& transform) {
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      const auto point = transform(cloud.xyz[3 * i], cloud.xyz[3 * i + 1], cloud.xyz[3 * i + 2]);
      density.add(panel.width / 2.0 + scale * (point[direction.right] - middle(direction.right)),
                  panel.height / 2.0 - scale * (point[direction.up] - middle(direction.up)));
    }
  };
  Density source(panel, view.source.size()), target(panel, view.target.size());
  draw(source, view.source, pose.transform);
  draw(target, view.target, RigidTransform());
  canvas.paint(panel.x, panel.y, panel.width, panel.height, [&](int column, int row) -> Canvas::Paint {
    const double of_source = source.at(column, row), of_target = target.at(column, row);
    if (of_source + of_target == 0)
      return {};
    const double share = of_source / (of_source + of_target);
    return {share < 0.5 ? between(target_colour, both_colour, 2 * share)
                        : between(both_colour, source_colour, 2 * share - 1),
            std::max(of_source, of_target)};
  });
  return scale;
}

} // namespace pcl_gpu_icp::view
