#include "cli/number.h"

#include "cli/lower_case.h"

#include <clocale>
#include <cstdlib>
#include <limits>
#include <locale.h>

namespace pcl_gpu_icp::cli {
namespace {

bool spellsNoValue(std::string text)
{
  if (!text.empty() && (text[0] == '-' || text[0] == '+'))
    text.erase(0, 1);
  for (const char* name : {"nan", "none", "null", "n/a", "1.#qnan", "1.#snan", "1.#ind"})
    // With zeros behind, as printf of Windows pads them, or what kind of NaN it is.
    if (text.rfind(name, 0) == 0 &&
        text.find_first_not_of(name[0] == '1' ? "0" : "", std::string_view(name).size()) == std::string::npos)
      return true;
  return text == "nan(ind)" || text == "nan(snan)" || text == "qnan" || text == "snan";
}

} // namespace

std::optional<double> parseReal(std::string_view text)
{
  if (const auto value = parseNumber<double>(text))
    return value;
  std::string spelled = lowerCase(text);
  constexpr std::size_t longest = 4096;
  if (spelled.empty() || spelled.size() > longest)
    return std::nullopt;
  if (spellsNoValue(spelled))
    return std::numeric_limits<double>::quiet_NaN();
  for (const char* infinity : {"1.#inf", "+1.#inf", "-1.#inf"})
    if (spelled.rfind(infinity, 0) == 0 &&
        spelled.find_first_not_of('0', std::string_view(infinity).size()) == std::string::npos)
      spelled = infinity[0] == '-' ? "-inf" : "inf";
  const bool hexadecimal = spelled.find("0x") <= 1;
  const std::size_t exponent = spelled.find('d');
  if (!hexadecimal && exponent != std::string::npos)
    spelled[exponent] = 'e';
  static const locale_t c_locale = newlocale(LC_ALL_MASK, "C", nullptr);
  char* end = nullptr;
  const double value = strtod_l(spelled.c_str(), &end, c_locale);
  if (end != spelled.c_str() + spelled.size())
    return std::nullopt;
  return value;
}

} // namespace pcl_gpu_icp::cli
