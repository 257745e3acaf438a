#include "cli/guess.h"

#include "cli/input_file.h"
#include "cli/number.h"

#include <Eigen/LU>
#include <Eigen/SVD>

#include <algorithm>
#include <cmath>

namespace pcl_gpu_icp::cli {
namespace {

constexpr std::string_view separators = " \t\r\n,";

using RowMajor3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
using Rotation = Eigen::Map<const RowMajor3>;
using MutableRotation = Eigen::Map<RowMajor3>;

bool isNumber(const std::string& text) { return parseNumber<double>(text).has_value(); }

} // namespace

std::vector<std::string> joinGuess(std::vector<std::string> arguments)
{
  const auto guess = std::find(arguments.begin(), arguments.end(), "--guess");
  if (guess == arguments.end())
    return arguments;
  const auto first = guess + 1;
  auto last = first;
  while (last != arguments.end() && last - first < 16 && isNumber(*last))
    ++last;
  if (first == last)
    return arguments;
  for (auto number = first; number != last; ++number)
    *guess += (number == first ? "=" : " ") + *number;
  arguments.erase(first, last);
  return arguments;
}

bool namesFile(const std::string& argument)
{
  std::string_view words(argument);
  return !parseNumber<double>(nextWord(words, separators));
}

RigidTransform readGuess(const std::string& argument)
{
  std::string text = argument;
  const bool is_file = namesFile(argument);
  const std::string where = is_file ? "--guess " + argument : "--guess";
  const auto fail = [&](const std::string& why) {
    return Failure(is_file ? ExitCode::Input : ExitCode::Usage, where + ": " + why);
  };
  if (is_file)
    text = readFile(argument);

  std::vector<double> m;
  std::string_view words(text);
  for (auto word = nextWord(words, separators); !word.empty(); word = nextWord(words, separators)) {
    const auto value = parseNumber<double>(word);
    if (!value || !std::isfinite(*value))
      throw fail(std::string(word.substr(0, 40)) + " is not a finite number");
    m.push_back(*value);
  }
  if (m.size() != 16)
    throw fail(std::to_string(m.size()) + " numbers where a 4x4 matrix has 16");

  RigidTransform guess;
  for (int row = 0; row < 3; ++row) {
    std::copy_n(m.begin() + 4 * row, 3, guess.rotation.begin() + 3 * row);
    guess.translation[row] = m[4 * row + 3];
  }
  const Rotation rotation(guess.rotation.data());
  constexpr double tolerance = 1e-3;
  const double error = (rotation * rotation.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  if (error > tolerance || rotation.determinant() < 0 ||
      std::vector<double>(m.begin() + 12, m.end()) != std::vector<double>{0, 0, 0, 1})
    throw fail("not a rigid transform: three rows of a rotation (orthonormal to 0.001, determinant +1) and a "
               "translation, then 0 0 0 1");
  return guess;
}

RigidTransform orthonormalised(const RigidTransform& transform, const std::array<double, 3>& anchor)
{
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(Rotation(transform.rotation.data()),
                                              Eigen::ComputeFullU | Eigen::ComputeFullV);
  RigidTransform result;
  MutableRotation(result.rotation.data()) = svd.matrixU() * svd.matrixV().transpose();
  const auto image = transform(anchor[0], anchor[1], anchor[2]);
  const auto rotated = result(anchor[0], anchor[1], anchor[2]);
  for (int i = 0; i < 3; ++i)
    result.translation[i] = image[i] - rotated[i];
  return result;
}

} // namespace pcl_gpu_icp::cli
