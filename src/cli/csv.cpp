#include "cli/csv.h"

#include "cli/input_file.h"

#include <algorithm>

namespace pcl_gpu_icp::cli {
namespace {

class Reader {
public:
  Reader(const std::string& path, std::string_view content)
  : path_(path)
  , rest_(content)
  {
  }

  std::vector<CsvRecord> read()
  {
    std::vector<CsvRecord> records;
    while (skipToRecord()) {
      if (records.empty())
        separator_ = separatorOfLine();
      CsvRecord record{line_, {}};
      do
        record.fields.push_back(field());
      while (take(separator_));
      if (!rest_.empty() && !takeLineEnd())
        fail("text after a closing quote");
      if (std::any_of(record.fields.begin(), record.fields.end(), [](const auto& text) { return !text.empty(); }))
        records.push_back(std::move(record));
    }
    return records;
  }

private:
  [[noreturn]] void fail(const std::string& why) const { throw inputFailure(path_ + ":" + std::to_string(line_), why); }

  bool take(char expected)
  {
    if (rest_.empty() || rest_.front() != expected)
      return false;
    rest_.remove_prefix(1);
    return true;
  }

  bool takeLineEnd()
  {
    const std::size_t length = rest_.substr(0, 2) == "\r\n" ? 2 : rest_.find_first_of("\r\n") == 0 ? 1 : 0;
    rest_.remove_prefix(length);
    line_ += length > 0;
    return length > 0;
  }

  void skipBlanks()
  {
    while (!rest_.empty() && isBlank(rest_.front()))
      rest_.remove_prefix(1);
  }

  bool isBlank(char c) const { return c == ' ' || (c == '\t' && separator_ != '\t'); }

  /// \return whether there is one
  bool skipToRecord()
  {
    do {
      const auto first = rest_.find_first_not_of(" \t");
      if (first != std::string_view::npos && rest_[first] == '#')
        rest_.remove_prefix(std::min(rest_.find_first_of("\r\n"), rest_.size()));
    } while (takeLineEnd());
    return !rest_.empty();
  }

  /// The first that is outside quotes.
  char separatorOfLine() const
  {
    bool is_quoted = false;
    for (const char c : rest_) {
      if (c == '"')
        is_quoted = !is_quoted;
      else if (!is_quoted && (c == ',' || c == ';' || c == '\t'))
        return c;
      else if (!is_quoted && (c == '\r' || c == '\n'))
        break;
    }
    return ',';
  }

  std::string field()
  {
    skipBlanks();
    if (take('"')) {
      std::string text = quoted();
      skipBlanks();
      return text;
    }
    const char ends[] = {separator_, '\r', '\n', '\0'};
    std::string_view text = rest_.substr(0, rest_.find_first_of(ends));
    rest_.remove_prefix(text.size());
    while (!text.empty() && isBlank(text.back()))
      text.remove_suffix(1);
    return std::string(text);
  }

  std::string quoted()
  {
    std::string text;
    while (!rest_.empty()) {
      const char next = rest_.front();
      rest_.remove_prefix(1);
      if (next == '"' && !take('"'))
        return text;
      line_ += next == '\n' || (next == '\r' && rest_.substr(0, 1) != "\n");
      text += next;
    }
    fail("a quote that nothing closes");
  }

  const std::string& path_;
  std::string_view rest_;
  char separator_ = ',';
  std::size_t line_ = 1;
};

} // namespace

std::vector<CsvRecord> readCsv(const std::string& path, std::string_view content)
{
  return Reader(path, content).read();
}

} // namespace pcl_gpu_icp::cli
