#pragma once

#include "cli/cloud.h"

#include <cstdint>
#include <string>

/// The words of PLY files, as PCL and others write them.
namespace pcl_gpu_icp::cli::ply {

using Field = pcl::PCLPointField;

struct Type {
  const char* name;
  const char* other_name;
  std::uint8_t field_type;
};

inline constexpr Type types[] = {{"char", "int8", Field::INT8},
                                 {"uchar", "uint8", Field::UINT8},
                                 {"short", "int16", Field::INT16},
                                 {"ushort", "uint16", Field::UINT16},
                                 {"int", "int32", Field::INT32},
                                 {"uint", "uint32", Field::UINT32},
                                 {"float", "float32", Field::FLOAT32},
                                 {"double", "float64", Field::FLOAT64}};

/// Names that PCL and PLY spell differently.
inline constexpr const char* renamed_fields[][2] = {{"normal_x", "nx"}, {"normal_y", "ny"}, {"normal_z", "nz"}};

/// Bytes of PCL's packed colour, 0xAARRGGBB in a little-endian word.
inline constexpr const char* colours[] = {"blue", "green", "red", "alpha"};

/// Of a camera as PCL writes it: its place, and the rows of its orientation.
inline constexpr const char* pose_properties[] = {"view_px",
                                                  "view_py",
                                                  "view_pz",
                                                  "x_axisx",
                                                  "x_axisy",
                                                  "x_axisz",
                                                  "y_axisx",
                                                  "y_axisy",
                                                  "y_axisz",
                                                  "z_axisx",
                                                  "z_axisy",
                                                  "z_axisz"};

std::string typeName(std::uint8_t field_type);

/// With its line feed.
std::string propertyLine(const std::string& type, const std::string& name);

} // namespace pcl_gpu_icp::cli::ply
