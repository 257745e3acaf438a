#pragma once

#include <algorithm>
#include <charconv>
#include <optional>
#include <string>
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

/// The real number that a value of a file spells, in any of the spellings of C, Fortran (1d0), Windows (1.#QNAN,
/// -1.#IND) and of what has no value (None, null). Beyond double it is infinite, or zero.
std::optional<double> parseReal(std::string_view text);

/// Takes the next word off the front of `text`; empty when there is none.
inline std::string_view nextWord(std::string_view& text, std::string_view separators = " \t\r")
{
  text.remove_prefix(std::min(text.find_first_not_of(separators), text.size()));
  const std::string_view word = text.substr(0, text.find_first_of(separators));
  text.remove_prefix(word.size());
  return word;
}

/// What ends the lines of a text: a carriage return where the first of them ends with that alone, or a line feed.
inline char lineEnd(std::string_view text)
{
  const std::size_t end = text.find_first_of("\r\n");
  return end != std::string_view::npos && text[end] == '\r' && text.substr(end + 1, 1) != "\n" ? '\r' : '\n';
}

/// Takes the next line off the front of `text`, without its end.
inline std::string_view nextLine(std::string_view& text, char end = '\n')
{
  const std::string_view line = text.substr(0, text.find(end));
  text.remove_prefix(std::min(line.size() + 1, text.size()));
  return line;
}

} // namespace pcl_gpu_icp::cli
