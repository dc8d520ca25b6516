#include <fmt/format.h>

#include <array>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <stdexcept>

#include "core/base/atomic_write.h"
#include "core/files/camera_file.h"
#include "core/geometry/rotation.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

// The shortest text that reads back as the same number; always with a point or an exponent.
std::string Text(double number) {
  if (!std::isfinite(number)) throw std::invalid_argument("WriteCameraFile: a value is not finite");
  std::array<char, 40> buffer;
  const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), number).ptr;
  std::string text(buffer.data(), end);
  return text.find_first_of(".e") == std::string::npos ? text + ".0" : text;
}

std::string Text(const std::string& words) {
  std::string quoted = "\"";
  for (const char c : words) {
    constexpr std::string_view kHex = "0123456789ABCDEF";
    const auto code = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') quoted += '\\';
    if (code < 0x20 || code == 0x7f)
      quoted += std::string("\\u00") + kHex[code >> 4] + kHex[code & 15];
    else
      quoted += c;
  }
  return quoted + "\"";
}

template <typename Numbers>
std::string List(const Numbers& numbers) {
  std::string text;
  for (const double number : numbers) text += (text.empty() ? "" : ", ") + Text(number);
  return fmt::format("[{}]", text);
}

std::string Text(const Eigen::Vector2d& vector) { return List(std::array{vector.x(), vector.y()}); }

struct DistortionText {
  std::string operator()(std::monostate) const { return ""; }
  std::string operator()(const BrownDistortion& brown) const {
    return fmt::format("\n[distortion]\nmodel = \"brown\"\nk = {}\np = {}\n", List(brown.k),
                       List(brown.p));
  }
  std::string operator()(const RadialTable& table) const {
    return fmt::format("\n[distortion]\nmodel = \"radial_table\"\nradius_mm = {}\ndr_um = {}\n",
                       List(table.radius_mm), List(table.dr_um));
  }
};

std::string PlaceText(const Eigen::Vector2d& at_mm) {
  return at_mm.isZero(0) ? "" : ", at_mm = " + Text(at_mm);
}

std::string AngleText(double angle_rad) { return ", angle_deg = " + Text(DegFromRad(angle_rad)); }

struct ShapeText {
  std::string operator()(const CrossElement& cross) const {
    return fmt::format("\"cross\", length_mm = {}, width_mm = {}, gap_mm = {}{}{}",
                       Text(cross.length_mm), Text(cross.width_mm), Text(cross.gap_mm),
                       AngleText(cross.angle_rad), PlaceText(cross.at_mm));
  }
  std::string operator()(const DotElement& dot) const {
    return "\"dot\", diameter_mm = " + Text(dot.diameter_mm) + PlaceText(dot.at_mm);
  }
  std::string operator()(const CircleElement& circle) const {
    return fmt::format("\"circle\", diameter_mm = {}, width_mm = {}{}", Text(circle.diameter_mm),
                       Text(circle.width_mm), PlaceText(circle.at_mm));
  }
  std::string operator()(const LineElement& line) const {
    return fmt::format("\"line\", from_mm = {}, to_mm = {}, width_mm = {}", Text(line.from_mm),
                       Text(line.to_mm), Text(line.width_mm));
  }
  std::string operator()(const WedgeElement& wedge) const {
    return fmt::format("\"wedge\", base_mm = {}, depth_mm = {}{}{}", Text(wedge.base_mm),
                       Text(wedge.depth_mm), AngleText(wedge.angle_rad), PlaceText(wedge.at_mm));
  }
  std::string operator()(const CheckerElement& checker) const {
    return fmt::format("\"checker\", size_mm = {}{}{}", Text(checker.size_mm),
                       AngleText(checker.angle_rad), PlaceText(checker.at_mm));
  }
  std::string operator()(const PolygonElement& polygon) const {
    std::string points;
    for (const Eigen::Vector2d& point : polygon.points_mm) {
      points += points.empty() ? "" : ", ";
      points += Text(point);
    }
    return fmt::format("\"polygon\", points_mm = [{}]{}", points,
                       polygon.open ? ", open = true" : "");
  }
};

std::string CameraText(const Camera& camera) {
  std::string text = fmt::format("name = {}\nkind = ", Text(camera.name));
  text += camera.kind == CameraKind::kFilm ? "\"film\"" : "\"digital\"";
  text += "\nprincipal_distance_mm = " + Text(camera.principal_distance_mm);
  text += "\nprincipal_point_mm = " + Text(camera.principal_point_mm);
  text += "\nframe_mm = " + Text(camera.frame_mm);
  text += "\nframe_centre_mm = " + Text(camera.frame_centre_mm);
  if (camera.image_px)
    text += fmt::format("\nimage_px = [{}, {}]", camera.image_px->x(), camera.image_px->y());
  return text + "\n";
}

std::string DataStripText(FrameSide side) {
  constexpr std::array kNames = {"left", "right", "bottom", "top"};
  return fmt::format("data_strip = \"{}\"\n", kNames.at(static_cast<size_t>(side)));
}

std::string BorderText(const BorderFeature& feature) {
  constexpr std::array kNames = {"text", "dark", "bright"};
  return "\n[[border]]\nshows = \"" + std::string(kNames.at(static_cast<size_t>(feature.shows))) +
         "\"\nfrom_mm = " + Text(feature.from_mm) + "\nto_mm = " + Text(feature.to_mm) + "\n";
}

std::string FiducialText(const Fiducial& fiducial) {
  std::string text =
      fmt::format("\n[[fiducials]]\nid = {}\nposition_mm = {}\nmark = {}\n", Text(fiducial.id),
                  Text(fiducial.position_mm), Text(fiducial.mark));
  if (fiducial.sigma_mm) text += fmt::format("sigma_mm = {}\n", Text(*fiducial.sigma_mm));
  if (!fiducial.symbol) return text;
  const MarkSymbol& symbol = *fiducial.symbol;
  text += symbol.kind == SymbolKind::kLines ? "symbol = { kind = \"lines\""
                                            : "symbol = { kind = \"dots\"";
  text += ", count = " + std::to_string(symbol.count);
  if (symbol.at_mm) text += ", at_mm = " + Text(*symbol.at_mm);
  if (symbol.step_mm) text += ", step_mm = " + Text(*symbol.step_mm);
  return text + " }\n";
}

std::string MarkText(const std::string& name, const MarkDrawing& mark, const fs::path& folder) {
  std::string text = fmt::format("\n[marks.{}]\n", Text(name));
  if (!mark.elements.empty()) text += "elements = [\n";
  for (const MarkElement& element : mark.elements) text += "  " + ElementText(element) + ",\n";
  if (!mark.elements.empty()) text += "]\n";
  text += mark.background == MarkBackground::kDark ? "background = \"dark\"\n"
                                                   : "background = \"image\"\n";
  if (mark.image)
    text += fmt::format("image = {}\npixel_size_mm = {}\ncentre_px = {}\n",
                        Text(fs::proximate(mark.image->path, folder).string()),
                        Text(mark.image->pixel_size_mm), Text(mark.image->centre_px));
  return text;
}

}  // namespace

std::string ElementText(const MarkElement& element) {
  const double brightness = BrightnessOf(element);
  return fmt::format("{{ shape = {}{} }}", std::visit(ShapeText(), element),
                     brightness == 1 ? "" : ", brightness = " + Text(brightness));
}

std::string CameraFileText(const CameraFile& camera, const std::string& folder) {
  std::string text = CameraText(camera.camera);
  if (camera.data_strip) text += DataStripText(*camera.data_strip);
  text += std::visit(DistortionText(), camera.camera.lens);
  if (camera.camera.earth_k1 != 0)
    text += "earth_k1 = " + Text(camera.camera.earth_k1) +
            "  # of the above: curvature and refraction, which belong to the flight\n";
  for (const Fiducial& fiducial : camera.fiducials) text += FiducialText(fiducial);
  for (const BorderFeature& feature : camera.border) text += BorderText(feature);
  for (const auto& [name, mark] : camera.marks) text += MarkText(name, mark, folder);
  return text;
}

void WriteCameraFile(const std::string& path, const CameraFile& camera) {
  WriteFileAtomically(path, CameraFileText(camera, fs::absolute(path).parent_path().string()));
}

}  // namespace orient
