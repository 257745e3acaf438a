#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace pcl_gpu_icp::cli {

struct CsvRecord {
  std::size_t line = 0; ///< of the file, from 1, where it starts
  std::vector<std::string> fields;
};

/// The records of comma-separated values as in RFC 4180, and as people and spreadsheets write them: the separator may
/// be a semicolon or a tab, which the first record tells; lines may end in CR or LF alone. Blanks around a value are
/// not part of it, unless it is quoted. Lines without a value, and lines that start with #, are none. \throws Failure
/// (Input) that names the file and the line
std::vector<CsvRecord> readCsv(const std::string& path, std::string_view content);

} // namespace pcl_gpu_icp::cli
