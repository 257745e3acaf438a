#include "cli/foreign_file.h"

#include "cli/input_file.h"
#include "cli/lower_case.h"
#include "cli/number.h"

#include "report/format.h"

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <utility>

namespace pcl_gpu_icp::cli {
namespace {

/// Formats that start with bytes of their own. FILE is the file, NEW one of its name that ends in .pcd, BARE the name
/// without its extension.
struct Signature {
  std::string_view start;
  const char* what;
  const char* remedy;
};

constexpr const char* from_stl = ": pcl_converter -c FILE NEW (package pcl-tools)";

constexpr Signature signatures[] = {
    {"\x1F\x8B", "compressed by gzip", ": gunzip -k FILE"},
    {"BZh", "compressed by bzip2", ": bunzip2 -k FILE"},
    {"\xFD"
     "7zXZ",
     "compressed by xz",
     ": unxz -k FILE"},
    {"\x28\xB5\x2F\xFD", "compressed by zstd", ": zstd -d FILE (package zstd)"},
    {"\x04\x22\x4D\x18", "compressed by lz4", ": lz4 -d FILE BARE (package lz4)"},
    {"7z\xBC\xAF", "a 7z archive", ": 7z x FILE (package p7zip-full)"},
    {"PK\x03\x04", "a zip archive", ": unzip FILE (package unzip)"},
    {"ASTM-E57",
     "an E57 file",
     ": python3 -c \"import sys, numpy, pye57; p = pye57.E57(sys.argv[1]).read_scan(0, ignore_missing_fields=True); "
     "numpy.savetxt(sys.argv[2], numpy.stack([p['cartesian' + a] for a in 'XYZ'], 1), '%.6f')\" FILE BARE.xyz "
     "(pip install pye57)"},
    {"version https://git-lfs", "a Git LFS pointer, not the file itself", ": git lfs pull (package git-lfs)"},
    {"#ROSBAG", "a ROS bag", "; write its clouds as PCD files first"},
    {"solid", "an STL mesh", from_stl},
    {"\xFF\xFE", "a text in UTF-16", ": iconv -f UTF-16 -t UTF-8 FILE > NEW"},
    {"\xFE\xFF", "a text in UTF-16", ": iconv -f UTF-16 -t UTF-8 FILE > NEW"},
};

struct Names {
  std::string file;
  std::string new_file;
  std::string bare;
};

std::string filledIn(std::string text, const Names& names)
{
  for (const auto& [word, name] : {std::pair("FILE", &names.file), {"NEW", &names.new_file}, {"BARE", &names.bare}})
    for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + name->size()))
      text.replace(at, std::string_view(word).size(), *name);
  return text;
}

/// The command that makes a PCD file of lines of text.
std::string headerCommand(const std::string& lines)
{
  return ": (printf 'FIELDS x y z\\nDATA ascii\\n'; " + lines + ") > NEW";
}

/// Lines "v x y z", in the first of the file or behind comments and names of materials.
bool looksLikeObj(std::string_view content)
{
  for (int line_number = 0; line_number < 100 && !content.empty(); ++line_number) {
    std::string_view line = nextLine(content);
    if (nextWord(line) == "v" && parseReal(nextWord(line)) && parseReal(nextWord(line)) && parseReal(nextWord(line)))
      return true;
  }
  return false;
}

/// The lines of its vertices, as sed takes them.
std::optional<std::string> verticesOfOff(std::string_view content)
{
  const char end = lineEnd(content);
  std::string_view line = nextLine(content, end);
  const std::string_view magic = nextWord(line);
  if (magic.size() < 3 || magic.substr(magic.size() - 3) != "OFF")
    return std::nullopt;
  for (std::size_t number = 2; !content.empty(); ++number) {
    line = nextLine(content, end);
    const std::string_view first = nextWord(line);
    if (first.empty() || first.front() == '#')
      continue;
    const auto count = parseNumber<std::uint32_t>(first);
    return count ? std::optional(report::format("%zu,%zu", number + 1, number + *count)) : std::nullopt;
  }
  return std::nullopt;
}

} // namespace

std::optional<std::string> describeForeign(const std::string& path, std::string_view content)
{
  const std::filesystem::path name(path);
  const Names names{shellWord(path),
                    shellWord((name.parent_path() / name.stem()).string() + ".pcd"),
                    shellWord((name.parent_path() / name.stem()).string())};
  const std::string extension = lowerCase(name.extension().string());
  const auto looksLike = [&](const char* what, const std::string& remedy) {
    return std::string("is of a format that is not read; it looks like ") + what +
           (path == standard_input ? "" : filledIn(remedy, names));
  };
  content = withoutByteOrderMark(content);
  for (const Signature& signature : signatures)
    if (content.substr(0, signature.start.size()) == signature.start)
      return looksLike(signature.what, signature.remedy);
  if (const auto lines = verticesOfOff(content))
    return looksLike("an OFF mesh", headerCommand("sed -n " + *lines + "p FILE | cut -d' ' -f1-3"));
  const std::string start = lowerCase(content.substr(0, 512));
  if (start.find("<html") != std::string::npos || start.find("<!doctype html") != std::string::npos)
    return looksLike("an HTML page, as a failed download leaves: download the file itself", "");
  const char first = start[std::min(start.find_first_not_of(" \t\r\n"), start.size())]; // a string ends with '\0'
  if (first == '<' || first == '{' || first == '[')
    return looksLike(first == '<' ? "XML" : "JSON", ", not points");
  if (extension == ".stl")
    return looksLike("an STL mesh", from_stl);
  if (looksBinary(content))
    return "is of a format that is not read, nor known by its first bytes; convert it to PCD or PLY";
  if (looksLikeObj(content))
    return looksLike("an OBJ mesh", ": pcl_obj2pcd FILE NEW (package pcl-tools)");
  if (extension == ".pcd" || extension == ".ply")
    return "is not a PCD or PLY file: it has neither the line FIELDS of the one nor the first line 'ply' of the other; "
           "the name of a text whose lines are points must end otherwise, such as in .xyz";
  return std::nullopt;
}

} // namespace pcl_gpu_icp::cli
