#include "cli/ply.h"
#include "cli/ply_format.h"

#include "cli/failure.h"

#include <algorithm>
#include <cstring>

namespace pcl_gpu_icp::cli {

std::string ply::propertyLine(const std::string& type, const std::string& name)
{
  return "property " + type + " " + name + "\n";
}

std::string ply::typeName(std::uint8_t field_type)
{
  for (const Type& type : types)
    if (type.field_type == field_type)
      return type.name;
  return fieldKind(field_type) == 'I' ? "int64" : "uint64"; // not of PLY: only written where it was read
}

namespace {

using namespace ply;

bool isPackedColour(const Field& field)
{
  return (field.name == "rgb" || field.name == "rgba") && fieldSize(field.datatype) == 4 && field.count == 1;
}

std::string propertyLines(const Field& field)
{
  const auto type = std::find_if(std::begin(types), std::end(types), [&field](const Type& candidate) {
    return candidate.field_type == field.datatype;
  });
  if (type == std::end(types))
    throw Failure(ExitCode::Output,
                  "field " + field.name + " has 8-byte integers, which PLY does not have; write .pcd");
  std::string name = field.name;
  for (const auto& renamed : renamed_fields)
    if (name == renamed[0])
      name = renamed[1];
  if (field.count == 1)
    return propertyLine(type->name, name);
  std::string lines;
  for (std::uint32_t i = 0; i < field.count; ++i)
    lines += propertyLine(type->name, name + "_" + std::to_string(i));
  return lines;
}

/// The pose of a PCD file has no other place.
bool needsCamera(const Cloud& cloud)
{
  return cloud.has_pose && std::none_of(cloud.elements.begin(), cloud.elements.end(), [](const OtherElement& element) {
           return element.pose_at.has_value();
         });
}

/// What pcl::PLYWriter has behind the pose.
constexpr const char* lens_properties[] = {"focal", "scalex", "scaley", "centerx", "centery"};
constexpr const char* viewport_properties[] = {"viewportx", "viewporty"};
constexpr const char* distortion_properties[] = {"k1", "k2"};

std::string cameraHeader()
{
  std::string header = "element camera 1\n";
  for (const char* name : pose_properties)
    header += propertyLine("float", name);
  for (const char* name : lens_properties)
    header += propertyLine("float", name);
  for (const char* name : viewport_properties)
    header += propertyLine("int", name);
  for (const char* name : distortion_properties)
    header += propertyLine("float", name);
  return header;
}

std::string cameraBody(const Cloud& cloud)
{
  std::string body;
  const auto add = [&body](auto value) { body.append(reinterpret_cast<const char*>(&value), sizeof value); };
  for (int axis = 0; axis < 3; ++axis)
    add(cloud.sensor_origin[axis]);
  const Eigen::Matrix3f rows = cloud.sensor_orientation.toRotationMatrix();
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column)
      add(rows(row, column));
  body.append(sizeof(float) * std::size(lens_properties), '\0');
  add(static_cast<std::int32_t>(cloud.data.width));
  add(static_cast<std::int32_t>(cloud.data.height));
  return body.append(sizeof(float) * std::size(distortion_properties), '\0');
}

} // namespace

std::string plyHeader(const Cloud& cloud)
{
  std::string header = "ply\nformat binary_little_endian 1.0\n";
  for (const std::string& comment : cloud.comments)
    header += comment + "\n";
  if (cloud.data.height > 1)
    header += "obj_info num_cols " + std::to_string(cloud.data.width) + "\nobj_info num_rows " +
              std::to_string(cloud.data.height) + "\n";
  const auto addElements = [&](bool before_vertices) {
    for (const OtherElement& element : cloud.elements)
      if (element.before_vertices == before_vertices)
        header += element.header;
  };
  addElements(true);
  header += "element vertex " + std::to_string(cloud.size()) + "\n";
  for (const Field& field : cloud.data.fields) {
    if (field.name == padding)
      continue;
    if (!isPackedColour(field)) {
      header += propertyLines(field);
      continue;
    }
    for (const char* colour : {"red", "green", "blue"})
      header += propertyLine("uchar", colour);
    if (field.name == "rgba")
      header += propertyLine("uchar", "alpha");
  }
  addElements(false);
  if (needsCamera(cloud))
    header += cameraHeader();
  return header + "end_header\n";
}

std::string writePly(const Cloud& cloud)
{
  static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "the bytes of the points are written as they are");
  std::string content = plyHeader(cloud);
  const auto addElements = [&](bool before_vertices) {
    for (const OtherElement& element : cloud.elements)
      if (element.before_vertices == before_vertices)
        content += element.body;
  };
  content.reserve(content.size() + cloud.data.data.size());
  addElements(true);
  const auto* point = reinterpret_cast<const char*>(cloud.data.data.data());
  for (std::size_t i = 0; i < cloud.size(); ++i, point += cloud.data.point_step)
    for (const Field& field : cloud.data.fields) {
      const char* value = point + field.offset;
      if (isPackedColour(field)) {
        const char rgba[] = {value[2], value[1], value[0], value[3]};
        content.append(rgba, field.name.size());
      }
      else if (field.name != padding) {
        content.append(value, fieldSize(field.datatype) * field.count);
      }
    }
  addElements(false);
  if (needsCamera(cloud))
    content += cameraBody(cloud);
  return content;
}

} // namespace pcl_gpu_icp::cli
