#include "block/ties/tie_file.h"

#include <nlohmann/json.hpp>

#include "core/base/atomic_write.h"
#include "core/base/error.h"

namespace orient::block {
namespace {
using Json = nlohmann::ordered_json;

Json TieJson(const TieRecord& tie) {
  Json seen = Json::array();
  for (const SightingRecord& sighting : tie.seen) {
    const Eigen::Matrix2d& c = sighting.covariance_px2;
    seen.push_back({{"photo", sighting.photo},
                    {"pixel", {sighting.pixel.x(), sighting.pixel.y()}},
                    {"covariance_px2", {c(0, 0), c(0, 1), c(1, 1)}},
                    {"ncc", sighting.ncc}});
  }
  return {{"ground", {tie.ground_m.x(), tie.ground_m.y(), tie.ground_m.z()}},
          {"seen", std::move(seen)}};
}

TieRecord ReadTie(const Json& json) {
  TieRecord tie;
  for (int i = 0; i < 3; ++i) tie.ground_m[i] = json.at("ground").at(i).get<double>();
  for (const Json& seen : json.at("seen")) {
    SightingRecord sighting;
    sighting.photo = seen.at("photo").get<std::string>();
    for (int i = 0; i < 2; ++i) sighting.pixel[i] = seen.at("pixel").at(i).get<double>();
    const Json& c = seen.at("covariance_px2");
    const double col = c.at(0).get<double>(), cross = c.at(1).get<double>();
    const double row = c.at(2).get<double>();
    sighting.covariance_px2 << col, cross, cross, row;
    sighting.ncc = seen.at("ncc").get<double>();
    tie.seen.push_back(sighting);
  }
  return tie;
}

}  // namespace

void WriteTieFile(const std::string& path, const std::string& owner, const Inputs& made_from,
                  const std::vector<TieRecord>& ties) {
  Json list = Json::array();
  for (const TieRecord& tie : ties) list.push_back(TieJson(tie));
  const Json json = {{"photo", owner}, {"made_from", made_from}, {"ties", std::move(list)}};
  WriteFileAtomically(path, json.dump(1) + "\n");
}

std::vector<TieRecord> ReadTieFile(const std::string& path) {
  try {
    const Json json = Json::parse(ReadFile(path));
    std::vector<TieRecord> ties;
    for (const Json& tie : json.at("ties")) ties.push_back(ReadTie(tie));
    return ties;
  } catch (const nlohmann::json::exception& error) {
    throw InputError(path + ": " + error.what() + "; remove the file and run the block again");
  }
}

}  // namespace orient::block
