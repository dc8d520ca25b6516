// Where photos lie of which too little is known for their neighbours' patches: keypoints (SIFT)
// that they share with photos that are oriented.
#pragma once

#include <list>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/files/orientation_table.h"
#include "core/geometry/ground_surface.h"
#include "core/imaging/keypoints.h"
#include "exterior/keypoint_pose.h"
#include "tools/block/block_photos.h"
#include "tools/block/stage_folder.h"
#include "tools/scan_interior.h"

namespace orient {

struct KeypointSetting {
  const CameraFile& camera;
  const MarkShapes& marks;
  const GroundSurface& surface;  // under all oriented photos
  std::string interior_directory;
  std::string directory;  // for results
  std::string inputs;     // digest of what all photos share
  int jobs = 0;
};

struct KeypointApproximation {
  OrientationRow row;
  int keypoints = 0;  // that agree on it
};

class KeypointStage {
 public:
  explicit KeypointStage(const KeypointSetting& setting)
      : setting_(setting), folder_(setting.directory, ".keypoints") {}

  // Of a photo without a pose. Oriented photos are asked in the order of their distance from the
  // approximation (null: of their places in the block), every other one from all over the block,
  // until what they share agrees on a pose.
  // Empty where it does not, the scan cannot be read, or no photo was oriented since the last time
  // that is not farther than those asked then. What was found from the same photos before is kept.
  std::optional<KeypointApproximation> Locate(std::size_t photo,
                                              const std::vector<BlockPhotoFile>& photos,
                                              const OrientationRow* approximation);
  // Photos that were asked for and whose keypoints agreed on nothing yet.
  const std::set<std::size_t>& InVain() const { return in_vain_; }
  // At the end: the results of requests that were not made this time.
  void RemoveUnused() const;

 private:
  // Of a whole photo, as coarse as they are sought.
  struct OfPhoto {
    Keypoints keypoints;  // in scan pixels
    std::vector<FilmPosition> positions;
    Eigen::Vector2i scan_px = Eigen::Vector2i::Zero();
    double reduction = 1;
  };
  using Lenders = std::vector<std::size_t>;

  std::shared_ptr<const OfPhoto> Of(std::size_t photo, const std::vector<BlockPhotoFile>& photos);
  void Prepare(const Lenders& which, const std::vector<BlockPhotoFile>& photos);
  OfPhoto Find(const BlockPhotoFile& photo) const;
  std::vector<SharedKeypoint> Shared(const OfPhoto& photo, const OfPhoto& lender,
                                     const BlockPhotoFile& lender_file) const;
  std::optional<KeypointApproximation> Search(std::size_t photo,
                                              const std::vector<BlockPhotoFile>& photos,
                                              const Lenders& lenders);
  std::string DigestOf(std::size_t photo, const std::vector<BlockPhotoFile>& photos,
                       const Lenders& lenders) const;

  KeypointSetting setting_;
  StageFolder folder_;
  // By photo, those asked for last first.
  std::list<std::pair<std::size_t, std::shared_ptr<const OfPhoto>>> kept_;
  std::map<std::size_t, std::map<std::size_t, std::vector<SharedKeypoint>>> shared_;  // with each
  std::map<std::size_t, std::set<std::size_t>> asked_;
  std::set<std::size_t> in_vain_;
  std::set<std::string> used_;  // names of results
};

}  // namespace orient
