#include "cli/vtk.h"

#include "cli/input_file.h"
#include "cli/lower_case.h"
#include "cli/number.h"

#include <algorithm>
#include <cctype>

namespace pcl_gpu_icp::cli {
namespace {

constexpr std::string_view magic = "# vtk DataFile";
constexpr std::string_view blanks = " \t\r\n";

class Reader {
public:
  Reader(const std::string& path, std::string_view content)
  : path_(path)
  , rest_(content)
  {
  }

  Cloud read()
  {
    nextLine(rest_); // the version
    nextLine(rest_); // the title
    const std::string encoding = keyword();
    if (encoding != "ascii" && encoding != "binary")
      fail("its third line is neither ASCII nor BINARY");
    if (keyword() != "dataset")
      fail("its fourth line is no DATASET");
    const std::string dataset = keyword();
    if (dataset != "polydata" && dataset != "unstructured_grid")
      fail("its DATASET " + dataset + " is not read; POLYDATA and UNSTRUCTURED_GRID are");
    readLayout();
    if (encoding == "ascii")
      readAscii();
    else
      readBinary();
    checkEnd();
    return std::move(cloud_);
  }

private:
  static constexpr std::size_t axes = 3;

  [[noreturn]] void fail(const std::string& why) const { throw inputFailure(path_, why); }

  [[noreturn]] void failPromise() const
  {
    fail("its POINTS are not as many as the " + std::to_string(cloud_.size()) + " that it promises");
  }

  /// The next word, in lower case.
  std::string keyword() { return lowerCase(nextWord(rest_, blanks).substr(0, 40)); }

  void readLayout()
  {
    if (keyword() != "points")
      fail("has no POINTS behind its DATASET");
    const auto count = parseNumber<std::size_t>(nextWord(rest_, blanks));
    if (!count)
      fail("the number of its POINTS is no whole number");
    const std::string type = keyword();
    if (type != "float" && type != "double")
      fail("POINTS of the type " + type + " are not read; float and double are");
    nextLine(rest_); // to its end
    addCoordinates(cloud_, path_, type == "float" ? pcl::PCLPointField::FLOAT32 : pcl::PCLPointField::FLOAT64);
    cloud_.setSize(*count, 1, path_);
    constexpr std::size_t least_bytes_per_value = 2;
    if ((rest_.size() + 1) / least_bytes_per_value / axes < cloud_.size())
      failPromise();
    cloud_.data.data.resize(cloud_.size() * cloud_.data.point_step);
  }

  std::size_t valueSize() const { return cloud_.data.point_step / axes; }

  void readAscii()
  {
    const std::uint8_t type = cloud_.data.fields.front().datatype;
    std::uint8_t* to = cloud_.data.data.data();
    for (std::size_t i = 0; i < axes * cloud_.size(); ++i, to += valueSize()) {
      const std::string_view word = nextWord(rest_, blanks);
      if (word.empty())
        failPromise();
      if (storeNumber(word, type, to) == Stored::No)
        fail("point " + std::to_string(i / axes + 1) + ", " + "xyz"[i % axes] + ": '" +
             std::string(word.substr(0, 40)) + "' is not a number");
    }
  }

  /// Big-endian.
  void readBinary()
  {
    auto& data = cloud_.data.data;
    if (rest_.size() < data.size())
      failPromise();
    for (std::size_t at = 0; at < data.size(); at += valueSize())
      std::reverse_copy(rest_.begin() + static_cast<std::ptrdiff_t>(at),
                        rest_.begin() + static_cast<std::ptrdiff_t>(at + valueSize()),
                        data.begin() + static_cast<std::ptrdiff_t>(at));
    rest_.remove_prefix(data.size());
  }

  /// Behind the points there is nothing, or a key word.
  void checkEnd()
  {
    const std::string_view word = nextWord(rest_, blanks);
    if (!word.empty() && (!std::isalpha(static_cast<unsigned char>(word.front())) || parseReal(word)))
      failPromise();
  }

  const std::string& path_;
  std::string_view rest_;
  Cloud cloud_;
};

} // namespace

bool isVtk(std::string_view content) { return content.substr(0, magic.size()) == magic; }

Cloud readVtk(const std::string& path, std::string_view content) { return Reader(path, content).read(); }

} // namespace pcl_gpu_icp::cli
