// Text and numbers as they stand in report.html. Whatever comes from a file passes Escape().
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace orient {

// Safe as element content and inside double-quoted attributes, of HTML and of XML: markup is
// escaped; what is not UTF-8, or a character that XML forbids, becomes U+FFFD.
std::string Escape(std::string_view text);

// Valid UTF-8 with the same replacements, without escaping markup.
std::string ValidText(std::string_view text);

// What an empty optional and a number that is not finite look like.
inline constexpr const char* kNoValue = "–";

// Narrow, and no line breaks there: between a number and its unit.
inline constexpr const char* kThinSpace = "\u202F";

// Fixed decimals with a real minus sign, never "-0.00".
std::string Decimal(double number, int decimals);
std::string Decimal(const std::optional<double>& number, int decimals);

// "x / y / z".
std::string Decimals(const Eigen::Vector3d& numbers, int decimals);

// The same as Decimal() with thin spaces between thousands: 5 000 321.
std::string Grouped(double number, int decimals);

// Decimals that show two significant digits of a sigma, from 0 to 9: 0.42 -> 2, 0.0031 -> 4.
int DecimalsForSigma(double sigma);

// As a coordinate of an SVG: at most `decimals`, no trailing zeros, ASCII.
std::string SvgNumber(double number, int decimals = 1);

std::string Joined(const std::vector<std::string>& texts, std::string_view between = "; ");

// A relative link to a file in the report's own folder.
std::string PercentEncoded(std::string_view file_name);
// The same to a file in a folder below: its separators stay.
std::string PercentEncodedPath(std::string_view path);

}  // namespace orient
