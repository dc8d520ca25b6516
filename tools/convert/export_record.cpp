#include "tools/convert/export_record.h"

#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>

#include "core/base/atomic_write.h"
#include "core/base/error.h"
#include "core/base/number_text.h"
#include "core/exchange/exchange_block.h"

namespace orient {
namespace {
namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr const char* kHeader = "image,x,y,z,file_x,file_y,file_z,col,row,x_mm,y_mm,c_mm,pixel_mm";
constexpr std::size_t kNumbers = 12;

std::string RecordPath(const std::string& directory) {
  return (fs::path(directory) / "export.json").string();
}

double Number(const std::string& word, const std::string& path, int line) {
  const auto number = NumberIn(word);
  if (!number)
    throw InputError(fmt::format("{}, line {}: \"{}\" must be a number", path, line, word));
  return *number;
}

VerificationRow ReadRow(const std::string& text, const std::string& path, int line) {
  // The image's name may hold commas: the numbers are the last twelve cells.
  std::vector<std::string> cells;
  std::string rest = text;
  for (std::size_t i = 0; i < kNumbers; ++i) {
    const auto comma = rest.rfind(',');
    if (comma == std::string::npos)
      throw InputError(
          fmt::format("{}, line {}: the line has too few cells; they are {}", path, line, kHeader));
    cells.insert(cells.begin(), rest.substr(comma + 1));
    rest.resize(comma);
  }
  std::vector<double> v;
  for (const std::string& cell : cells) v.push_back(Number(cell, path, line));
  return {rest, {v[0], v[1], v[2]}, {v[3], v[4], v[5]}, {v[6], v[7]}, {v[8], v[9]}, v[10], v[11]};
}

}  // namespace

void WriteExportRecord(const std::string& directory, const ExportRecord& record) {
  Json json = {
      {"format", record.format},
      {"crs", record.crs ? Json(record.crs->Wkt()) : Json(nullptr)},
      {"origin", {record.origin.x(), record.origin.y(), record.origin.z()}},
      {"geoid_m", record.geoid_m},
      {"ground_height_m", record.ground_height_m ? Json(*record.ground_height_m) : Json(nullptr)},
      {"earth", Json::array()}};
  for (const EarthRecord& earth : record.earth)
    json["earth"].push_back({{"in_lens", earth.in_lens}, {"taken_out", earth.taken_out}});
  if (!record.names.empty()) json["names"] = record.names;
  json["files"] = record.files;
  WriteFileAtomically(RecordPath(directory), json.dump(2) + "\n");
}

ExportRecord ReadExportRecord(const std::string& directory) {
  ExportRecord record;
  const std::string path = RecordPath(directory);
  if (!fs::exists(path)) return record;
  try {
    const Json json = Json::parse(ReadFile(path));
    record.format = json.at("format").get<std::string>();
    if (!json.at("crs").is_null()) record.crs = Crs::Parse(json.at("crs").get<std::string>(), path);
    if (json.at("origin").size() != 3)
      throw InputError(path + ": origin must have three numbers; convert again");
    for (int i = 0; i < 3; ++i)
      record.origin[i] = json.at("origin").at(static_cast<std::size_t>(i)).get<double>();
    record.geoid_m = json.at("geoid_m").get<double>();
    if (!json.at("ground_height_m").is_null())
      record.ground_height_m = json.at("ground_height_m").get<double>();
    if (json.contains("earth"))
      for (const Json& earth : json.at("earth"))
        record.earth.push_back(
            {earth.at("in_lens").get<double>(), earth.at("taken_out").get<double>()});
    if (json.contains("names"))
      record.names = json.at("names").get<std::map<std::string, std::string>>();
    if (json.contains("files")) record.files = json.at("files").get<std::set<std::string>>();
  } catch (const Json::exception& error) {
    throw InputError(path + " is damaged; convert again: " + error.what());
  }
  return record;
}

void WriteVerification(const std::string& directory, const std::vector<VerificationRow>& rows) {
  std::string text = std::string(kHeader) + "\n";
  for (const VerificationRow& row : rows) {
    text += row.image;
    for (const double value :
         {row.block_m.x(), row.block_m.y(), row.block_m.z(), row.file_m.x(), row.file_m.y(),
          row.file_m.z(), row.pixel.x(), row.pixel.y(), row.reduced_mm.x(), row.reduced_mm.y(),
          row.principal_distance_mm, row.pixel_mm}) {
      text += ',';
      text += ExactNumber(value);
    }
    text += '\n';
  }
  WriteFileAtomically(VerificationPath(directory), text);
}

std::string VerificationPath(const std::string& directory) {
  return (fs::path(directory) / "verification.csv").string();
}

std::vector<VerificationRow> ReadVerification(const std::string& path) {
  std::istringstream stream(ReadFile(path));
  std::string line;
  if (!std::getline(stream, line) || line != kHeader)
    throw InputError(path + ", line 1: the header must be " + kHeader);
  std::vector<VerificationRow> rows;
  for (int number = 2; std::getline(stream, line); ++number)
    if (!line.empty()) rows.push_back(ReadRow(line, path, number));
  if (rows.empty()) throw InputError(path + " holds no verification point");
  return rows;
}

}  // namespace orient
