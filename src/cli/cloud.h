#pragma once

#include <pcl/PCLPointCloud2.h>

#include <Eigen/Geometry>

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace pcl_gpu_icp::cli {

/// A point cloud as its file has it: every field in its own type.
struct Cloud {
  pcl::PCLPointCloud2 data;
  Eigen::Vector4f sensor_origin = Eigen::Vector4f::Zero(); ///< a PCD file's VIEWPOINT
  Eigen::Quaternionf sensor_orientation = Eigen::Quaternionf::Identity();

  EIGEN_MAKE_ALIGNED_OPERATOR_NEW

  /// \throws Failure (Input) where the file has no points, or more than PCL's 32-bit sizes can say
  void setSize(std::size_t width, std::size_t height, const std::string& path);
  std::size_t size() const { return std::size_t(data.width) * data.height; }
};

struct Coordinates {
  std::vector<std::array<double, 3>> points;
  bool from_double = false; ///< a coordinate had more digits than float has
};

/// A scalar type of a field.
/// \return 0 where this PCL has no such field type
std::uint8_t fieldType(char kind /* I, U or F */, std::size_t size);

/// Bytes of a scalar of that type.
std::size_t fieldSize(std::uint8_t type);

/// Appends a field to the layout of the points.
void addField(pcl::PCLPointCloud2& cloud, const std::string& name, std::uint8_t type, std::uint32_t count = 1);

/// Parses one ASCII value into a field's place.
/// \return whether the text is a number that the type holds
bool storeNumber(std::string_view text, std::uint8_t type, std::uint8_t* to);

/// Three float or double fields of every point, read and written as double.
class VectorField {
public:
  /// Nothing where one of the fields is missing or is neither one float nor one double.
  static std::optional<VectorField> find(const Cloud& cloud, const std::array<std::string, 3>& names);

  std::array<double, 3> get(const std::uint8_t* point) const;
  void set(std::uint8_t* point, const std::array<double, 3>& value) const;
  bool hasDouble() const;

private:
  std::array<pcl::PCLPointField, 3> fields_;
};

/// \throws Failure (Input) that names the file and the field, where x, y or z is missing or is neither float nor double
Coordinates coordinates(const Cloud& cloud, const std::string& path);

} // namespace pcl_gpu_icp::cli
