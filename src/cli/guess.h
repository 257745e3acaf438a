#pragma once

#include <pcl_gpu_icp/rigid_transform.h>

#include <array>
#include <string>
#include <string_view>
#include <vector>

namespace pcl_gpu_icp::cli {

/// Joins the numbers that follow --guess into one argument, so that they cannot be taken for file names, nor file names
/// for them.
std::vector<std::string> joinGuess(std::vector<std::string> arguments);

/// Whether such an argument asks for a guess to be searched for; a file of that name is ./auto.
bool asksForSearch(const std::string& argument);

/// Whether it is the name of a file, and not numbers.
bool namesFile(const std::string& argument);

/// The rigid transform that a text has: a 4x4 matrix row by row, whose last row may be left out, with blanks, commas,
/// semicolons or brackets between its numbers, or x y z qx qy qz qw. What follows a # on a line is a comment; a time of
/// day is none of its numbers. Its rotation may have been written with few digits.
/// \throws std::invalid_argument that says what else it looks like
RigidTransform parseGuess(std::string_view text);

/// The guess that an argument gives: a file name or numbers.
/// \throws Failure (Usage) for numbers, (Input) for a file, that are not a rigid transform
RigidTransform readGuess(const std::string& argument);

} // namespace pcl_gpu_icp::cli
