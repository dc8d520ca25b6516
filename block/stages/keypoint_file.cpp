#include "block/stages/keypoint_file.h"

#include <nlohmann/json.hpp>

#include "core/base/atomic_write.h"
#include "core/base/error.h"

namespace orient::block {
using Json = nlohmann::ordered_json;

void WriteKeypointResult(const std::string& path, const Inputs& made_from,
                         const std::optional<KeypointApproximation>& found) {
  Json json = {{"made_from", made_from}};
  if (found) {
    const Vector6d pose = found->row.pose.AsVector(), sigma = found->row.sigma.value();
    json["keypoints"] = found->keypoints;
    json["pose"] = std::vector<double>(pose.begin(), pose.end());
    json["sigma"] = std::vector<double>(sigma.begin(), sigma.end());
  }
  WriteFileAtomically(path, json.dump(1) + "\n");
}

std::optional<KeypointApproximation> ReadKeypointResult(const std::string& path,
                                                        const std::string& photo) {
  try {
    const Json json = Json::parse(ReadFile(path));
    if (!json.contains("keypoints")) return std::nullopt;
    Vector6d pose, sigma;
    for (int i = 0; i < 6; ++i) {
      pose[i] = json.at("pose").at(i).get<double>();
      sigma[i] = json.at("sigma").at(i).get<double>();
    }
    KeypointApproximation found;
    found.row.photo = photo;
    found.row.pose = {pose.head<3>(), pose.tail<3>()};
    found.row.sigma = sigma;
    found.keypoints = json.at("keypoints").get<int>();
    return found;
  } catch (const Json::exception& error) {
    throw InputError(path + ": " + error.what() + "; remove the file and run the block again");
  }
}

}  // namespace orient::block
