#include "cli/csv.h"

#include "cli/input_file.h"

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
    while (!rest_.empty()) {
      if (takeLineEnd())
        continue;
      CsvRecord record{line_, {}};
      do
        record.fields.push_back(field());
      while (take(','));
      if (!rest_.empty() && !takeLineEnd())
        fail("text after a closing quote");
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
    const std::size_t length = rest_.substr(0, 2) == "\r\n" ? 2 : rest_.substr(0, 1) == "\n" ? 1 : 0;
    rest_.remove_prefix(length);
    line_ += length > 0;
    return length > 0;
  }

  std::string field()
  {
    if (take('"'))
      return quoted();
    std::string_view text = rest_.substr(0, rest_.find_first_of(",\n"));
    rest_.remove_prefix(text.size());
    if (!rest_.empty() && rest_.front() == '\n' && !text.empty() && text.back() == '\r')
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
      line_ += next == '\n';
      text += next;
    }
    fail("a quote that nothing closes");
  }

  const std::string& path_;
  std::string_view rest_;
  std::size_t line_ = 1;
};

} // namespace

std::vector<CsvRecord> readCsv(const std::string& path, std::string_view content)
{
  return Reader(path, content).read();
}

} // namespace pcl_gpu_icp::cli
