// Locates photos of which too little is known to use their neighbours' patches: by keypoints (SIFT)
// that they share with oriented photos.
#pragma once

#include <list>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "block/inputs/block_photos.h"
#include "block/inputs/scan_interior.h"
#include "block/stages/keypoint_file.h"
#include "block/stages/result_store.h"
#include "core/matching/keypoints.h"
#include "core/terrain/ground_surface.h"
#include "exterior/search/keypoint_pose.h"

namespace orient::block {

struct KeypointSetting {
  const CameraFile& camera;
  const interior::MarkShapes& marks;
  const GroundSurface& surface;  // under all oriented photos
  std::string interior_directory;
  std::string directory;  // for results
  Inputs inputs;          // what all photos share
  int jobs = 0;
};

class KeypointStage {
 public:
  explicit KeypointStage(const KeypointSetting& setting)
      : setting_(setting), store_(setting.directory, ".keypoints.json") {}

  // For a photo without a pose. It is compared with oriented photos in order of distance from the
  // approximation (null: from its place in the block), every other one from all over the block,
  // until what they share agrees on a pose.
  // Empty if it does not, the scan cannot be read, or all photos that it would be compared with
  // were compared in earlier calls. A result found from the same photos before is kept.
  std::optional<KeypointApproximation> Locate(std::size_t photo,
                                              const std::vector<BlockPhotoFile>& photos,
                                              const OrientationRow* approximation);
  // Photos that were asked for and whose keypoints agreed on nothing yet.
  const std::set<std::size_t>& InVain() const { return in_vain_; }
  // At the end: the results of requests that were not made this time.
  void RemoveUnused() const;

 private:
  // Of a whole photo, as coarse as they are searched for.
  struct OfPhoto {
    Keypoints keypoints;  // in scan pixels
    std::vector<exterior::FilmPosition> positions;
    Eigen::Vector2i scan_px = Eigen::Vector2i::Zero();
    double reduction = 1;
  };
  using Lenders = std::vector<std::size_t>;

  std::shared_ptr<const OfPhoto> Of(std::size_t photo, const std::vector<BlockPhotoFile>& photos);
  void Prepare(const Lenders& which, const std::vector<BlockPhotoFile>& photos);
  OfPhoto Find(const BlockPhotoFile& photo) const;
  std::vector<exterior::SharedKeypoint> Shared(const OfPhoto& photo, const OfPhoto& lender,
                                               const BlockPhotoFile& lender_file) const;
  std::optional<KeypointApproximation> Search(std::size_t photo,
                                              const std::vector<BlockPhotoFile>& photos,
                                              const Lenders& lenders);
  Inputs InputsOf(std::size_t photo, const std::vector<BlockPhotoFile>& photos,
                  const Lenders& lenders) const;

  KeypointSetting setting_;
  ResultStore store_;
  // By photo, those asked for last first.
  std::list<std::pair<std::size_t, std::shared_ptr<const OfPhoto>>> kept_;
  std::map<std::size_t, std::map<std::size_t, std::vector<exterior::SharedKeypoint>>>
      shared_;  // with each
  std::map<std::size_t, std::set<std::size_t>> asked_;
  std::set<std::size_t> in_vain_;
  std::set<std::string> used_;  // names of results
};

}  // namespace orient::block
