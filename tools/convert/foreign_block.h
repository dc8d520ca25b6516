// Another program's files as an exchange block in their own ground system.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/exchange/exchange_block.h"
#include "tools/convert/exchange_format.h"
#include "tools/convert/export_record.h"

namespace orient {

struct ForeignBlock {
  ExchangeBlock block;
  bool geocentric =
      false;  // else topocentric where block.reference_lla says so, else the block's CRS
  Eigen::Vector3d frame_origin = Eigen::Vector3d::Zero();  // to be added to the file's coordinates
  bool origin_unknown = false;        // of a format whose coordinates usually have one
  std::vector<std::string> messages;  // what was taken for granted, what was left out
  // Why the poses may lie where they cannot be, and what to do then.
  std::string if_misplaced = "their origin is missing; give it with --origin";
};

// What the file may not say itself.
struct ForeignOptions {
  std::optional<Crs> crs;                 // the block's
  std::optional<Eigen::Vector2d> offset;  // of an OpenSfM reconstruction that is projected
};

// Throws InputError naming file, line and value, also where what was read cannot be (RequireSound).
ForeignBlock ReadForeignBlock(ExchangeFormat format, const std::string& input,
                              const ExportRecord& record, const ForeignOptions& options);

}  // namespace orient
