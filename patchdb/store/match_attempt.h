// One patch searched for in one photo.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>

namespace orient::patchdb {

// One patch searched for in one photo: what a photo's orientation reports back.
struct MatchAttempt {
  std::int64_t patch_id = 0;
  std::string photo;
  std::string state;  // PatchState's name
  std::optional<double> ncc;
  std::optional<Eigen::Vector2d> residual_px;
  std::string reason;
  std::optional<std::string> photo_date = {};    // ISO 8601, of the exposure
  std::optional<std::string> photo_status = {};  // ok, weak, failed: of the whole photo
  std::optional<Eigen::Vector2d> predicted_px = {}, found_px = {};
  std::string photo_digest = {};  // of its content: two flights may have photos of one name
  std::optional<Eigen::Vector2d> place_m = {};  // of the patch; absent: not said
};

// A patch of another database that was searched for in the same photo: a neighbour.
struct SoughtElsewhere {
  std::string photo;
  Eigen::Vector2d place_m = Eigen::Vector2d::Zero();
  bool matched = false;
};

}  // namespace orient::patchdb
