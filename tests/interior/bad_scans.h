// Scans that interior orientation should not be taken in by: what is known of each, what it
// becomes, and what the result is worth. A result may be weak or failed with a reason; `ok` must be
// right.
#pragma once

#include <gtest/gtest.h>

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "interior/interior.h"
#include "tests/support/scan_making.h"
#include "tests/support/shared_data.h"

namespace orient::interior {

inline constexpr float kWhiteBed = 250, kBlackBed = 18;

// A scan, the camera file that belongs to it, and what is known of the way the film lies.
struct KnownScan {
  std::string name;
  TrueScan scan;
  CameraFile camera;
  double pixel_mm = 0.1;
  // Real frames: their orientation was not measured, any of the eight will do.
  bool any_way = false;
};

// What a scan becomes and how it is read.
struct Trial {
  TrueScan scan;
  const KnownScan* of = nullptr;
  const CameraFile* read_as = nullptr;  // empty: with its own camera file
  std::optional<Eigen::Vector2d> dpi;   // empty: the right one
  InteriorOptions options = {};
  bool one_bit = false;
  double share_of_file = 1;  // the rest is cut off
  // No transform could be right: nothing on the scan, or two films with equal claims.
  bool no_answer = false;
};

CameraFile LibraryCamera(const std::string& name);

// A film of any camera, turned and shifted a little, with its marks or without them. A reseau's
// crosses lie in the picture, all other marks on dark ground.
KnownScan SimulatedOf(const std::string& name, const CameraFile& camera, double pixel_mm,
                      unsigned seed, bool marks, const std::vector<int>& missing = {});

// A real frame; its truth are the hand marks in the corners or in the middles of the sides, so many
// mm from the axes (the other one 0).
KnownScan RealFrame(const std::string& folder, const std::string& frame, const std::string& camera,
                    double corner_mm, double side_mm);

Trial With(const KnownScan& known, TrueScan scan);
Trial Plain(const KnownScan& known);
int Pixels(const KnownScan& known, double mm);
std::vector<std::pair<std::string, Margins>> Cuts(int px);
std::vector<std::pair<std::string, Trial>> Ways(const KnownScan& known);
std::vector<std::pair<std::string, std::optional<Eigen::Vector2d>>> NonsenseTags(
    const KnownScan& known);
Trial Tagged(const KnownScan& known, const std::optional<Eigen::Vector2d>& dpi);
Trial OneBit(const KnownScan& known, std::optional<float> threshold);
// The next frame of the film to the right or below, half of it in view.
Trial WithNeighbour(const KnownScan& known, const Image& next, bool below, double share);
// The middle of two frames: half of either.
Trial HalfAndHalf(const KnownScan& known, const Image& next);

// One line of the table.
struct Row {
  int scans = 0, ok_right = 0, ok_wrong = 0, weak_right = 0, weak_wrong = 0, failed = 0;

  void Print(const std::string& name) const;
};

// Orients what scans become, and counts; prints its line of the table at the end.
class BadScans : public testing::Test {
 protected:
  ~BadScans() override;

  void Try(const std::string& what, const Trial& trial);
  // A file as it is; the trial says what is known of it.
  void TryFile(const std::string& what, const std::string& path, const Trial& trial);

 private:
  void Count(const std::string& what, const Trial& trial, const CameraFile& camera,
             const InteriorResult& found);

  TemporaryFolder folder_;
  Row row_;
};

}  // namespace orient::interior
