#include "cli/guess.h"

#include "cli/input_file.h"
#include "cli/number.h"

#include "report/format.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <stdexcept>

namespace pcl_gpu_icp::cli {
namespace {

using Rotation = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>;

/// What a matrix is called where Python prints it, as in array([[1., 0.], [0., 1.]], dtype=float32).
constexpr std::string_view array_names[] = {"array", "np.array", "numpy.array", "tensor"};

bool isOfAnArray(std::string_view word)
{
  return std::find(std::begin(array_names), std::end(array_names), word) != std::end(array_names) ||
         word.rfind("dtype=", 0) == 0;
}

/// As CloudCompare's console begins its lines: 14:09:29.
bool isTimeOfDay(std::string_view word)
{
  constexpr std::string_view shape = "00:00:00";
  return std::equal(word.begin(), word.end(), shape.begin(), shape.end(), [](char c, char of_shape) {
    return of_shape == ':' ? c == ':' : c >= '0' && c <= '9';
  });
}

bool isNumber(const std::string& text) { return parseNumber<double>(text).has_value(); }

std::vector<double> numbersOf(std::string_view text)
{
  std::vector<double> numbers;
  while (!text.empty()) {
    std::string_view line = nextLine(text);
    line = line.substr(0, line.find('#'));
    for (auto word = nextWord(line, number_separators); !word.empty(); word = nextWord(line, number_separators)) {
      if (isOfAnArray(word) || isTimeOfDay(word))
        continue;
      const auto value = parseNumber<double>(word);
      if (!value || !std::isfinite(*value)) {
        std::string shown(word.substr(0, 40));
        std::replace(shown.begin(), shown.end(), '\0', ' '); // which would end the message
        throw std::invalid_argument("'" + shown + "' is not a finite number");
      }
      numbers.push_back(*value);
    }
  }
  return numbers;
}

constexpr double last_row_tolerance = 1e-6; // what a product of transforms may end with

bool isLastRow(const std::array<double, 4>& row)
{
  constexpr double expected[] = {0, 0, 0, 1};
  return std::equal(row.begin(), row.end(), expected, [](double value, double wanted) {
    return std::abs(value - wanted) <= last_row_tolerance;
  });
}

void checkLastRow(const std::vector<double>& m)
{
  const std::array<double, 4> row{m[12], m[13], m[14], m[15]};
  if (isLastRow(row))
    return;
  if (isLastRow({m[3], m[7], m[11], m[15]}))
    throw std::invalid_argument("looks transposed: 0 0 0 1 is its last column, and must be its last row");
  throw std::invalid_argument("not a rigid transform: its last row is " +
                              report::format("%.9g %.9g %.9g %.9g", row[0], row[1], row[2], row[3]) + ", not 0 0 0 1");
}

void checkRotation(const Rotation& rotation)
{
  const Eigen::Matrix3d product = rotation * rotation.transpose();
  const double square = product.trace() / 3;
  const auto error = [&product](double unit) {
    return (product - unit * Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  };
  const std::string refusal = "not a rigid transform: ";
  if (!product.allFinite()) // of NaN Eigen's largest may be anything
    throw std::invalid_argument(refusal + "its numbers are too large for a rotation");
  if (error(1) <= rigid_tolerance) {
    if (rotation.determinant() < 0)
      throw std::invalid_argument(refusal + "it mirrors (its determinant is -1)");
    return;
  }
  constexpr double plain_scale = 0.01; // less may be the digits that are missing
  if (error(square) <= rigid_tolerance * square && std::abs(std::sqrt(square) - 1) > plain_scale)
    throw std::invalid_argument(refusal + report::format("it scales by %.9g%s",
                                                         std::sqrt(square),
                                                         rotation.determinant() < 0 ? " and mirrors" : ""));
  throw std::invalid_argument(refusal +
                              report::format("a row's length squared, or two rows' product, is %.3g off a rotation's, "
                                             "and may be %g: write more digits",
                                             error(1),
                                             rigid_tolerance));
}

/// \param m x y z qx qy qz qw, as ROS and TUM's trajectories order them
RigidTransform fromQuaternion(const std::vector<double>& m)
{
  Eigen::Quaterniond quaternion(m[6], m[3], m[4], m[5]);
  const double square = quaternion.squaredNorm();
  if (!(std::abs(square - 1) <= rigid_tolerance))
    throw std::invalid_argument(
        report::format("its quaternion (qx qy qz qw, the last four) has the length %.9g, not 1", std::sqrt(square)));
  quaternion.normalize();
  RigidTransform guess;
  Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(guess.rotation.data()) = quaternion.toRotationMatrix();
  std::copy_n(m.begin(), 3, guess.translation.begin());
  return guess;
}

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

bool asksForSearch(const std::string& argument) { return argument == "auto"; }

bool namesFile(const std::string& argument)
{
  if (asksForSearch(argument))
    return false;
  std::string_view words(argument);
  words.remove_prefix(std::min(words.find_first_not_of(number_separators), words.size()));
  const bool is_array = std::any_of(std::begin(array_names), std::end(array_names), [words](std::string_view name) {
    return words.rfind(std::string(name) + "(", 0) == 0;
  });
  return !is_array && !parseNumber<double>(nextWord(words, " \t\r\n,;")); // "[0]pose.txt" is a name
}

RigidTransform parseGuess(std::string_view text)
{
  const std::vector<double> m = numbersOf(withoutByteOrderMark(text));
  if (m.size() == 7)
    return fromQuaternion(m);
  if (m.size() != 16 && m.size() != 12)
    throw std::invalid_argument(std::to_string(m.size()) +
                                " numbers where a 4x4 matrix has 16, or 12 without its last row, and a position with "
                                "a quaternion (x y z qx qy qz qw) 7");
  if (m.size() == 16)
    checkLastRow(m);
  RigidTransform guess;
  for (int row = 0; row < 3; ++row) {
    std::copy_n(m.begin() + 4 * row, 3, guess.rotation.begin() + 3 * row);
    guess.translation[row] = m[4 * row + 3];
  }
  checkRotation(Rotation(guess.rotation.data()));
  return guess;
}

RigidTransform readGuess(const std::string& argument)
{
  const bool is_file = namesFile(argument);
  try {
    return parseGuess(is_file ? readFile(argument) : argument);
  } catch (const std::invalid_argument& error) {
    if (is_file)
      throw inputFailure("--guess " + argument, error.what());
    throw Failure(ExitCode::Usage, std::string("--guess: ") + error.what());
  }
}

} // namespace pcl_gpu_icp::cli
