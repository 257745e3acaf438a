#include "cli/manifest.h"

#include "cli/csv.h"
#include "cli/guess.h"
#include "cli/input_file.h"
#include "cli/lower_case.h"
#include "cli/nearest_name.h"
#include "cli/number.h"

#include "report/json_members.h"

#include <algorithm>
#include <filesystem>
#include <stdexcept>

namespace pcl_gpu_icp::cli {
namespace {

namespace fs = std::filesystem;

/// Turns lines into pairs.
class Manifest {
public:
  Manifest(const std::string& path, const OptionTexts& defaults, PairOptions& options)
  : path_(path)
  , folder_(fs::path(path).parent_path())
  , defaults_(defaults)
  , options_(options)
  {
  }

  [[noreturn]] void fail(std::size_t line, const std::string& why) const
  {
    throw inputFailure(path_ + ":" + std::to_string(line), why);
  }

  void checkColumn(std::size_t line, const std::string& name) const
  {
    if (name == "source" || name == "target" || options_.has(name))
      return;
    std::vector<std::string> names = options_.names();
    names.insert(names.end(), {"source", "target"});
    fail(line,
         "there is no column " + (name.empty() ? "without a name" : name) +
             ": source, target and the options of a pair are" + didYouMean(name, names));
  }

  void add(std::size_t line, std::map<std::string, std::string> columns)
  {
    for (const auto& [name, text] : columns)
      if (text.find('\0') != std::string::npos)
        fail(line, name + " has a NUL character");
    ListedPair pair;
    pair.identity.pair = pairs_.size();
    pair.identity.source = take(line, columns, "source");
    pair.identity.target = take(line, columns, "target");
    OptionTexts& options = pair.identity.options = defaults_;
    for (const auto& [name, text] : columns) {
      checkColumn(line, name);
      try {
        options[name] = options_.checked(name, text);
      } catch (const std::invalid_argument& error) {
        fail(line, error.what());
      }
    }
    pair.alignment = options_.parse(options);
    pair.alignment.source = found(pair.identity.source);
    pair.alignment.target = found(pair.identity.target);
    auto& guess = pair.alignment.guess;
    if (columns.count("guess") > 0 && namesFile(*guess))
      guess = found(*guess);
    pairs_.push_back(std::move(pair));
  }

  std::vector<ListedPair> pairs() &&
  {
    if (pairs_.empty())
      throw inputFailure(path_, "has no pairs");
    return std::move(pairs_);
  }

private:
  std::string take(std::size_t line, std::map<std::string, std::string>& columns, const char* name) const
  {
    const auto column = columns.find(name);
    if (column == columns.end() || column->second.empty())
      fail(line, std::string("has no ") + name);
    std::string text = std::move(column->second);
    columns.erase(column);
    return text;
  }

  std::string found(const std::string& file) const { return (folder_ / file).string(); }

  const std::string& path_;
  const fs::path folder_;
  const OptionTexts& defaults_;
  PairOptions& options_;
  std::vector<ListedPair> pairs_;
};

void readRecords(Manifest& manifest, const std::vector<CsvRecord>& records)
{
  if (records.empty())
    return;
  std::vector<std::string> names;
  for (const std::string& name : records.front().fields)
    names.push_back(lowerCase(name));
  for (auto name = names.begin(); name != names.end(); ++name) {
    manifest.checkColumn(records.front().line, *name);
    if (std::find(names.begin(), name, *name) != name)
      manifest.fail(records.front().line, "has the column " + *name + " twice");
  }
  for (const char* name : {"source", "target"})
    if (std::find(names.begin(), names.end(), name) == names.end())
      manifest.fail(records.front().line, std::string("has no column ") + name);

  for (auto record = records.begin() + 1; record != records.end(); ++record) {
    if (record->fields.size() != names.size())
      manifest.fail(record->line,
                    "has " + std::to_string(record->fields.size()) + " fields where the header has " +
                        std::to_string(names.size()));
    std::map<std::string, std::string> columns;
    for (std::size_t i = 0; i < names.size(); ++i)
      if (!record->fields[i].empty())
        columns[names[i]] = record->fields[i];
    manifest.add(record->line, std::move(columns));
  }
}

void readObjects(Manifest& manifest, std::string_view content)
{
  for (std::size_t line = 1; !content.empty(); ++line) {
    const std::string_view text = nextLine(content);
    if (text.find_first_not_of(" \t\r") == std::string_view::npos)
      continue;
    std::map<std::string, std::string> members;
    try {
      members = report::jsonMembers(text);
    } catch (const std::invalid_argument& error) {
      manifest.fail(line, error.what());
    }
    std::map<std::string, std::string> columns;
    for (auto& [name, text_of_member] : members)
      if (!columns.emplace(lowerCase(name), std::move(text_of_member)).second)
        manifest.fail(line, "has " + lowerCase(name) + " twice");
    manifest.add(line, std::move(columns));
  }
}

} // namespace

std::vector<ListedPair> readManifest(const std::string& path, const OptionTexts& defaults)
{
  PairOptions options;
  return parseManifest(path, readFile(path), defaults, options);
}

std::vector<ListedPair>
parseManifest(const std::string& path, std::string_view content, const OptionTexts& defaults, PairOptions& options)
{
  const std::string extension = lowerCase(fs::path(path).extension().string());
  const bool is_csv = extension == ".csv";
  if (!is_csv && extension != ".jsonl" && extension != ".json-lines" && extension != ".ndjson")
    throw inputFailure(path, "is neither .csv nor .jsonl");
  content = withoutByteOrderMark(content);
  const auto before_nul = content.substr(0, content.find('\0'));
  if (before_nul.size() < content.size())
    throw inputFailure(path + ":" + std::to_string(std::count(before_nul.begin(), before_nul.end(), '\n') + 1),
                       "has a NUL byte; a manifest is text in UTF-8");
  Manifest manifest(path, defaults, options);
  if (is_csv)
    readRecords(manifest, readCsv(path, content));
  else
    readObjects(manifest, content);
  return std::move(manifest).pairs();
}

} // namespace pcl_gpu_icp::cli
