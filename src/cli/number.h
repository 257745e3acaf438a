#pragma once

#include <algorithm>
#include <charconv>
#include <optional>
#include <string_view>

namespace pcl_gpu_icp::cli {

/// What a text file may start with.
constexpr std::string_view byte_order_mark = "\xEF\xBB\xBF";

inline std::string_view withoutByteOrderMark(std::string_view text)
{
  if (text.substr(0, byte_order_mark.size()) == byte_order_mark)
    text.remove_prefix(byte_order_mark.size());
  return text;
}

/// The number that the whole text spells, whatever the locale; "nan" and "inf" are numbers too.
template <typename Number>
std::optional<Number> parseNumber(std::string_view text)
{
  if (!text.empty() && text.front() == '+')
    text.remove_prefix(1);
  Number value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size())
    return std::nullopt;
  return value;
}

/// What stands between the numbers of a list or a matrix, also as numpy and MATLAB print one.
constexpr std::string_view number_separators = " \t\r\n,;[]()";

/// Takes the next word off the front of `text`; empty when there is none.
inline std::string_view nextWord(std::string_view& text, std::string_view separators = " \t\r")
{
  text.remove_prefix(std::min(text.find_first_not_of(separators), text.size()));
  const std::string_view word = text.substr(0, text.find_first_of(separators));
  text.remove_prefix(word.size());
  return word;
}

/// Takes the next line off the front of `text`, without its line feed.
inline std::string_view nextLine(std::string_view& text)
{
  const std::string_view line = text.substr(0, text.find('\n'));
  text.remove_prefix(std::min(line.size() + 1, text.size()));
  return line;
}

} // namespace pcl_gpu_icp::cli
