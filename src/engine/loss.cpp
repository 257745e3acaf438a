#include "loss_internals.h"

#include <pcl_gpu_icp/error.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

namespace pcl_gpu_icp {

namespace {

/// Of a normal distribution with standard deviation 1, for an efficiency of 95 %.
double tuning(LossFunction function)
{
  switch (function) {
  case LossFunction::None:
    break;
  case LossFunction::Huber:
    return 1.345;
  case LossFunction::Cauchy:
    return 2.385;
  case LossFunction::GemanMcClure:
    return 3.787;
  case LossFunction::Tukey:
    return 4.685;
  case LossFunction::Welsch:
    return 2.985;
  }
  return std::numeric_limits<double>::infinity();
}

} // namespace

const char* toString(LossFunction function)
{
  switch (function) {
  case LossFunction::None:
    return "none";
  case LossFunction::Huber:
    return "huber";
  case LossFunction::Cauchy:
    return "cauchy";
  case LossFunction::GemanMcClure:
    return "geman-mcclure";
  case LossFunction::Tukey:
    return "tukey";
  case LossFunction::Welsch:
    return "welsch";
  }
  return "unknown";
}

void requireValid(const Loss& loss)
{
  const double square = loss.scale * loss.scale;
  const bool holds = loss.scale == 0 || std::isinf(loss.scale) ||
                     (square >= std::numeric_limits<float>::min() && square <= std::numeric_limits<float>::max());
  if (!(loss.scale >= 0) || !holds)
    throw InvalidArgument("the scale of a loss is a number from 1.1e-19 to 1.8e19, 0 (from the residuals) or infinite, "
                          "not " +
                          std::to_string(loss.scale));
}

double robustDeviation(std::vector<float>& residuals)
{
  residuals.erase(std::remove_if(residuals.begin(), residuals.end(), [](float r) { return !std::isfinite(r); }),
                  residuals.end());
  if (residuals.empty())
    return 0;
  constexpr double to_deviation = 1.4826; // 1 / 0.6745, the median of a normal distribution's absolute value
  const auto median = residuals.begin() + static_cast<std::ptrdiff_t>(residuals.size() / 2);
  std::nth_element(residuals.begin(), median, residuals.end());
  return *median * to_deviation;
}

double scaleFrom(std::vector<float>& residuals, LossFunction function)
{
  const double deviation = robustDeviation(residuals);
  double squares = 0;
  for (const float residual : residuals)
    squares += static_cast<double>(residual) * residual;
  constexpr double least_share = 1e-3; // where most residuals are 0, of all of them
  const double rms = residuals.empty() ? 0 : std::sqrt(squares / static_cast<double>(residuals.size()));
  const double scale = std::max(deviation, least_share * rms) * tuning(function);
  return scale * scale >= std::numeric_limits<float>::min() ? scale : 1;
}

} // namespace pcl_gpu_icp
