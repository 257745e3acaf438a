#pragma once

#include "cli/warnings.h"

#include <pcl/PCLPointCloud2.h>

#include <Eigen/Geometry>

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace pcl_gpu_icp::cli {

/// An element of a PLY file other than its vertices, as it is written again.
struct OtherElement {
  std::string name;
  std::size_t count = 0;
  std::string header; ///< its lines in the header, with their line feeds
  std::string body;   ///< its values, binary and little-endian
  bool before_vertices = false;
  /// Of a camera as PCL writes it: where in the body its place and the rows of its orientation are, 12 floats.
  std::optional<std::size_t> pose_at;
};

/// A point cloud as its file has it: every field in its own type.
struct Cloud {
  pcl::PCLPointCloud2 data;
  Eigen::Vector4f sensor_origin = Eigen::Vector4f::Zero(); ///< a PCD file's VIEWPOINT, PLY's camera
  Eigen::Quaternionf sensor_orientation = Eigen::Quaternionf::Identity();
  bool has_pose = false; ///< the file has another pose of the sensor than PCL's default
  std::vector<OtherElement> elements;
  std::vector<std::string> comments; ///< lines of the header as PLY has them, "comment ..." and "obj_info ..."
  Warnings warnings;                 ///< what of the file was read otherwise than it stands there

  EIGEN_MAKE_ALIGNED_OPERATOR_NEW

  /// \throws Failure (Input) where the file has no points, points have no bytes, or more than PCL's 32-bit sizes can
  /// say
  void setSize(std::size_t width, std::size_t height, const std::string& path);
  std::size_t size() const { return std::size_t(data.width) * data.height; }
};

/// The name of fields that hold nothing, as PCL has it.
constexpr const char* padding = "_";

struct Coordinates {
  std::vector<std::array<double, 3>> points;
  bool from_double = false; ///< a coordinate had more digits than float has
};

/// A scalar type of a field.
/// \return 0 where this PCL has no such field type
std::uint8_t fieldType(char kind /* I, U or F */, std::size_t size);

/// Its kind: I, U or F.
char fieldKind(std::uint8_t type);

/// Bytes of a scalar of that type.
std::size_t fieldSize(std::uint8_t type);

/// Appends a field to the layout of the points.
/// \throws Failure (Input) that names the bound, where there are too many fields or points get too wide
void addField(Cloud& cloud, const std::string& path, const std::string& name, std::uint8_t type, std::size_t count = 1);
/// x, y and z, of the same type.
void addCoordinates(Cloud& cloud, const std::string& path, std::uint8_t type);

enum class Stored { No, Nearly, Exactly };

/// Parses one ASCII value into a field's place. What an integer type does not hold becomes its nearest value, NaN
/// becomes 0, and what it holds with the other sign keeps its bits: all of them Nearly.
/// \return No where the text is no number
Stored storeNumber(std::string_view text, std::uint8_t type, std::uint8_t* to);

/// Stores the ASCII values of points, and keeps count of what their types do not hold.
class ValueStore {
public:
  explicit ValueStore(Cloud& cloud)
  : cloud_(cloud)
  , inexact_(cloud.data.fields.size())
  {
  }

  /// \return whether the text is a number; of a coordinate one that its type holds
  /// \param type of the value, which may be a byte of the field
  bool store(std::string_view text, std::size_t field, std::uint8_t type, std::uint8_t* to);

  /// Tells the cloud of them.
  void warn(const std::string& path);

private:
  Cloud& cloud_;
  std::vector<std::size_t> inexact_; ///< values by field
};

/// Why a value cannot be read, and what helps.
std::string whyNoNumber(std::string_view value, std::string_view rest_of_row, const std::string& path);

/// Makes x, y and z that are integers double, so that they can be moved.
void widenCoordinates(Cloud& cloud, const std::string& path);

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

/// \throws Failure (Input) that names the file and the field, where x, y or z is missing or is not one number
Coordinates coordinates(const Cloud& cloud, const std::string& path);

} // namespace pcl_gpu_icp::cli
