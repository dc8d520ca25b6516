// What is known of a block's photos before they are oriented: its table, its photos' own files and
// its strips; and, as photos are oriented one after the other, what these tell of the others.
#pragma once

#include <map>
#include <set>
#include <string>
#include <vector>

#include "block/inputs/pose_observations.h"
#include "core/files/block_file.h"
#include "core/files/orientation_table.h"
#include "core/files/results.h"
#include "core/geometry/camera.h"
#include "core/measurements/measurements.h"

namespace orient::block {

// Whether a result may locate the other photos of its strip: one that is ok, or a weak one within 5
// sigma of the approximation `before` (null: there was none; with its sigma) that it was found
// from.
bool LocatesStrip(const ExteriorResult& result, const OrientationRow* before);

class BlockApproximations {
 public:
  // Reads the table and, for photos it lacks, GNSS and the photos' files; a position given by a
  // person takes precedence. Throws InputError for a table that cannot be read, and for
  // strips of which no photo is located.
  BlockApproximations(const BlockFile& block, const Camera& camera,
                      const Measurements& measurements = {});

  // Has a row for every photo of which anything is known.
  const OrientationTable& Table() const { return table_; }
  // What a person should know about them.
  const Findings& Remarks() const { return remarks_; }
  // Names in the tables of approximations and GNSS that are no photo of the block.
  const std::vector<std::string>& NotThere() const { return not_there_; }

  // Of the table, where its accuracy is stated.
  const PosePriors& Stated() const { return stated_; }
  // Observations of poses for the adjustment.
  const PoseObservations& Observations() const { return observations_; }

  // Photos that are oriented locate the others of their strips; those that may not (LocatesStrip)
  // are passed over.
  void Learn(const std::vector<ExteriorResult>& results);

  // Which of these photos to orient next, as indices: all that are known well; where there are
  // none, of each strip the one that is known best, since it tells where the others are.
  std::vector<std::size_t> Next(const std::vector<std::string>& open) const;

 private:
  std::set<std::string> PhotosAndPlaces() const;
  void ReadTable();
  void ReadFiles();
  void ApplyMeasurements(const Measurements& measurements);
  void Fill();
  OrientationRow WithSigma(OrientationRow row) const;
  double GroundUnder(const std::vector<OrientationRow>& rows) const;

  const BlockFile& block_;
  const Camera& camera_;
  std::vector<OrientationRow> known_;               // of the block's photos, by table or file
  std::map<std::string, OrientationRow> oriented_;  // since then
  std::set<std::string> computed_heights_;          // of known_, which the table lacks
  // Of photos that their strips locate, too.
  std::map<std::string, DecidedPosition> decided_positions_;
  PosePriors stated_;
  PoseObservations observations_;
  OrientationTable table_;                           // known_ and what fills the strips
  std::map<std::string, std::size_t> vague_strips_;  // photos known badly, with their strips
  Findings remarks_;
  std::vector<std::string> not_there_;
};

}  // namespace orient::block
