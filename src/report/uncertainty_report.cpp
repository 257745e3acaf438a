#include "report/uncertainty_report.h"

#include "report/degrees.h"
#include "report/format.h"

#include <cmath>

namespace pcl_gpu_icp::report {
namespace {

Json matrixJson(const std::array<double, 36>& matrix)
{
  Json rows = Json::array();
  for (int row = 0; row < 6; ++row)
    rows.push_back(std::vector<double>(matrix.begin() + 6 * row, matrix.begin() + 6 * (row + 1)));
  return rows;
}

Json axesJson(const std::vector<Uncertainty::Axis>& axes, double unit)
{
  Json json = Json::array();
  for (const Uncertainty::Axis& axis : axes)
    json.push_back({{"direction", axis.direction},
                    {"deviation", std::isfinite(axis.deviation) ? Json(axis.deviation * unit) : Json()}});
  return json;
}

} // namespace

std::string uncertaintyText(const Uncertainty& uncertainty)
{
  std::string text;
  const auto add = [&text](const char* how, const char* unit, const Uncertainty::Axis& axis, double deviation) {
    text += text.empty() ? "deviation  " : "           ";
    text += std::isfinite(deviation) ? format("%.3g%s ", deviation, unit) : std::string("not determined ");
    text += directionText(how, axis.direction) + "\n";
  };
  for (const Uncertainty::Axis& axis : uncertainty.shifts)
    add("along", "", axis, axis.deviation);
  for (const Uncertainty::Axis& axis : uncertainty.turns)
    add("about", " degrees", axis, axis.deviation * degrees_per_radian);
  return text;
}

std::string undeterminedMotions(const Uncertainty& uncertainty)
{
  std::string text;
  const auto add = [&text](const char* how, const std::vector<Uncertainty::Axis>& axes) {
    for (const Uncertainty::Axis& axis : axes)
      if (!std::isfinite(axis.deviation))
        text += (text.empty() ? "" : ", ") + directionText(how, axis.direction);
  };
  add("along", uncertainty.shifts);
  add("about", uncertainty.turns);
  return text;
}

Json uncertaintyJson(const Uncertainty& uncertainty)
{
  return {{"centre", uncertainty.centre},
          {"sigma", uncertainty.sigma},
          {"information", matrixJson(uncertainty.information)},
          {"covariance", matrixJson(uncertainty.covariance)},
          {"shifts", axesJson(uncertainty.shifts, 1)},
          {"turns_degrees", axesJson(uncertainty.turns, degrees_per_radian)}};
}

} // namespace pcl_gpu_icp::report
