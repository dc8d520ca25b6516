// What is known of a block's poses beside what the photos show, as observations of the adjustment:
// approximations whose accuracy is stated, and GNSS.
#pragma once

#include <map>
#include <set>
#include <string>
#include <vector>

#include "core/files/block_file.h"
#include "core/files/finding.h"
#include "core/files/orientation_table.h"
#include "core/geometry/gnss.h"
#include "core/geometry/resection.h"

namespace orient::block {

using PosePriors = std::map<std::string, PosePrior>;  // by photo

struct PoseObservations {
  PosePriors approximations;
  // By photo, too.
  std::map<std::string, GnssPosition> gnss;
  std::map<std::string, std::string> strip;  // of GNSS
  GnssModel model = GnssModel::kShift;

  bool Empty() const { return approximations.empty() && gnss.empty(); }
};

// The block's GNSS positions, each with its sigmas; empty where the block has none. Rows that
// leave a coordinate empty are named in `remarks`. Throws InputError where the table cannot be
// read, has no whole position, is in another CRS or has no stated accuracy.
std::vector<OrientationRow> ReadGnss(const BlockFile& block, Findings* remarks);

// Throws InputError where most positions agree with those of `table`, the block's approximations,
// only if x and y are exchanged.
void RefuseExchangedAxes(const BlockFile& block, const std::vector<OrientationRow>& table,
                         const std::vector<OrientationRow>& gnss);

// Positions of photos that the approximations lack. A strip's shift is unknown: a position is as
// good as one of a camera's own receiver.
void AddGnssPositions(const std::vector<OrientationRow>& gnss,
                      std::vector<OrientationRow>* approximations);

// Priors for rows of a table of approximations if table or block file states the accuracy; unknown
// elements, and heights of `computed` photos, which the table lacks, get practically no weight.
PosePriors StatedApproximations(const BlockFile& block, const std::vector<OrientationRow>& table,
                                const std::set<std::string>& computed);

// `stated` approximations, if the block file asks for them, and GNSS. What strips or EXIF say is
// for where to search. Throws InputError where the block file asks for observed approximations and
// there are none.
PoseObservations ObservationsOf(const BlockFile& block, const PosePriors& stated,
                                const std::vector<OrientationRow>& gnss);

}  // namespace orient::block
